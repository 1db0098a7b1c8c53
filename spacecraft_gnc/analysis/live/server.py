"""Local web server of the live view: fixed paths, server-sent events, a few commands.

It serves no files of the user, answers only requests that name this machine (a page elsewhere could
otherwise reach it by a name that it makes point here: DNS rebinding), sends no CORS header, and
takes commands as JSON from its own page only. Connections, bytes and time of a request are bounded;
whatever is refused is answered with one line.
"""

from __future__ import annotations

import errno
import json
import os
import socket
import threading
from collections.abc import Mapping
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from importlib import resources
from io import BufferedReader
from typing import TYPE_CHECKING, Any, ClassVar, Final

from spacecraft_gnc.analysis.live.bounded import (
    REQUEST_TIME,
    BoundedServer,
    RequestReader,
    TooLate,
    TooLong,
)
from spacecraft_gnc.analysis.live.feed import Feed
from spacecraft_gnc.analysis.live.hosts import host_is_ours, url_host
from spacecraft_gnc.errors import GncError, ParameterError

if TYPE_CHECKING:
    from typing_extensions import Self

DEFAULT_PORT: Final = 8760
_MOST_WATCHERS: Final = 32
_MOST_BYTES: Final = 1024  # of a command
_MOST_BRACKETS: Final = 8  # in a command, which nests nothing
_PATIENCE: Final = 20.0  # [s] for a client to take what it is sent
_PLAIN: Final = "text/plain; charset=utf-8"
_PAGE: Final = resources.files("spacecraft_gnc.analysis.live") / "page"
_FILES: Final = {
    "/": ("index.html", "text/html; charset=utf-8"),
    "/view.css": ("view.css", "text/css; charset=utf-8"),
    "/view.js": ("view.js", "text/javascript; charset=utf-8"),
    "/camera.js": ("camera.js", "text/javascript; charset=utf-8"),
    "/scene.js": ("scene.js", "text/javascript; charset=utf-8"),
    "/bodies.js": ("bodies.js", "text/javascript; charset=utf-8"),
    "/craft.js": ("craft.js", "text/javascript; charset=utf-8"),
    "/charts.js": ("charts.js", "text/javascript; charset=utf-8"),
    "/panels.js": ("panels.js", "text/javascript; charset=utf-8"),
    "/status.js": ("status.js", "text/javascript; charset=utf-8"),
}
_HEADERS: Final = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
        "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


class PortTaken(GncError):
    """Another process listens there."""


class PageServer:
    """Serves the page of a feed. Use it as a context manager.

    Parameters
    ----------
    feed
        What is shown.
    host
        Address to listen on.
    port
        None: `DEFAULT_PORT`, or any free one.
    patience
        Wall time for a client to send its request [s].

    Raises
    ------
    PortTaken
        The port asked for cannot be had.
    """

    def __init__(
        self,
        feed: Feed,
        host: str = "127.0.0.1",
        port: int | None = None,
        patience: float = REQUEST_TIME,
    ) -> None:
        watchers = threading.BoundedSemaphore(_MOST_WATCHERS)
        members = {"feed": feed, "bound_host": host, "watchers": watchers, "patience": patience}
        handler = type("_BoundHandler", (_Handler,), members)
        self._server = _listen(handler, host, port)
        self._feed = feed
        self.host = host
        self.port = int(self._server.server_address[1])
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    @property
    def url(self) -> str:
        """Where a browser on this machine finds the page."""
        return f"http://{url_host(self.host)}:{self.port}/"

    def __enter__(self) -> Self:
        """Start to serve."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Let the watchers go and stop."""
        self._feed.close()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Server6(BoundedServer):
    address_family = socket.AF_INET6


def _listen(handler: Any, host: str, port: int | None) -> BoundedServer:
    kind = _Server6 if ":" in host else BoundedServer
    wanted = (DEFAULT_PORT, 0) if port is None else (port,)
    for last, candidate in ((p == wanted[-1], p) for p in wanted):
        try:
            return kind((host, candidate), handler)
        except OSError as error:
            if last or error.errno != errno.EADDRINUSE:
                raise refused(host, candidate, error) from error
    raise AssertionError  # the last candidate returned or raised


def refused(host: str, port: int, error: OSError) -> PortTaken:
    """Return the error to raise where a server cannot listen."""
    if error.errno == errno.EADDRINUSE:
        return PortTaken(
            f"--port: received {port}, where another process listens; required a free port; choose "
            "another, or leave --port out to take a free one"
        )
    if error.errno == errno.EACCES:
        return PortTaken(
            f"--port: received {port}, which this user may not use; required 1024 to 65535"
        )
    reason = os.strerror(error.errno) if error.errno and error.errno > 0 else str(error)
    return PortTaken(
        f"--host: received {host!r}, where nobody can listen ({reason}); required an address of "
        "this machine such as 127.0.0.1"
    )


class _Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    feed: ClassVar[Feed]
    bound_host: ClassVar[str]
    watchers: ClassVar[threading.BoundedSemaphore]
    patience: ClassVar[float]
    server_version = "spacecraft_gnc"
    sys_version = ""
    request_version = "HTTP/1.0"  # until a request says so
    default_request_version = "HTTP/1.0"  # answers of version 0.9 would have no status
    requestline = ""
    command = ""

    def setup(self) -> None:
        """Bound what is read."""
        super().setup()
        self.rfile = BufferedReader(RequestReader(self.connection, self.patience))

    def handle(self) -> None:
        """Answer the one request of a connection."""
        try:
            super().handle()
        except TooLate:
            self._answer(HTTPStatus.REQUEST_TIMEOUT, f"no request within {self.patience:g} s\n")
        except TooLong:
            self._answer(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, "too long a request\n")

    def do_GET(self) -> None:
        """Serve the page, or its events."""
        path = self.path.partition("?")[0]
        if not host_is_ours(self.headers.get("Host"), self.bound_host):
            self._answer(HTTPStatus.MISDIRECTED_REQUEST, "this machine has another name\n")
        elif path == "/events":
            self._serve_events()
        elif path in _FILES:
            name, kind = _FILES[path]
            self._answer(HTTPStatus.OK, (_PAGE / name).read_text(encoding="utf-8"), kind)
        else:
            self._answer(HTTPStatus.NOT_FOUND, "no such page\n")

    def do_POST(self) -> None:
        """Take a command of the page."""
        host = self.headers.get("Host")
        if not host_is_ours(host, self.bound_host):
            self._answer(HTTPStatus.MISDIRECTED_REQUEST, "this machine has another name\n")
        elif self.path != "/control":
            self._answer(HTTPStatus.NOT_FOUND, "no such page\n")
        elif not self._is_own_page(str(host)):
            self._answer(HTTPStatus.FORBIDDEN, "commands come from the page itself\n")
        else:
            self._take_command()

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Answer what is no request with one line, too."""
        status = HTTPStatus(code)
        self._answer(status, f"{explain or message or status.phrase}\n")

    def log_message(self, *_: Any) -> None:
        """Say nothing: requests are no news."""

    def _is_own_page(self, host: str) -> bool:
        # Another site can post plain text without asking, but neither JSON nor a foreign Origin.
        origin = self.headers.get("Origin")
        return self.headers.get_content_type() == "application/json" and (
            origin is None or origin == f"http://{host}"
        )

    def _take_command(self) -> None:
        length = self.headers.get("Content-Length") or "0"
        try:
            size = int(length)
            if size > _MOST_BYTES:
                text = f"received {size} bytes; required 1 to {_MOST_BYTES}\n"
                self._answer(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, text)
                return
            command = self._read_command(size)
            value = command.get("value")
            self.feed.control(str(command.get("action")), None if value is None else float(value))
        except (ValueError, TypeError, OverflowError, ParameterError) as error:
            self._answer(HTTPStatus.BAD_REQUEST, f"{error}\n")
        else:
            self._answer(HTTPStatus.OK, "{}\n", "application/json")

    def _read_command(self, size: int) -> Mapping[str, Any]:
        if size <= 0:
            raise ValueError(f"received {size} bytes; required 1 to {_MOST_BYTES}")
        data = self.rfile.read(size)
        brackets = data.count(b"[") + data.count(b"{")
        if brackets > _MOST_BRACKETS:  # the parser would run out of stack at a thousand
            raise ValueError(
                f"received {brackets} opening brackets; required {_MOST_BRACKETS} at most"
            )
        command = json.loads(data)
        if not isinstance(command, dict):
            raise TypeError("received no JSON object; required one with an action")
        return command

    def _serve_events(self) -> None:
        if not self.watchers.acquire(blocking=False):
            self._answer(HTTPStatus.SERVICE_UNAVAILABLE, "too many watchers\n")
            return
        try:
            self._begin(HTTPStatus.OK, "text/event-stream")
            for event in self.feed.events():
                self.wfile.write(event.encode())
        finally:
            self.watchers.release()

    def _answer(self, status: HTTPStatus, text: str, kind: str = _PLAIN) -> None:
        if kind == _PLAIN:
            text = " ".join(text.split()) + "\n"  # it may quote what was sent
        body = text.encode(errors="backslashreplace")
        self._begin(status, kind, len(body))
        self.wfile.write(body)

    def _begin(self, status: HTTPStatus, kind: str, length: int | None = None) -> None:
        self.connection.settimeout(_PATIENCE)  # what reads set it to is over
        self.send_response(status)
        self.send_header("Content-Type", kind)
        if length is not None:
            self.send_header("Content-Length", str(length))
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
