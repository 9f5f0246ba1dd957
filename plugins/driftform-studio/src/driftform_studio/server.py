"""``driftform studio``: one server on this machine, for one folder of runs."""

import os
import secrets
import socket
import sys
import threading
import webbrowser
from collections.abc import Callable
from pathlib import Path

import uvicorn

from driftform.errors import InputError
from driftform_studio.app import Studio, make_app
from driftform_studio.folder import REDIRECT, RunsFolder
from driftform_studio.guard import Guard, HurriedProtocol

HOST = "127.0.0.1"
"""The only address that the server listens at: it is reached from this machine alone."""


def serve(folder: Path, port: int | None, announce: Callable[[str], None], browser: bool) -> None:
    """Serve the page until it is interrupted; searches continue.

    ``port`` is ``None`` for the one that the folder's page had before, or else any free one; ``announce`` is called with the
    address once the server listens. Raises InputError if the port is taken, or the folder cannot be written to.
    """
    runs = RunsFolder(folder)
    token, before = runs.read_address()
    listener = _listen(port, before)
    actual = listener.getsockname()[1]
    if actual != before:
        # Another program on the old port receives the requests of open pages, with their token.
        token = secrets.token_hex(16)
    runs.write_address(token, actual)
    address = f"http://{HOST}:{actual}/{token}/"
    studio = Studio(runs, folder)
    guard = Guard(make_app(studio), token, (f"{HOST}:{actual}", f"localhost:{actual}"))
    config = uvicorn.Config(
        guard,
        http=HurriedProtocol,
        ws="none",
        lifespan="off",
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        timeout_graceful_shutdown=1,
    )
    server = uvicorn.Server(config)
    announce(address)
    if browser:
        redirect = runs.write_redirect(address)
        threading.Thread(target=webbrowser.open, args=(redirect.as_uri(),), daemon=True).start()
    try:
        server.run(sockets=[listener])
    except KeyboardInterrupt:
        pass
    finally:
        (runs.path / REDIRECT).unlink(missing_ok=True)
        alive = studio.searches.count_alive()
        studio.close()
        if alive:
            searches = "1 search continues" if alive == 1 else f"{alive} searches continue"
            print(f"{searches}; watch with 'driftform watch RUN', or with the page", file=sys.stderr)


def _listen(port: int | None, before: int) -> socket.socket:
    """Return a socket that listens at a port, or at the one before if it is free, or else at any."""
    for number in (port,) if port is not None else (before, 0):
        try:
            return socket.create_server((HOST, number), backlog=128)
        except OSError as error:
            if port is not None:
                raise InputError(f"--port {port}: {os.strerror(error.errno or 0)}; choose another one") from None
    raise AssertionError("port 0 is any free one")
