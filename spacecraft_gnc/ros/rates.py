"""Rates and ages of messages, measured by an observer of the graph."""

from __future__ import annotations

import struct
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from spacecraft_gnc.ros.endpoints import message_type
from spacecraft_gnc.ros.graph import GraphError, GraphView
from spacecraft_gnc.signals.structures import HEADER, TIME

_STAMP = struct.Struct("<iI")
_STAMP_AT = 4  # after the encapsulation header
_CLOCK = "/clock"
_SAME_CLOCK = 86400.0  # [s] stamps farther from the wall clock than that are not wall time


class Rate(NamedTuple):
    """Arrivals of a topic over a window of wall time."""

    messages: int
    hz: float
    period_min: float
    """[s]"""
    period_max: float
    """[s]"""
    bytes_per_second: float


class Delay(NamedTuple):
    """Age of messages at arrival, over a window of wall time."""

    messages: int
    clock: str
    """``simulated``: /clock, in simulated seconds; ``wall``: the clock of this machine."""
    mean: float
    """[s] of that clock."""
    least: float
    """[s]"""
    most: float
    """[s]"""
    speed: float
    """Simulated seconds per wall second over the window; NaN for the wall clock."""


class _Arrivals:
    """When messages came, and how large they were."""

    def __init__(self) -> None:
        self._times: deque[float] = deque()
        self._bytes = 0

    def note(self, data: bytes) -> None:
        self._times.append(time.monotonic())
        self._bytes += len(data)

    def __bool__(self) -> bool:
        return bool(self._times)

    def clear(self) -> None:
        self._times.clear()
        self._bytes = 0

    def rate(self, duration: float) -> Rate:
        """Return the rate over the ``duration`` [s] since the last `clear`."""
        times = np.array(self._times)
        flow = self._bytes / duration
        periods = np.diff(times)
        if not periods.size:
            return Rate(len(times), len(times) / duration, np.nan, np.nan, flow)
        shortest, longest = float(periods.min()), float(periods.max())
        return Rate(len(times), 1.0 / float(periods.mean()), shortest, longest, flow)


def measure(view: GraphView, topic: str, window: float, patience: float) -> Iterator[Rate]:
    """Yield the rate of a topic once per ``window`` seconds of wall time, until Ctrl-C.

    Raises
    ------
    GraphError
        There is no such topic, or no message came within ``patience`` [s].
    """
    arrivals = _Arrivals()
    name = view.subscribe(topic, arrivals.note, raw=True)
    _await_first(view, name, lambda: bool(arrivals), patience)
    while not view.interrupted:
        arrivals.clear()
        duration = _spin_for(view, window)
        if not view.interrupted:
            yield arrivals.rate(duration)


def measure_all(view: GraphView, topics: Iterable[str], window: float) -> dict[str, Rate | None]:
    """Return the rates of many topics over one window; None where the type is not installed."""
    arrivals: dict[str, _Arrivals | None] = {}
    for topic in topics:
        counter = _Arrivals()
        try:
            view.subscribe(topic, counter.note, raw=True)
            arrivals[topic] = counter
        except GraphError:  # nobody publishes, or the type is not installed
            arrivals[topic] = None
    _spin_for(view, min(window, 0.5))  # the subscriptions match meanwhile
    for found in arrivals.values():
        if found is not None:
            found.clear()
    duration = _spin_for(view, window)
    return {topic: None if a is None else a.rate(duration) for topic, a in arrivals.items()}


def delays(view: GraphView, topic: str, window: float, patience: float) -> Iterator[Delay]:
    """Yield the age of a topic's messages once per ``window`` seconds of wall time, until Ctrl-C.

    Where a node publishes /clock the stamps are simulated time, and so is the age: /clock as last
    heard minus the stamp. Messages and /clock overtake each other on the wire, so an age may be
    off by one tick either way, and says nothing of wall time. Otherwise it is wall time.

    Raises
    ------
    GraphError
        The messages carry no header, or none came within ``patience`` [s].
    """
    info = view.find_topic(topic)
    watch = _Watch(_has_clock(view))
    kind = _installed(info.types[0])
    if kind is not None and not _is_stamped(kind):
        raise GraphError(
            f"{info.name}: received type {info.types[0]}, which does not begin with a header; "
            "required a stamp to tell the age by; use `gnc inspect hz`"
        )
    if watch.simulated:
        view.subscribe(_CLOCK, watch.tick, raw=True)
    view.subscribe(topic, watch.note, raw=True)
    _await_first(view, info.name, lambda: bool(watch.ages), patience)
    while not view.interrupted:
        watch.clear()
        duration = _spin_for(view, window)
        if view.interrupted:
            return
        if watch.simulated is False and watch.farthest > _SAME_CLOCK:
            raise GraphError(
                f"{info.name}: received stamps {watch.farthest:.0f} s from the wall clock and no "
                "/clock; required stamps of one of the two; start the node that publishes /clock"
            )
        yield watch.delay(duration)


class _Watch:
    """Ages by the clock that the stamps belong to."""

    def __init__(self, simulated: bool) -> None:
        self.simulated = simulated
        self.ages: deque[float] = deque()
        self._now: float | None = None
        self._first: float | None = None

    @property
    def farthest(self) -> float:
        return max((abs(age) for age in self.ages), default=0.0)

    def tick(self, data: bytes) -> None:
        self._now = _stamp(data)
        self._first = self._now if self._first is None else self._first

    def note(self, data: bytes) -> None:
        now = self._now if self.simulated else time.time()
        if now is not None:
            self.ages.append(now - _stamp(data))

    def clear(self) -> None:
        self.ages.clear()
        self._first = self._now

    def delay(self, duration: float) -> Delay:
        clock = "simulated" if self.simulated else "wall"
        known = self._now is not None and self._first is not None
        speed = (self._now - self._first) / duration if known else np.nan  # type: ignore[operator]
        ages = np.array(self.ages or [np.nan])
        return Delay(
            len(self.ages), clock, float(ages.mean()), float(ages.min()), float(ages.max()), speed
        )


def _has_clock(view: GraphView) -> bool:
    return bool(view.publishers(_CLOCK))


def _stamp(data: bytes) -> float:
    seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_AT)
    return float(seconds + 1e-9 * nanoseconds)


def _installed(name: str) -> Any:
    try:
        return message_type(name)
    except ImportError:
        return None  # `subscribe` says so


def _await_first(view: GraphView, name: str, came: Callable[[], bool], patience: float) -> None:
    if not view.spin_until(came, patience) and not view.interrupted:
        raise GraphError(
            f"{name}: no message within {patience:g} s on ROS_DOMAIN_ID={view.domain_id}; required "
            "at least one; is the flight over? Wait longer with --timeout"
        )


def _spin_for(view: GraphView, duration: float) -> float:
    begun = time.monotonic()
    view.spin_until(lambda: time.monotonic() >= begun + duration)
    return max(time.monotonic() - begun, 1e-9)


def _is_stamped(message_type: Any) -> bool:
    """Tell whether serialized messages of a class begin with a time stamp."""
    return next(iter(message_type.get_fields_and_field_types().values()), "") in (HEADER, TIME)
