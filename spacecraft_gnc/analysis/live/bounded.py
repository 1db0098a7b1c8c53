"""Bounds of a web server: connections at a time, and bytes and time of a request."""

from __future__ import annotations

import socket
import threading
import time
from contextlib import suppress
from http.server import ThreadingHTTPServer
from io import RawIOBase
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from typing_extensions import Buffer

MOST_CONNECTIONS: Final = 64
"""More than the watchers and what their pages load, and few enough for a thread each."""
MOST_BYTES: Final = 16384
"""Of a request line with its headers and its body."""
REQUEST_TIME: Final = 5.0
"""Wall time for a client to send all of its request [s]."""
LINGER_TIME: Final = 5.0
"""Wall time for a client to end its connection after the answer [s]."""
LINGER_BYTES: Final = 2**20
"""Of what a client still sends after the answer."""
_TEXT: Final = b"too many connections\n"
_BUSY: Final = (
    b"HTTP/1.0 503 Service Unavailable\r\nContent-Type: text/plain; charset=utf-8\r\n"
    b"Content-Length: %d\r\nConnection: close\r\n\r\n%b" % (len(_TEXT), _TEXT)
)


class TooLate(Exception):
    """A request did not come to its end in time."""


class TooLong(Exception):
    """A request has more bytes than any that is answered."""


class RequestReader(RawIOBase):
    """What a client sends, up to a number of bytes and a deadline for all of it.

    A time limit for each read would let a client hold a thread by a byte now and then.

    Parameters
    ----------
    connection
        Its time limit is set to what is left at each read.
    patience
        Wall time from now on [s].
    most
        Bytes in all.
    """

    def __init__(self, connection: socket.socket, patience: float, most: int = MOST_BYTES) -> None:
        self._connection = connection
        self._deadline = time.monotonic() + patience
        self._left = most

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: Buffer) -> int:
        """Read what there is.

        Raises
        ------
        TooLate, TooLong
            Where nothing came until the deadline, or more than allowed.
        """
        left = self._deadline - time.monotonic()
        if left <= 0.0:
            raise TooLate
        self._connection.settimeout(left)
        try:
            count = self._connection.recv_into(buffer)
        except TimeoutError as error:
            raise TooLate from error
        self._left -= count
        if self._left < 0:
            raise TooLong
        return count


class BoundedServer(ThreadingHTTPServer):
    """Answers each connection in a thread of its own, and those beyond a number with 503."""

    daemon_threads = True
    block_on_close = False  # a watcher that takes nothing must not hold up the end

    def __init__(self, *args: Any, **options: Any) -> None:
        self._slots = threading.BoundedSemaphore(MOST_CONNECTIONS)
        super().__init__(*args, **options)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Start a thread for a connection, or turn it away."""
        if not self._slots.acquire(blocking=False):
            self._turn_away(request)
            return
        try:
            super().process_request(request, client_address)
        except BaseException:  # no thread could be started
            self._slots.release()
            raise

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer a connection, and free its place."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._slots.release()

    def _turn_away(self, request: socket.socket) -> None:
        with suppress(OSError):
            request.setblocking(False)
            request.send(_BUSY)  # it fits in the buffer of a new connection
            request.recv(MOST_BYTES)  # closed with bytes unread, the answer would be lost
        super().shutdown_request(request)

    def shutdown_request(self, request: Any) -> None:
        """Close a connection once its client has, or after some time and bytes.

        Closed with bytes unread, or while the client still sends, a connection is reset, which can
        lose the answer.
        """
        deadline = time.monotonic() + LINGER_TIME
        with suppress(OSError):
            request.shutdown(socket.SHUT_WR)
            unread = LINGER_BYTES
            while unread > 0 and (left := deadline - time.monotonic()) > 0.0:
                request.settimeout(left)
                if not (received := request.recv(MOST_BYTES)):
                    break
                unread -= len(received)
        self.close_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing: a client that leaves is no error."""
