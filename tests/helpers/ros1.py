"""Programs of ROS 1 in tests: a master that runs, and what listens to topics."""

import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from json import loads
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

LISTENER = Path(__file__).parent / "listen.py"


@contextmanager
def run_master(environment: dict[str, str]) -> Iterator[tuple[dict[str, str], subprocess.Popen[str]]]:
    """Yield the environment of ROS with a master that runs, and its process."""
    with socket.socket() as free:
        free.bind(("localhost", 0))
        port = free.getsockname()[1]
    found = environment | {"ROS_MASTER_URI": f"http://localhost:{port}"}
    with (
        start("roscore", "-p", str(port), env=found) as process,
        ServerProxy(found["ROS_MASTER_URI"]) as master,
    ):
        # The log is the last that roscore starts.
        wait_for(lambda: "/rosout" in str(master.lookupNode("/test", "/rosout")))
        yield found, process


@contextmanager
def start(*command: str, **options: Any) -> Iterator[subprocess.Popen[str]]:
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "encoding": "utf-8"}
    process: subprocess.Popen[str] = subprocess.Popen(command, **pipes, **options)
    try:
        yield process
    finally:
        if process.poll() is None:
            process.terminate()
            process.communicate(timeout=20)
        for pipe in (process.stdin, process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()


def wait_for(happens: Callable[[], bool], seconds: float = 60.0) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        try:
            if happens():
                return
        except OSError:
            pass
        time.sleep(0.1)
    raise AssertionError(f"{happens} has not happened within {seconds} s")


@contextmanager
def listen(environment: dict[str, str], *arguments: str) -> Iterator[Callable[[], dict[str, Any]]]:
    """Yield a function that ends listening and returns what was received."""
    with start("/usr/bin/python3", str(LISTENER), *arguments, env=environment) as process:
        assert process.stdin is not None and process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        yield lambda: loads(process.communicate("end\n", timeout=20)[0])
