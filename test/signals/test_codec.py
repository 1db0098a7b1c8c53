"""The codec writes what rclpy writes, and reads it back."""

from __future__ import annotations

import math
import struct
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.errors import ShapeError
from spacecraft_gnc.signals import Field, Refused, Signal, graph
from spacecraft_gnc.signals.structures import SEQUENCE, STRUCTURES, parse_kind
from spacecraft_gnc.vehicles.rigid_body import signals as rigid_body
from spacecraft_gnc.vehicles.rigid_body.signals import SOLVER_STATUS, STATE, TORQUE, ZONE_MARKERS

EVERY = (*graph.SIGNALS, *rigid_body.SIGNALS)
FLAT = [signal for signal in EVERY if signal._codec is not None]
LIMITS = {"int32": 2**31, "int64": 2**63}
WORDS = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=9)


def number(kind: str) -> st.SearchStrategy[Any]:
    if kind == "bool":
        return st.booleans()
    if kind.startswith("float"):
        return st.floats(width=64)
    if kind.startswith("u"):
        return st.integers(0, 2 ** int(kind[4:]) - 1)
    return st.integers(-LIMITS[kind], LIMITS[kind] - 1)


def leaves(kind: str) -> list[str]:
    if kind not in STRUCTURES:
        return [kind]
    return [leaf for member in STRUCTURES[kind].values() for leaf in leaves(member)]


def values_of(kind: str) -> st.SearchStrategy[Any]:
    """Draw a field's value as a core tells it."""
    base, count = parse_kind(kind)
    if base == "string":
        return WORDS
    if count is None and base not in STRUCTURES:
        return number(base)
    kinds = leaves(base)
    if count == SEQUENCE:
        return st.lists(number(base), max_size=5)
    return st.tuples(*(number(leaf) for leaf in kinds * (count or 1)))


def plain(signal: Signal) -> Signal:
    """Return a signal that takes the values of its fields."""
    return replace(signal, pack=None)


def message_class(signal: Signal) -> Any:
    pytest.importorskip("rclpy")
    package, _, leaf = signal.type.split("/")
    return getattr(import_module(f"{package}.msg"), leaf)


def flattened(message: Any) -> list[Any]:
    """Return the numbers and words of a message object, in order."""
    if hasattr(message, "get_fields_and_field_types"):
        names = message.get_fields_and_field_types()
        return [leaf for name in names for leaf in flattened(getattr(message, name))]
    if hasattr(message, "tolist"):
        return list(message.tolist())
    return list(message) if isinstance(message, list | tuple) else [message]


def told(stamp: tuple[int, int], step: int, signal: Signal, values: Any) -> list[Any]:
    start = [*stamp, signal.frame] if signal.start else []
    start += [step] if signal.is_stepped else []
    return start + [leaf for value in values for leaf in flattened(value)]


@pytest.mark.parametrize("signal", FLAT, ids=str)
@given(data=st.data())
def test_rclpy_reads_what_was_told_and_writes_the_same_bytes(
    signal: Signal, data: st.DataObject
) -> None:
    kind = message_class(signal)
    from rclpy.serialization import deserialize_message, serialize_message

    signal = plain(signal)
    stamp = data.draw(st.tuples(number("int32"), number("uint32")))
    step = data.draw(number("uint64"))
    values = [data.draw(values_of(field.kind)) for field in signal.fields.values()]
    packed = signal.encode(stamp, step, values)
    message = deserialize_message(packed, kind)
    assert repr(flattened(message)) == repr(told(stamp, step, signal, values))
    reference = bytes(serialize_message(message))
    # rclpy may end with a surplus (it aligns for elements of empty sequences) or without padding,
    # and leaves whatever was in memory in the padding: read back, both say the same.
    sequences = sum(field.kind.endswith("[]") for field in signal.fields.values())
    assert abs(len(packed) - len(reference)) < 12 + 4 * sequences
    ours, theirs = signal.read(packed), signal.read(reference[: len(packed)])
    assert repr(ours.slots) == repr(theirs.slots)
    assert len(packed) % 4 == 0


@pytest.mark.parametrize("signal", FLAT, ids=str)
@given(data=st.data())
def test_what_was_written_is_read(signal: Signal, data: st.DataObject) -> None:
    signal = plain(signal)
    values = {name: data.draw(values_of(f.kind)) for name, f in signal.fields.items()}
    message = signal.read(signal.encode((3, 4), 5, list(values.values())))
    if signal.start:
        assert message.stamp == (3, 4)
    if signal.is_stepped:
        assert message.step == 5
    for name, value in values.items():
        found = message[name]
        assert repr(found) == repr(tuple(value) if isinstance(value, list) else value)


def test_messages_that_nest_words_are_those_of_rclpy() -> None:
    kind = message_class(graph.DIAGNOSTICS)
    from rclpy.serialization import deserialize_message

    entries = [{"key": "step", "value": "3"}, {"key": "", "value": "x"}]
    status = {"level": 1, "name": "plant", "message": "odd", "values": entries}
    data = graph.DIAGNOSTICS.encode((1, 2), 0, ([status, {"name": "b"}],))
    message = deserialize_message(data, kind)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 2)
    first, second = message.status
    assert (first.level, first.name, first.message) == (b"\x01", "plant", "odd")
    assert [(entry.key, entry.value) for entry in first.values] == [("step", "3"), ("", "x")]
    assert (second.level, second.name, list(second.values)) == (b"\0", "b", [])


def test_markers_are_those_of_rclpy() -> None:
    kind = message_class(ZONE_MARKERS)
    from rclpy.serialization import deserialize_message

    marker = {
        "header": {"frame_id": "inertial"}, "ns": "zone/star", "id": 2, "scale": (0.5, 0.0, 0.0),
        "color": (0.5, 0.25, 0.0, 1.0), "frame_locked": True, "points": [(1.0, 2.0, 3.0)] * 2,
    }  # fmt: skip
    message = deserialize_message(ZONE_MARKERS.encode((0, 0), 0, ([marker, {}],)), kind)
    first, second = message.markers
    assert (first.header.frame_id, first.ns, first.id, first.scale.x) == (
        "inertial", "zone/star", 2, 0.5,
    )  # fmt: skip
    assert (first.color.g, first.frame_locked, first.points[1].z) == (0.25, True, 3.0)
    assert (second.ns, second.mesh_file.filename, list(second.points)) == ("", "", [])


def test_another_frame_is_read() -> None:
    other = Signal(name="x", type=TORQUE.type, fields=TORQUE.fields, frame="somebody's")
    data = other.encode((1, 2), 3, ((0.0, 0.5, 0.0), 4))
    message = TORQUE.decode(data)
    assert (message.step, message["torque"], message["source"]) == (3, (0.0, 0.5, 0.0), 4)


def test_frames_of_any_length_do_not_fill_the_memory() -> None:
    for i in range(300):
        other = Signal(name="x", type=TORQUE.type, fields=TORQUE.fields, frame="f" * i)
        assert TORQUE.decode(other.encode((0, 0), i, ((0.0, 0.0, 0.0), 0))).step == i
    codec = TORQUE._codec
    assert codec is not None
    assert len(codec._layouts) <= 64


def test_big_endian_messages_are_read() -> None:
    data = b"\x00\x00\x00\x00" + struct.pack(">iI", 7, 8)
    assert graph.CLOCK.read(data)["clock"] == (7, 8)


def test_nan_and_infinity_survive() -> None:
    values = (math.nan, math.inf, -math.inf)
    message = TORQUE.read(TORQUE.encode((0, 0), 7, rigid_body.Torque(np.array(values), 4)))
    assert repr(message["torque"]) == repr(values)


def test_an_unpadded_end_is_read() -> None:
    data = TORQUE.encode((0, 0), 7, rigid_body.Torque(np.zeros(3), 4))
    assert TORQUE.read(data[:-3])["source"] == 4


@pytest.mark.parametrize("cut", [*range(0, 188, 7), 185, 186, 187])
def test_messages_that_were_cut_off_are_refused(cut: int) -> None:
    data = STATE.encode((0, 0), 1, rigid_body.StateAndRate(_state(), np.zeros(3)))
    with pytest.raises(Refused, match="no AttitudeState"):
        STATE.read(data[:cut])


def test_a_sequence_that_claims_more_than_there_is_is_refused() -> None:
    nothing = ["", "", 0, 0, 0.0, 0.0, [0.0] * 6, 0.0, [1.0], 0.0, 0.0, "", [], [], [], 0.0, 0.0]
    data = bytearray(SOLVER_STATUS.encode((0, 0), 1, nothing))
    at = bytes(data).index(struct.pack("<d", 1.0)) - 8
    data[at : at + 4] = b"\xff\xff\xff\x7f"
    with pytest.raises(Refused, match="zone_margins would end behind them"):
        SOLVER_STATUS.read(bytes(data))


@pytest.mark.parametrize("values", [((0.0,) * 3,), ((0.0,) * 4, 1), ("x", 1), ((0.0,) * 3, 300)])
def test_values_that_do_not_fit_are_refused(values: Any) -> None:
    with pytest.raises(ShapeError, match=r"TorqueCommand: .*required torque, source"):
        plain(TORQUE).encode((0, 0), 1, values)


def test_a_sequence_of_messages_is_written_but_not_read() -> None:
    with pytest.raises(Refused, match="are not read here"):
        ZONE_MARKERS.read(b"")
    assert Field("float64[9]").shape == (9,)
    assert STATE.fields["angular_velocity"].shape == (3,)
    assert (Field("string").shape, Field("float64[]").shape) == ((), (0,))


def _state() -> Any:
    from spacecraft_gnc.loop.protocols import State

    return State(1, np.eye(3), np.zeros(3))
