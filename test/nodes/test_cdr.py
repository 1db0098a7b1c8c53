"""The fast codec writes what rclpy writes, and reads it back."""

from __future__ import annotations

import math
import re
import struct
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from spacecraft_gnc_msgs.msg import (
    AttitudeReference,
    AttitudeState,
    GovernorStatus,
    PlantInvariants,
    SolverStatus,
    TorqueCommand,
    WallTiming,
)
from std_msgs.msg import Header, String, UInt64

from spacecraft_gnc.nodes._markers import encode_zone_markers
from spacecraft_gnc.ros.cdr import Layout, encode
from spacecraft_gnc.scenario import from_sections

BOUNDS = {"b": 2**7, "h": 2**15, "i": 2**31, "q": 2**63}
FRAMES = st.sampled_from(["", "body", "inertial", "a frame", "12345678"])


def solver_status(frame: str) -> SolverStatus:
    return SolverStatus(
        header=Header(frame_id=frame),
        method="shooting",
        formulation="backward_sweep",
        zone_margins=[0.0] * 2,
        active_constraint="star",
        predicted_attitudes=[0.0] * 27,
        predicted_momenta=[0.0] * 9,
        predicted_torques=[0.0] * 6,
    )


def plain(message_type: Any) -> Any:
    return lambda frame: message_type(header=Header(frame_id=frame))


PROTOTYPES = {
    "state": plain(AttitudeState),
    "reference": plain(AttitudeReference),
    "torque": plain(TorqueCommand),
    "invariants": plain(PlantInvariants),
    "timing": plain(WallTiming),
    "pose": plain(PoseStamped),
    "attitude error": plain(Vector3Stamped),
    "governor": lambda f: GovernorStatus(header=Header(frame_id=f), active_constraint="a zone"),
    "solver": solver_status,
    "solver without a solve": lambda f: SolverStatus(header=Header(frame_id=f), method="x"),
    "clock": lambda _: Clock(),
    "step": lambda _: UInt64(),
}


def number(code: str) -> st.SearchStrategy[Any]:
    if code == "?":
        return st.booleans()
    if code == "d":
        return st.floats(allow_nan=False)
    if code.isupper():
        return st.integers(0, 2 * BOUNDS[code.lower()] - 1)
    return st.integers(-BOUNDS[code], BOUNDS[code] - 1)


def codes(layout: Layout) -> str:
    return "".join(c for c in layout._struct.format if c in "?dbBhHiIqQ")


def without_padding(layout: Layout, data: bytes) -> tuple[Any, ...]:
    return layout._struct.unpack(data + b"\0" * (layout.size - len(data)))


@pytest.mark.parametrize("name", PROTOTYPES)
@given(data=st.data())
def test_bytes_equal_those_of_rclpy(name: str, data: st.DataObject) -> None:
    layout = Layout(PROTOTYPES[name](data.draw(FRAMES)))
    values = [data.draw(number(code)) for code in codes(layout)]
    packed = layout.pack(values)
    message = deserialize_message(packed, layout.message_type)
    reference = serialize_message(message)
    if name != "solver without a solve":
        assert len(packed) == -(-len(reference) // 4) * 4  # as RTPS carries it
    # rosidl's size estimate aligns for the elements of empty sequences; garbage fills the surplus.
    reference = reference[: len(packed)]
    # rclpy leaves whatever was in memory in the padding; all that means something is the same.
    assert without_padding(layout, packed) == without_padding(layout, reference)
    assert packed[: len(reference)] == bytes(
        p if p == r or is_padding else r
        for p, r, is_padding in zip(packed, reference, padding(layout), strict=False)
    )
    assert layout.unpack(packed) == layout.unpack(reference) == values


def padding(layout: Layout) -> list[bool]:
    """Tell of each byte whether it is one that the structure leaves out."""
    marks: list[bool] = []
    for count, code in re.findall(r"(\d*)([a-zA-Z?])", layout._struct.format):
        size = struct.calcsize(f"<{count}{code}")
        marks += [code == "x"] * size
    return marks


@pytest.mark.parametrize("name", PROTOTYPES)
def test_packing_is_reproducible(name: str) -> None:
    layout = Layout(PROTOTYPES[name]("body"))
    assert layout.pack(layout.values) == encode(PROTOTYPES[name]("body"))


def test_nan_and_infinity_survive() -> None:
    layout = Layout(Clock())
    assert layout.n_values == 2
    layout = Layout(TorqueCommand())
    values = [0, 0, 7, math.nan, math.inf, -math.inf, 4]
    assert repr(layout.unpack(layout.pack(values))) == repr(values)


def test_another_frame_is_read_the_slow_way() -> None:
    layout = Layout(TorqueCommand(header=Header(frame_id="body")))
    other = TorqueCommand(header=Header(frame_id="somebody"), step=3)
    other.torque.y = 0.5
    data = serialize_message(other)
    assert layout.unpack(data) is None
    assert layout.read(data) == [0, 0, 3, 0.0, 0.5, 0.0, 0]


def test_other_lengths_are_refused() -> None:
    layout = Layout(SolverStatus(predicted_torques=[0.0] * 3))
    with pytest.raises(ValueError, match="numbers"):
        layout.read(serialize_message(SolverStatus(predicted_torques=[0.0] * 6)))


def test_fields_are_found() -> None:
    layout = Layout(AttitudeState(header=Header(frame_id="inertial")))
    assert layout.field("step") == slice(2, 3)
    assert layout.field("attitude") == slice(3, 12)
    assert layout.field("orientation.w") == slice(15, 16)
    assert layout.field("angular_velocity") == slice(19, 22)


def test_any_message_can_be_encoded() -> None:
    status = DiagnosticStatus(
        level=DiagnosticStatus.WARN, name="a", values=[KeyValue(key="k", value="v")] * 2
    )
    message = DiagnosticArray(status=[status, DiagnosticStatus()])
    assert deserialize_message(encode(message), DiagnosticArray) == message
    assert deserialize_message(encode(String(data="recorder")), String).data == "recorder"


def test_zone_markers() -> None:
    from visualization_msgs.msg import MarkerArray

    zone = {"body_axis": [1.0, 0.0, 0.0], "inertial_axis": [0.0, 0.0, 2.0], "half_angle_deg": 60.0}
    section = {"zone_names": ["star"], "zones": {"star": zone}}
    scenario = from_sections(
        {"nmpc_controller": section, "plant": {"inertia": np.eye(3).ravel().tolist()}}
    )
    markers = deserialize_message(
        encode_zone_markers(scenario.controller.zones), MarkerArray
    ).markers
    assert [m.ns for m in markers] == ["zone/star"]
    rim = markers[0].points[0]
    assert rim.z == pytest.approx(0.5)
    assert rim.x**2 + rim.y**2 + rim.z**2 == pytest.approx(1.0)
