"""Check the clock, and the topics for viewers that repeat what others say."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.channels import channel_of, is_expected
from spacecraft_gnc.audit.evidence import Evidence, Telemetry
from spacecraft_gnc.audit.ledger import BITS, Ledger, as_absolute
from spacecraft_gnc.audit.wire import CANONICAL, DECLARED, ENCODING, FRAMES
from spacecraft_gnc.signals.attitude import ATTITUDE_ERROR, POSE, REFERENCE
from spacecraft_gnc.signals.graph import CLOCK
from spacecraft_gnc.signals.message import Message, Refused, Stamp, period_ns, stamp_of
from spacecraft_gnc.signals.signal import Signal
from spacecraft_gnc.types import Array

_ORDER: Final = "each once, in order"
_NS: Final = 1_000_000_000


class _Recorded(NamedTuple):
    """Messages of a topic, in the order of recording."""

    messages: list[Message]
    exact: list[bool]
    """Whether a message is what its fields encode to."""
    repeats: int
    """Messages left out, which had come before with the same bytes."""


def audit_telemetry(evidence: Evidence, ledger: Ledger, tolerance: float | None) -> None:
    """Check the clock, which ticks at every step, and what is derived of recorded messages."""
    clock = Telemetry(CLOCK, lambda flown: np.arange(flown.n), _ticks)
    for topic in (clock, *evidence.topics.telemetry):
        audit_topic(evidence, ledger, topic, tolerance)


def audit_topic(
    evidence: Evidence, ledger: Ledger, topic: Telemetry, tolerance: float | None
) -> None:
    """Check one topic: which messages there are, what they say, and how they are encoded."""
    signal, name = topic.signal, _line(topic.signal)
    recorded = _read(evidence, ledger, signal)
    steps = topic.steps(evidence)
    if not recorded.messages and not is_expected(evidence, signal):
        ledger.skip(name, "the scenario has it not recorded")
        return
    if not recorded.messages and not steps.size:
        ledger.skip(name, topic.reason)
        return
    n = _in_order(evidence, ledger, signal, steps, recorded)
    steps = steps[:n]
    _wire(ledger, signal, steps, recorded)
    if n:
        _values(evidence, ledger, topic, steps, recorded.messages[:n], tolerance)


def _line(signal: Signal) -> str:
    return signal.name.strip("/")


def _read(evidence: Evidence, ledger: Ledger, signal: Signal) -> _Recorded:
    found = _Recorded([], [], 0)
    channel, repeats, last = channel_of(evidence, signal), 0, b""
    for _, data in evidence.bag.recorded([channel]) if channel is not None else ():
        if data == last:  # a repeat after a stall
            repeats += 1
            continue
        last = data
        try:
            message = signal.read(data)
        except Refused as error:
            step = len(found.messages)
            ledger.fail(_line(signal), _ORDER, step, f"{_line(signal)} ({error})")
            continue
        found.messages.append(message)
        again = signal.encode(_time(signal, message), 0, _fields(signal, message))
        found.exact.append(again == data)
    return found._replace(repeats=repeats)


def _fields(signal: Signal, message: Message) -> list[Any]:
    return [message.slots[message.places[name]] for name in signal.fields]


def _time(signal: Signal, message: Message) -> Stamp:
    """Return the time of a message: that of its header, or the first field."""
    if signal.start:
        return message.stamp
    seconds, nanoseconds = message[next(iter(signal.fields))]
    return seconds, nanoseconds


def _in_order(
    evidence: Evidence, ledger: Ledger, signal: Signal, steps: NDArray[np.int64], found: _Recorded
) -> int:
    """Require one message of each step, in their order; return how many there are."""
    name = _line(signal)
    ns = period_ns(evidence.scenario.period)
    expected = [stamp_of(step, ns) for step in steps.tolist()]
    given = [_time(signal, message) for message in found.messages]
    n = min(len(expected), len(given))
    same = np.array([a == b for a, b in zip(given, expected, strict=False)], dtype=np.bool_)
    ledger.require(name, _ORDER, steps[:n], f"{name} (time)", same)
    if found.repeats:
        ledger.check(name, _ORDER, f"{found.repeats} sent again with the same bytes")
    if evidence.is_cut:  # its end may be lost, or longer than that of others
        return int(n if same.all() else np.argmin(same))
    if len(given) < len(expected):
        ledger.fail(name, _ORDER, int(steps[n]), f"{name} (missing)")
    elif len(given) > len(expected):
        seconds, nanoseconds = given[n]
        step = max((seconds * _NS + nanoseconds) // ns, 0)
        ledger.fail(name, _ORDER, step, f"{name} (one too many)")
    return int(n if same.all() else np.argmin(same))


def _wire(ledger: Ledger, signal: Signal, steps: NDArray[np.int64], recorded: _Recorded) -> None:
    n = len(steps)
    if not n:
        return
    name = _line(signal)
    if signal.start:
        frames = np.array(
            [message["frame_id"] == signal.frame for message in recorded.messages[:n]]
        )
        ledger.require(FRAMES, DECLARED, steps, f"{name}.header.frame_id", frames)
    exact = np.array(recorded.exact[:n], dtype=np.bool_)
    ledger.require(ENCODING, CANONICAL, steps, f"{name} (bytes)", exact)


def _values(
    evidence: Evidence,
    ledger: Ledger,
    topic: Telemetry,
    steps: NDArray[np.int64],
    messages: Iterable[Message],
    tolerance: float | None,
) -> None:
    """Compare the values with those that follow from other topics, where these were recorded."""
    signal = topic.signal
    recorded = _numbers([_fields(signal, message) for message in messages])
    expected = _numbers(topic.values(evidence, steps))
    known = ~np.isnan(expected).any(axis=1)
    where = ".".join((_line(signal), *signal.fields))
    limit = as_absolute(tolerance, recorded)
    ledger.compare(
        _line(signal), steps[known], {where: recorded[known]}, {where: expected[known]}, limit
    )
    ledger.check(_line(signal), "").is_condition = False


def _numbers(rows: Sequence[Any]) -> Array:
    return np.array([np.concatenate([np.ravel(part) for part in row]) for row in rows], float)


def _ticks(evidence: Evidence, steps: NDArray[np.int64]) -> Sequence[Any]:
    ns = period_ns(evidence.scenario.period)
    return [[stamp_of(step, ns)] for step in steps.tolist()]


def audit_latched(
    evidence: Evidence, ledger: Ledger, signal: Signal, value: Any, tolerance: float | None
) -> None:
    """Check a topic that tells the same whenever its publisher starts, from the scenario alone."""
    name = _line(signal)
    channel = channel_of(evidence, signal)
    found = [data for _, data in evidence.bag.recorded([channel])] if channel is not None else []
    if not found and not is_expected(evidence, signal):
        ledger.skip(name, "the scenario has it not recorded")
        return
    if not found:
        ledger.fail(name, BITS, 0, f"{name} (missing)")
        return
    if tolerance is not None:
        ledger.skip(name, "with a tolerance bytes are not compared")
        return
    expected = signal.encode((0, 0), 0, value)
    same = np.array([data == expected for data in found])
    ledger.require(name, BITS, np.zeros(len(found), dtype=np.int64), f"{name} (bytes)", same)


# Topics that vehicles with an attitude share.


def poses(evidence: Evidence) -> NDArray[np.int64]:
    """Return the steps at which the plant tells a pose."""
    every = evidence.scenario.plant.pose_every
    return np.arange(0, evidence.n + 1, every) if every else np.empty(0, dtype=np.int64)


NO_POSES: Final = "plant.pose_every is 0"


def pose_of(state: Signal) -> Telemetry:
    """Return the pose of a vehicle whose state has a field ``attitude``."""

    def values(evidence: Evidence, steps: NDArray[np.int64]) -> Sequence[Any]:
        attitudes = evidence.rows(state, "attitude", steps).reshape(-1, 3, 3)
        return [[np.zeros(3), _quaternion(attitude)] for attitude in attitudes]

    return Telemetry(POSE, poses, values, NO_POSES)


def error_of(state: Signal, command: Signal) -> Telemetry:
    """Return the attitude error of a vehicle, of each step with a command."""

    def steps(evidence: Evidence) -> NDArray[np.int64]:
        return evidence.columns[command].steps

    def values(evidence: Evidence, steps: NDArray[np.int64]) -> Sequence[Any]:
        attitudes = evidence.rows(state, "attitude", steps).reshape(-1, 3, 3)
        references = evidence.rows(REFERENCE, "attitude", steps).reshape(-1, 3, 3)
        return [[_turn(r, a)] for r, a in zip(references, attitudes, strict=True)]

    return Telemetry(ATTITUDE_ERROR, steps, values, "no step was answered")


def _quaternion(attitude: Array) -> Array:
    known = np.isfinite(attitude).all()
    return np.asarray(lie.to_quaternion_xyzw(attitude)) if known else np.full(4, np.nan)


def _turn(reference: Array, attitude: Array) -> Array:
    known = np.isfinite(attitude).all() and np.isfinite(reference).all()
    return np.asarray(lie.log(reference.T @ attitude)) if known else np.full(3, np.nan)
