"""Node ``player``: a bag's messages into a live graph, bytes and QoS as recorded.

Its parameters are its controls, for ``gnc inspect params set`` and every other client: ``rate``,
``paused``, ``loop`` and ``position``.
"""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import rclpy
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from spacecraft_gnc.launcher.environment import prepare
from spacecraft_gnc.recording.play_clock import PlayClock
from spacecraft_gnc.recording.playback import Moment, Playback
from spacecraft_gnc.ros.outlet import Outlet
from spacecraft_gnc.ros.played_types import Unplayable, played_type
from spacecraft_gnc.ros.qos import ros_qos

if TYPE_CHECKING:
    from typing_extensions import Self

NAME: Final = "player"
_BEAT: Final = 0.05  # [s] wall: how late a key or a signal may be noticed
_TELL: Final = 0.5  # [s] wall between two updates of the parameter `position`
_SLOW_READER: Final = 5.0  # [s] wall after which a reader that acknowledges nothing is left behind
_DRAIN_TIMEOUT: Final = 2.0  # [s] wall granted to readers at the end
_DESCRIPTIONS: Final = {
    "rate": "Seconds of the bag in a second of wall time; 0: as fast as it goes [-]",
    "paused": "Whether the player stands [-]",
    "loop": "Begin again after the last message [-]",
    "position": "Place in the bag, after its first stamp; set it to go there [s]",
}


class Plan(NamedTuple):
    """How to play."""

    rate: float = 1.0
    """0: as fast as it goes."""
    start: float = 0.0
    """[s]"""
    paused: bool = False
    loop: bool = False
    expected: Collection[str] = ()
    """Topics that need a subscriber before the first message; empty: all that are played."""
    patience: float = 2.0
    """Wall time after which it begins without them [s]."""


@dataclass(slots=True)
class Played:
    """What was played."""

    messages: dict[str, int] = field(default_factory=dict)
    """By topic."""
    unheard: tuple[str, ...] = ()
    """Expected topics that nobody had subscribed to when the patience was over."""
    overrun: list[str] = field(default_factory=list)
    """Topics with a reader that did not keep up."""
    rounds: int = 0
    """Times that the end was reached."""
    jumped: bool = False
    """Whether it went elsewhere in between."""
    interrupted: bool = False
    position: float = 0.0
    """Of the last message [s]."""
    wall_time: float = 0.0
    """From the first message to the last [s]."""


Watch = Callable[[PlayClock, float], str | None]
"""Called now and then with the clock and the position [s]; returns a key that was pressed."""


class Player:
    """Publishes a bag. Use it as a context manager.

    Parameters
    ----------
    playback
        What to play; topics whose type cannot be published are left out of it.
    plan
        How.
    domain_id
        ROS_DOMAIN_ID of the graph.
    """

    def __init__(self, playback: Playback, plan: Plan, domain_id: int) -> None:
        prepare(os.environ)
        rclpy.init(args=[], domain_id=domain_id, signal_handler_options=SignalHandlerOptions.NO)
        self._playback, self._plan = playback, plan
        self._stop = False
        self._seek: float | None = plan.start
        self.played = Played()
        self.node = Node(NAME)
        self._executor = EventsExecutor()
        self._executor.add_node(self.node)
        self._advertise()
        self._loop = plan.loop
        self._clock = PlayClock(plan.rate, plan.paused, plan.start, time.monotonic())
        self._declare()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._end)

    def __enter__(self) -> Self:
        """Return the player."""
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the graph."""
        self._executor.remove_node(self.node)
        del self._executor  # it holds our callbacks, and we it: no garbage collector sees that
        self.node.destroy_node()
        rclpy.try_shutdown()

    def _end(self, *_: Any) -> None:
        self._stop = self.played.interrupted = True

    # Endpoints.

    def _advertise(self) -> None:
        """Create the publishers; leave out of the playback the topics that can have none."""
        self._outlets: dict[str, Outlet] = {}
        for name, topic in list(self._playback.topics.items()):
            try:
                kind = played_type(topic)
            except Unplayable as reason:
                self._playback.leave_out(name, str(reason))
                continue
            publisher = self.node.create_publisher(kind, name, ros_qos(topic.qos))
            self._outlets[name] = Outlet(publisher, topic.qos.depth)

    def await_subscribers(self) -> None:
        """Wait until the expected topics are matched, or the patience is over."""
        expected = set(self._plan.expected or self._outlets) & set(self._outlets)
        deadline = time.monotonic() + self._plan.patience
        while not self._stop and time.monotonic() < deadline:
            expected = {n for n in expected if not self._outlets[n].subscribers}
            if not expected:
                break
            self._executor.spin_once(timeout_sec=_BEAT)
        self.played.unheard = tuple(sorted(expected))

    # Controls.

    def _declare(self) -> None:
        plan = self._plan
        values = {
            "rate": float(plan.rate),
            "paused": plan.paused,
            "loop": plan.loop,
            "position": float(plan.start),
        }
        for name, value in values.items():
            self.node.declare_parameter(
                name, value, ParameterDescriptor(description=_DESCRIPTIONS[name])
            )
        self._telling = False
        self._told = 0.0
        self.node.add_on_set_parameters_callback(self._on_set)

    def set(self, name: str, value: float | bool) -> None:
        """Set one of the node's parameters; a refused value changes nothing."""
        self.node.set_parameters([Parameter(name, value=value)])

    def _on_set(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        values = {parameter.name: parameter.value for parameter in parameters}
        reason = _refusal(values, self._playback.duration)
        if reason:
            return SetParametersResult(successful=False, reason=reason)
        if self._telling:
            return SetParametersResult(successful=True)
        now = time.monotonic()
        self._loop = values.get("loop", self._loop)
        if "rate" in values:
            self._clock.set_rate(values["rate"], now)
        if "paused" in values:
            self._clock.pause(values["paused"], now)
        if "position" in values:
            self._seek = values["position"]
            self.played.jumped = True
        return SetParametersResult(successful=True)

    def _tell(self, position: float) -> None:
        """Let the parameter `position` follow."""
        self._telling = True
        self.set("position", position)
        self._telling = False

    # Playing.

    def run(self, watch: Watch | None = None) -> Played:
        """Play to the end, or until SIGINT, SIGTERM or the key ``q``."""
        begun = time.monotonic()
        moments: Iterator[Moment] = iter(())
        moment: Moment | None = None
        while not self._stop:
            if self._seek is not None:
                moments = self._go_to(self._seek)
                moment = next(moments, None)
            now = time.monotonic()
            if moment is None:
                if not self._at_the_end():
                    break
                continue
            due = self._playback.position(moment.time_ns)
            wait = self._clock.wait(due, now)
            if wait > 0.0:
                self._executor.spin_once(timeout_sec=min(wait, _BEAT))
            else:
                self._publish(moment.messages)
                self._clock.passed(due)
                self.played.position = due
                self.played.wall_time = now - begun
                moment = next(moments, None)
                self._executor.spin_once(timeout_sec=0.0)
            self._look_around(watch)
        self._say_goodbye()
        return self.played

    def _go_to(self, position: float) -> Iterator[Moment]:
        """Begin at a position [s], with what is latched there."""
        self._seek = None
        self._clock.seek(position, time.monotonic())
        time_ns = self._playback.time_ns(position)
        self._publish(self._playback.latched(time_ns))
        return self._playback.moments(time_ns)

    def _at_the_end(self) -> bool:
        """Count a round; tell whether another one begins."""
        self.played.rounds += 1
        if self._loop:
            self._seek = self._plan.start
        return self._loop

    def _publish(self, messages: Sequence[tuple[str, bytes]]) -> None:
        for name, data in messages:
            outlet = self._outlets[name]
            outlet.publish(data)
            kept_up = not outlet.is_full or outlet.drain(_SLOW_READER, lambda: self._stop)
            if not (kept_up or self._stop or name in self.played.overrun):
                self.played.overrun.append(name)
            self.played.messages[name] = outlet.count

    def _look_around(self, watch: Watch | None) -> None:
        """Let the world know where it is, and hear what is wanted."""
        now = time.monotonic()
        position = min(self._clock.position(now), self._playback.duration)
        if now - self._told >= _TELL:
            self._told = now
            self._tell(position)
        key = None if watch is None else watch(self._clock, position)
        if key is not None:
            self._obey(key, position)

    def _obey(self, key: str, position: float) -> None:
        duration = self._playback.duration
        if key == "quit":
            self._end()
        elif key == "pause":
            self.set("paused", not self._clock.paused)
        elif key in _JUMPS:
            self.set("position", min(max(position + _JUMPS[key], 0.0), duration))
        elif key in _FACTORS and self._clock.rate:
            self.set("rate", self._clock.rate * _FACTORS[key])

    def _say_goodbye(self) -> None:
        for outlet in self._outlets.values():
            outlet.drain(_DRAIN_TIMEOUT if not self.played.interrupted else 0.0, lambda: False)


_JUMPS: Final = {"back": -10.0, "forward": 10.0}  # [s]
_FACTORS: Final = {"faster": 2.0, "slower": 0.5}


def _refusal(values: dict[str, Any], duration: float) -> str:
    """Return why parameters are refused; empty where they are not."""
    rate, position = values.get("rate", 1.0), values.get("position", 0.0)
    if not (math.isfinite(rate) and rate >= 0.0):
        return f"rate: received {rate:g}; required a finite number >= 0, 0 for as fast as it goes"
    if not 0.0 <= position <= duration:
        return f"position: received {position:g} s; required 0 to {duration:g} s, the bag's length"
    return ""
