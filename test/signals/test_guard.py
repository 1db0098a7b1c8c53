"""The guard of a topic: what is refused, and under which kind it is counted."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from node_messages import encode_reference, encode_state

from spacecraft_gnc.loop.protocols import Reference, State
from spacecraft_gnc.signals import Refused
from spacecraft_gnc.signals.attitude import REFERENCE, TARGET
from spacecraft_gnc.signals.graph import CLOCK, RECORDED, SIGNALS
from spacecraft_gnc.signals.guard import LARGEST, Guard, Window
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.signals.seal import new_key, sealer
from spacecraft_gnc.vehicles.rigid_body.signals import SIGNALS as OWN
from spacecraft_gnc.vehicles.rigid_body.signals import STATE

KEY = new_key()
PERIOD = 400_000_000
WINDOW = Window(PERIOD, 375)
TOPIC = "/attitude_state"
ZERO = np.zeros(3)


def state(step: int, stamp: tuple[int, int] | None = None) -> bytes:
    told = stamp_of(step, PERIOD) if stamp is None else stamp
    return encode_state(told, State(step, np.eye(3), ZERO), ZERO)


def kind_of(guard: Guard, data: bytes, last: int = 0) -> str | None:
    """Return the kind under which a message is refused; None: it is admitted."""
    try:
        guard.decode(guard.open(data), last)
    except Refused as refusal:
        return refusal.kind
    return None


@pytest.mark.parametrize(
    ("step", "stamp", "last", "kind"),
    [
        (0, None, 0, None),
        (375, None, 374, None),
        (3, None, 3, None),  # a repeat
        (376, None, 0, "step"),
        (2**62, (0, 0), 0, "step"),
        (2**64 - 1, (0, 0), 0, "step"),
        (2, None, 3, "step"),
        (3, (0, 0), 0, "time"),
        (3, (-1, 0), 0, "time"),
        (3, (2**31 - 1, 999_999_999), 0, "time"),
        (3, (1, 200_000_001), 0, "time"),
    ],
)
@pytest.mark.parametrize("key", [b"", KEY], ids=["without", "with"])  # it is random
def test_steps_and_stamps(
    step: int, stamp: tuple[int, int] | None, last: int, kind: str | None, key: bytes
) -> None:
    guard = Guard(STATE, TOPIC, key, WINDOW)
    stamped = stamp_of(step % 1000, PERIOD) if stamp is None else stamp
    data = state(step, stamped)
    sealed = sealer(key, TOPIC, "/plant")(data) if key else data
    assert kind_of(guard, sealed, last) == kind


def test_who_has_no_key_is_refused_whatever_is_said() -> None:
    guard = Guard(STATE, TOPIC, KEY, WINDOW)
    seal = sealer(KEY, TOPIC, "/plant")
    overheard = seal(state(1))
    assert kind_of(guard, overheard) is None
    assert kind_of(guard, overheard) == "seal"
    assert kind_of(guard, state(2)) == "seal"
    assert kind_of(guard, b"") == "seal"
    assert kind_of(guard, seal(state(2))) is None


def test_the_user_needs_no_key_and_no_time() -> None:
    guard = Guard(TARGET, "/target_attitude", KEY, WINDOW)
    turned = Reference(np.eye(3), ZERO, ZERO)
    for stamp, step in (((0, 0), 0), ((1_700_000_000, 5), 0), ((-5, 0), 2**62)):
        assert kind_of(guard, encode_reference(stamp, step, turned)) is None
    mirrored = Reference(np.diag([1.0, 1.0, -1.0]), ZERO, ZERO)
    assert kind_of(guard, encode_reference((0, 0), 0, mirrored)) == "values"


def test_a_huge_message_is_not_looked_at() -> None:
    assert kind_of(Guard(STATE, TOPIC, b"", WINDOW), bytes(LARGEST + 1)) == "layout"


@pytest.mark.parametrize("signal", [s for s in (*OWN, *SIGNALS) if s.is_flat], ids=str)
@given(data=st.binary(max_size=400))
def test_any_bytes_are_admitted_or_refused(signal: Any, data: bytes) -> None:
    """Nothing but `Refused` leaves the guard, whatever comes."""
    assert kind_of(Guard(signal, f"/{signal}", b"", WINDOW), data) in {
        None, "layout", "step", "time", "values",
    }  # fmt: skip


@given(seconds=st.integers(-(2**31), 2**31 - 1), nanoseconds=st.integers(0, 2**32 - 1))
def test_ticks_of_the_flight_alone(seconds: int, nanoseconds: int) -> None:
    guard = Guard(CLOCK, "/clock", KEY, WINDOW)
    data = b"\0\1\0\0" + struct.pack("<iI", seconds, nanoseconds)
    told = CLOCK.read(guard.open(data))["clock"]
    assert told == (seconds, nanoseconds)
    time_ns = seconds * 10**9 + nanoseconds
    if 0 <= time_ns <= 375 * PERIOD:
        guard.check_time(time_ns)
    else:
        with pytest.raises(Refused, match="required 0 to"):
            guard.check_time(time_ns)


def test_what_has_no_room_for_a_seal_is_not_acted_upon() -> None:
    """Of the graph's own topics only the clock, which the nodes do not follow, is not sealed."""
    assert [s.name for s in (*OWN, *SIGNALS) if not s.sealed] == ["/clock"]
    assert CLOCK.subscribers == ()
    assert RECORDED.sealed
    assert REFERENCE.sealed
