"""Progress of a launch is what its own nodes tell, whatever else reaches its launcher."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import serialize_message

from spacecraft_gnc.ros.told import Told
from spacecraft_gnc.signals import Refused, Signal
from spacecraft_gnc.signals.graph import DIAGNOSTICS, WALL_STATUS, WALL_TIMING
from spacecraft_gnc.signals.guard import Guard, Window
from spacecraft_gnc.signals.members import Place
from spacecraft_gnc.signals.seal import new_key, sealer

KEY = new_key()
WINDOW = Window(400_000_000, 1000)
GOOD = WALL_TIMING.encode((2, 0), 5, (1.5, 0.001, math.nan, 3, 0, 0))


def status(*entries: dict[str, str], name: str = "nmpc_controller") -> bytes:
    told = [
        DiagnosticStatus(
            name=name, values=[KeyValue(key=key, value=value) for key, value in entry.items()]
        )
        for entry in entries
    ]
    data: bytes = serialize_message(DiagnosticArray(status=told))
    return data


def ends(told: Told, key: bytes = KEY) -> tuple[Callable[[bytes], None], Callable[[bytes], None]]:
    timing = told.guarded(Guard(WALL_TIMING, "/wall_timing", key, WINDOW), told.timing)
    status = told.guarded(Guard(WALL_STATUS, "/wall_status", key, WINDOW), partial(told.status, ""))
    return timing, status


def sealed(signal: Signal, data: bytes, key: bytes = KEY) -> bytes:
    return sealer(key, Place("").topic(signal), "/plant")(data)


def test_what_is_sealed_is_shown() -> None:
    told = Told()
    timing, of_controller = ends(told)
    timing(sealed(WALL_TIMING, GOOD))
    of_controller(sealed(WALL_STATUS, status({"step": "7", "attitude_error": "0.25"})))
    assert (told.progress.step, told.progress.missed_deadlines) == (5, 3)
    assert (told.progress.status_step, told.progress.attitude_error) == (7, 0.25)
    assert told.refused == {"launcher": {}}
    assert told.unsealed() == []


def test_what_is_not_sealed_is_counted() -> None:
    told = Told()
    timing, of_controller = ends(told)
    timing(GOOD)
    timing(sealed(WALL_TIMING, GOOD, bytes(16)))
    of_controller(status({"step": "7"}))
    assert told.progress.step == told.progress.status_step == -1
    assert told.refused == {"launcher": {"wall_timing/seal": 2, "wall_status/seal": 1}}
    assert told.unsealed() == ["wall_status", "wall_timing"]


def test_what_nodes_refused_is_taken_from_their_diagnostics() -> None:
    told = Told()
    of_nodes = told.guarded(Guard(DIAGNOSTICS, "/diagnostics", KEY, WINDOW), told.diagnostics)
    first = {"rejected_messages": "3", "rejected torque_command/seal": "2", "rejected a/step": "1"}
    for values in (first, first | {"rejected torque_command/seal": "9", "rejected b/seal": "many"}):
        of_nodes(sealed(DIAGNOSTICS, status(values, name="plant")))
    counts = {"torque_command/seal": 9, "a/step": 1}
    of_nodes(status({"rejected a/seal": "1"}, name="of another program"))
    assert told.refused == {"launcher": {"/diagnostics/seal": 1}, "plant": counts}
    assert told.unsealed() == ["torque_command"]


@pytest.mark.parametrize(
    ("entries", "refused"),
    [
        ((), 0),  # an empty array has nothing to tell, and ended launches
        (({},), 0),
        (({"step": "soon"},), 1),
        (({"step": "1e3"},), 1),
        (({"distance": "far"},), 1),
        (({"step": "2", "distance": "nan"}, {"step": ""}), 1),
    ],
)
def test_any_status_is_taken(entries: tuple[dict[str, str], ...], refused: int) -> None:
    told = Told()
    _, of_controller = ends(told, b"")
    of_controller(status(*entries))
    assert sum(told.refused["launcher"].values()) == refused


@given(data=st.one_of(st.binary(max_size=64), st.binary(max_size=64).map(b"\0\1\0\0".__add__)))
def test_malformed_bytes_never_raise(data: bytes) -> None:
    told = Told()
    for end in ends(told, b""):
        end(data)
    assert told.progress.step >= -1


@given(cut=st.integers(0, len(GOOD) - 1))
def test_cut_off_messages_are_refused(cut: int) -> None:
    told = Told()
    with pytest.raises(Refused):
        told.timing(GOOD[:cut])
