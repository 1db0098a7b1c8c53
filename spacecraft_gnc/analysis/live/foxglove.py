"""WebSocket server for the Foxglove app: serialized messages and their definitions.

Source: foxglove-sdk; channels of encoding ``cdr`` with ``ros2msg`` schemas, as in an MCAP file.
"""

from __future__ import annotations

import errno
import logging
import re
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from spacecraft_gnc.analysis.live.server import refused
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.extras import explained_imports

if TYPE_CHECKING:
    from typing_extensions import Self

    from spacecraft_gnc.analysis.live.transport import Transport
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.recording.playback import Moment, Playback

DEFAULT_PORT: Final = 8765
"""Where the app looks by itself."""
PERIOD: Final = 0.02
"""Wall time between two looks at what is to be played [s]."""
_TELL: Final = 0.1  # [s] wall
_BACKLOG: Final = 20000  # messages kept for a slow app
_NS_PER_S: Final = 1_000_000_000
_OS_ERROR: Final = re.compile(r"os error (\d+)")


class FoxgloveServer:
    """Publishes serialized messages to the Foxglove app. Use it as a context manager.

    Parameters
    ----------
    host
        Address to listen on.
    port
        None: `DEFAULT_PORT`, or any free one.
    transport
        What the app's own buttons act on; None: the flight is live.

    Raises
    ------
    MissingDependency
        foxglove-sdk is not installed.
    PortTaken
        The port asked for cannot be had.
    """

    def __init__(
        self, host: str = "127.0.0.1", port: int | None = None, transport: Transport | None = None
    ) -> None:
        with explained_imports():
            import foxglove
        foxglove.set_log_level(logging.CRITICAL)  # an app that leaves is no error
        self._context = foxglove.Context()
        self._channels: dict[str, Any] = {}
        self._latched: dict[str, tuple[int, bytes]] = {}
        self.subscribed = False
        """Set when a client has subscribed to something; whoever plays clears it."""
        self._transport = transport
        self._told = 0.0
        self._server = self._start(host, port)

    def __enter__(self) -> Self:
        """Return the server, which listens already."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop."""
        self._server.stop()

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.port)

    def announce(
        self,
        topic: str,
        type_name: str,
        definition: str,
        *,
        encoding: str = "ros2msg",
        latched: bool,
    ) -> None:
        """Offer a topic.

        Parameters
        ----------
        topic
            Full name.
        type_name
            ``pkg/msg/Type``.
        definition
            Its complete text.
        encoding
            Of the definition: ``ros2msg``, ``ros2idl`` or ``omgidl``.
        latched
            Whether whoever subscribes late gets the last message.
        """
        from foxglove import Channel, Schema

        schema = Schema(name=type_name, encoding=encoding, data=definition.encode())
        self._channels[topic] = Channel(
            topic, schema=schema, message_encoding="cdr", context=self._context
        )
        if latched:
            self._latched[topic] = (0, b"")

    def send(self, topic: str, time_ns: int, data: bytes) -> None:
        """Publish a serialized message of a topic that was announced, at its log time [ns]."""
        self._channels[topic].log(data, log_time=time_ns)
        if topic in self._latched:
            self._latched[topic] = (time_ns, data)

    def serve_latched(self) -> None:
        """Publish the latched messages again if somebody has subscribed since the last call."""
        if not self.subscribed:
            return
        self.subscribed = False
        for topic, (time_ns, data) in self._latched.items():
            if data:
                self._channels[topic].log(data, log_time=time_ns)

    def tell(self, jumped: bool) -> None:
        """Tell the app where a recording is, a few times a second and at every jump."""
        now = time.monotonic()
        if self._transport is not None and (jumped or now - self._told >= _TELL):
            self._told = now
            self._server.broadcast_playback_state(self.state(jumped, None))

    def state(self, jumped: bool, request_id: str | None) -> Any:
        """Return where the recording is, as the app wants it."""
        from foxglove.websocket import PlaybackState, PlaybackStatus

        transport = self._transport
        if transport is None:
            return None
        moving = PlaybackStatus.Paused if transport.paused else PlaybackStatus.Playing
        return PlaybackState(
            status=PlaybackStatus.Ended if transport.over else moving,
            current_time=round(transport.time() * _NS_PER_S),
            playback_speed=transport.rate,
            did_seek=jumped,
            request_id=request_id,
        )

    def _start(self, host: str, port: int | None) -> Any:
        import foxglove

        span = None
        if self._transport is not None:
            transport = self._transport
            span = (round(transport.start * _NS_PER_S), round(transport.end * _NS_PER_S))
        wanted = (DEFAULT_PORT, 0) if port is None else (port,)
        for candidate in wanted:
            try:
                return foxglove.start_server(
                    name="spacecraft_gnc",
                    host=host,
                    port=candidate,
                    server_listener=_listener(self, self._transport),
                    context=self._context,
                    playback_time_range=span,
                    message_backlog_size=_BACKLOG,
                )
            except (OSError, RuntimeError) as error:
                failure = _system_error(error)
                if candidate == wanted[-1] or failure.errno != errno.EADDRINUSE:
                    raise refused(host, candidate, failure) from error
        raise AssertionError  # the last candidate returned or raised


def _listener(server: FoxgloveServer, transport: Transport | None) -> Any:
    """Return what the threads of the library call for the app."""
    from foxglove.websocket import PlaybackCommand, ServerListener

    class Listener(ServerListener):
        def on_subscribe(self, client: Any, channel: Any) -> None:
            """Have the latched messages sent again, not from within this call."""
            server.subscribed = True

        def on_playback_control_request(self, playback_control_request: Any) -> Any:
            """Play, pause, seek, and set the rate."""
            request = playback_control_request
            if transport is None:
                return None
            jumped = request.seek_time is not None
            with suppress(ParameterError):  # a rate of zero, say: the state that is told shows it
                transport.set_rate(request.playback_speed)
            if jumped:
                transport.seek(request.seek_time / _NS_PER_S)
            if request.playback_command == PlaybackCommand.Pause:
                transport.pause()
            elif transport.paused or transport.over:
                transport.play()
            return server.state(jumped, request.request_id)

    return Listener()


def announce_all(bag: Bag, playback: Playback, server: FoxgloveServer) -> None:
    """Offer every topic that is played, with its definition from the bag."""
    for name, topic in list(playback.topics.items()):
        if name not in bag.topics:
            playback.leave_out(name, "the app has a clock of its own")
            continue
        channel = bag.channel(name)
        server.announce(
            name,
            topic.type_name,
            channel.definition,
            encoding=channel.schema_encoding,
            latched=topic.is_latched,
        )


def play(
    playback: Playback,
    server: FoxgloveServer,
    transport: Transport,
    stop: Callable[[], bool],
    wait: Callable[[float], None] = time.sleep,
) -> None:
    """Publish the messages of a bag as their time comes, until ``stop``.

    It begins when an app has subscribed to something.

    Parameters
    ----------
    playback
        What is played; `announce_all` its topics before.
    server, transport
        Where to, and when.
    stop
        Asked every `PERIOD`.
    wait
        Lets wall time [s] pass; tests hand in their own.
    """
    jumps = -1
    moments: Iterator[Moment] = iter(())
    pending: Moment | None = None
    while not stop():
        if server.subscribed:
            transport.begin()
        now = playback.end_ns if transport.over else round(transport.time() * _NS_PER_S)
        jumped = jumps != transport.jumps
        if jumped:
            jumps = transport.jumps
            for topic, data in playback.latched(now):
                server.send(topic, now, data)
            moments = playback.moments(now)
            pending = next(moments, None)
        while pending is not None and pending.time_ns <= now:
            for topic, data in pending.messages:
                server.send(topic, pending.time_ns, data)
            pending = next(moments, None)
        server.serve_latched()
        server.tell(jumped)
        wait(PERIOD)


def _system_error(error: Exception) -> OSError:
    """Return the system's error behind that of the library, which has it as text."""
    number = _OS_ERROR.search(str(error))
    return OSError(int(number[1]) if number else 0, str(error))
