"""Answers only the page of this machine, by its token.

A page of another origin may send requests to 127.0.0.1, and a name of another host may be made to point there (DNS
rebinding). So the token is the first part of every path, the host must be this machine's, an origin that a browser names
must be the page's own, and a request that changes something must be JSON, which another origin cannot send unasked.
"""

import asyncio
import math
from collections.abc import Iterable
from secrets import compare_digest
from typing import Any

import h11
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect, Request
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from driftform.errors import InputError

MAX_BODY = 1_000_000
"""Largest request that is read, bytes: a study of a thousand targets is a tenth of it."""

MAX_FILE = 40_000_000
"""Largest request with a file, bytes: a grid of a million nodes as NetCDF is two thirds of it."""

PATIENCE_S = 10.0
"""Time that a request may take to arrive, s: on one machine it takes milliseconds."""

MAX_NUMBER = 2**53
"""Largest whole number that JavaScript, which wrote the requests of the page, counts exactly."""

HEADERS = {
    "content-security-policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "cache-control": "no-store",
}
"""Of every answer that does not set its own: the page loads nothing from elsewhere, and runs no script of a name."""


class Guard:
    """An ASGI application that refuses foreign requests, and passes the others on without the token in their path."""

    def __init__(self, app: ASGIApp, token: str, hosts: Iterable[str]) -> None:
        self._app = app
        self._token = token.encode()
        self._hosts = frozenset(hosts)
        self._origins = frozenset(f"http://{host}" for host in self._hosts)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        if scope["type"] != "http":
            return
        refusal = self._refuse(scope)
        if refusal is None and scope["method"] not in ("GET", "HEAD"):
            largest = MAX_FILE if scope["path"].endswith("/api/files") else MAX_BODY
            receive, refusal = await _read_body(Request(scope, receive), largest)
        if refusal is not None:
            await refusal(scope, receive, send_with_headers)
            return
        # Routes match what follows the root path.
        token = scope["path"].removeprefix("/").partition("/")[0]
        await self._app({**scope, "root_path": f"/{token}"}, receive, send_with_headers)

    def _refuse(self, scope: Scope) -> Response | None:
        """Return the refusal of a foreign request, ``None`` for one of the page."""
        headers = Headers(scope=scope)
        for key in ("host", "origin"):
            # A browser sends one of each: with two it is unclear which counts.
            if len(headers.getlist(key)) > 1:
                return _refuse(400, f"two headers '{key}'")
        if headers.get("host") not in self._hosts:
            return _refuse(403, "this server answers only under its own address, on this machine")
        if "origin" in headers and headers["origin"] not in self._origins:
            return _refuse(403, "this server answers its own page only")
        token = scope["path"].removeprefix("/").partition("/")[0]
        if not compare_digest(token.encode(), self._token):
            return _refuse(403, "the token is missing: open the address that 'driftform studio' printed")
        # Anything but a form, which another origin may send; routes know no method but GET and POST.
        is_asking = scope["method"] in ("GET", "HEAD")
        if not is_asking and headers.get("content-type") != "application/json":
            return _refuse(415, "a request must be application/json")
        return None


async def _read_body(request: Request, largest: int) -> tuple[Receive, Response | None]:
    """Return the body as one message, or the refusal of a large one, which is not read to its end."""
    body = bytearray()
    try:
        async for part in request.stream():
            body += part
            if len(body) > largest:
                return request.receive, _refuse(413, f"the request is larger than {largest // 1000} kB")
    except ClientDisconnect:
        return request.receive, _refuse(400, "the request was cut short")

    async def replay() -> Message:
        return {"type": "http.request", "body": bytes(body), "more_body": False}

    return replay, None


class HurriedProtocol(H11Protocol):
    """HTTP as uvicorn speaks it, but a request that is not complete after :data:`PATIENCE_S` ends its connection."""

    _limit: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a request."""
        super().connection_made(transport)
        self._wait()

    def data_received(self, data: bytes) -> None:
        """Read on, and wait no longer once a request is complete."""
        super().data_received(data)
        if self.conn.their_state in (h11.IDLE, h11.SEND_BODY):
            self._wait()
        else:
            self._stop_waiting()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._stop_waiting()
        super().connection_lost(exc)

    def _wait(self) -> None:
        if self._limit is None:
            self._limit = self.loop.call_later(PATIENCE_S, self.transport.abort)

    def _stop_waiting(self) -> None:
        if self._limit is not None:
            self._limit.cancel()
            self._limit = None


def check_values(document: Any) -> None:
    """Check that a document of JSON holds numbers and texts that a study can hold.

    Raises InputError if a number is too large to be exact, or not finite, or a text cannot be written down.
    """
    if isinstance(document, dict | list):
        for item in [*document, *document.values()] if isinstance(document, dict) else document:
            check_values(item)
    elif isinstance(document, str):
        if not document.isprintable() and any("\ud800" <= letter <= "\udfff" for letter in document):
            raise InputError("the request holds half of a character")
    elif isinstance(document, int | float) and not (math.isfinite(document) and abs(document) <= MAX_NUMBER):
        raise InputError(f"the request holds the number {document:.3g}, which is too large")


def _refuse(status: int, reason: str) -> Response:
    return PlainTextResponse(f"driftform studio: {reason}\n", status, headers={"connection": "close"})
