"""What the nodes of a launch tell their launcher, from bytes that may be anybody's."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message

from spacecraft_gnc.signals import Refused
from spacecraft_gnc.signals.graph import DIAGNOSTICS, WALL_TIMING
from spacecraft_gnc.signals.guard import Guard

LAUNCHER: Final = "launcher"
_REJECTED: Final = "rejected "
_SEAL: Final = "/seal"
_FARNESS: Final = ("distance", "attitude_error", "wall_solve_time")


@dataclass(slots=True)
class Progress:
    """What the graph last told about itself."""

    step: int = -1
    """Last control step reported; -1: none."""
    wall_elapsed: float = 0.0
    """Since step 0 [s]."""
    latency: float = math.nan
    """State to torque [s]."""
    missed_deadlines: int = 0
    status_step: int = -1
    """Control step that the next three belong to; -1: none."""
    distance: float = math.nan
    """From where it is to go [m]; NaN: it is not a matter of place."""
    attitude_error: float = math.nan
    """Angle from the attitude that it is to have [rad]."""
    solve_time: float = math.nan
    """[s]"""


class _Status(NamedTuple):
    """What a controller last told."""

    step: int
    distance: float
    error: float
    solve_time: float


def _farness(status: _Status) -> tuple[float, ...]:
    """Return what orders controllers by how far they have to go: by place, then by attitude."""
    return tuple(-1.0 if math.isnan(far) else far for far in (status.distance, status.error))


class Told:
    """Progress of a flight; nothing that is not sealed or not readable changes it, or raises."""

    def __init__(self) -> None:
        self.progress = Progress()
        self._refused: dict[str, Counter[str]] = {LAUNCHER: Counter()}
        self._status: dict[str, _Status] = {}

    @property
    def refused(self) -> Mapping[str, Mapping[str, int]]:
        """Messages that each node, and the launcher, refused: by topic and kind, as nodes tell."""
        return self._refused

    def unsealed(self) -> list[str]:
        """Topics, relative to the graph, on which somebody spoke who is not of this flight.

        ``/diagnostics`` is not among them: all ROS nodes share it.
        """
        words = {key for counts in self._refused.values() for key in counts}
        topics = {key.removesuffix(_SEAL) for key in words if key.endswith(_SEAL)}
        return sorted(topics - {DIAGNOSTICS.name})

    def guarded(self, guard: Guard, take: Callable[[bytes], None]) -> Callable[[bytes], None]:
        """Return a callback that hands on what has a seal and can be read, and counts the rest."""

        def on_message(data: bytes) -> None:
            try:
                take(guard.open(data))
            except Refused as error:
                self.refuse(guard.signal, error)

        return on_message

    def refuse(self, topic: object, error: Refused) -> None:
        """Count what the launcher itself refuses."""
        self._refused[LAUNCHER][f"{topic}/{error.kind}"] += 1

    def timing(self, data: bytes) -> None:
        """Take a message of the plant.

        Raises
        ------
        Refused
            If it is none.
        """
        message, progress = WALL_TIMING.decode(data), self.progress
        progress.step = message.step
        progress.wall_elapsed = message["wall_elapsed"]
        progress.latency = message["wall_latency"]
        progress.missed_deadlines = message["missed_deadlines"]

    def status(self, space: str, data: bytes) -> None:
        """Take a message of a controller; show the one that is furthest from where it is to go.

        Raises
        ------
        Refused
            If it is none.
        """
        for values in diagnostics_in(data).values():
            try:
                told = (float(values.get(name, math.nan)) for name in _FARNESS)
                self._status[space] = _Status(int(values.get("step", -1)), *told)
            except ValueError as error:
                raise Refused(str(error)) from error
        shown = max(self._status.values(), key=_farness, default=None)
        if shown is not None:
            progress = self.progress
            progress.status_step, progress.solve_time = shown.step, shown.solve_time
            progress.distance, progress.attitude_error = shown.distance, shown.error

    def diagnostics(self, data: bytes) -> None:
        """Take a message of any node: how many messages it has refused so far.

        Raises
        ------
        Refused
            If it is none.
        """
        for name, values in diagnostics_in(data).items():
            self._refused[name] = Counter(
                {
                    key.removeprefix(_REJECTED): int(count)
                    for key, count in values.items()
                    if key.startswith(_REJECTED) and count.isdecimal()
                }
            )


def diagnostics_in(data: bytes) -> Mapping[str, Mapping[str, str]]:
    """Return the values of each node that a message of diagnostics is about.

    Raises
    ------
    Refused
        If the bytes are no such message.
    """
    try:
        message: Any = deserialize_message(data, DiagnosticArray)
        return {
            status.name: {entry.key: entry.value for entry in status.values}
            for status in message.status
        }
    except (RuntimeError, ValueError) as error:  # of the binding, and of text that is no UTF-8
        raise Refused(f"{len(data)} bytes that are no diagnostics ({error})") from error
