"""Signals of the docking vehicle: relative state, wrench, reference and the governor's account."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.signals import ANY, ROTATION, Field, Message, Rule, Signal
from spacecraft_gnc.signals.applied import Applied
from spacecraft_gnc.signals.graph import (
    CONTROL,
    CONTROLLER,
    GOVERNOR,
    GUIDANCE,
    MOTION,
    PLANT,
    WISH,
)
from spacecraft_gnc.signals.qos import COMMAND as ON_DEMAND
from spacecraft_gnc.signals.qos import STREAM, QosProfile, latched
from spacecraft_gnc.signals.rules import INFINITE
from spacecraft_gnc.signals.signal import LAST, STAMPED
from spacecraft_gnc.signals.structures import POSE as POSE_KIND
from spacecraft_gnc.signals.structures import QUATERNION, VECTOR3, WRENCH
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.docking.decision import Answer, DockingDecision, Phase
from spacecraft_gnc.vehicles.docking.state import (
    Navigation,
    RelativeReference,
    RelativeState,
)

CHIEF_FRAME: Final = "chief"
_SOURCE: Final = Rule(most=max(Source))
_SOURCES: Final = tuple(Source)


class Wrench(NamedTuple):
    """Force and moment as commanded or asked for."""

    control: Array
    """(6,) force [N] and moment [N m], chief frame."""
    source: Source


class Motion(NamedTuple):
    """A state, what acted over the step before it, and the attitude of the chief."""

    state: RelativeState
    applied: Wrench
    chief_attitude: Matrix3
    """(3, 3) rotation, chief to Hill."""


def _pack_motion(motion: Motion) -> tuple[Any, ...]:
    state, (wrench, source), chief = motion
    measured = state.measured
    return (
        state.port_offset,
        state.port_velocity,
        state.attitude,
        lie.to_quaternion_xyzw(state.attitude),
        state.angular_velocity,
        measured.port_offset,
        measured.port_velocity,
        measured.attitude,
        measured.angular_velocity,
        state.line_of_sight_margin,
        state.clearance,
        state.thrusters,
        wrench,
        int(source),
        chief,
    )


def _unpack_state(message: Message) -> RelativeState:
    return RelativeState(
        message.step,
        message.array("port_offset"),
        message.array("port_velocity"),
        message.array("attitude").reshape(3, 3),
        message.array("angular_velocity"),
        Navigation(
            message.array("measured_port_offset"),
            message.array("measured_port_velocity"),
            message.array("measured_attitude").reshape(3, 3),
            message.array("measured_angular_velocity"),
        ),
        message["line_of_sight_margin"],
        message["clearance"],
        np.array(message["thrusters"], dtype=bool),
        message.array("applied_wrench"),
    )


def _pack_command(command: Any) -> tuple[Any, ...]:
    return command.control, int(command.source)


def _unpack_command(message: Message) -> Wrench:
    return Wrench(message.array("wrench"), _SOURCES[message["source"]])


def _unpack_reference(message: Message) -> RelativeReference:
    return RelativeReference(message.array("port_offset"), message.array("rotation_vector"))


def _pack_decision(decision: DockingDecision) -> tuple[Any, ...]:
    active = decision.active
    return (
        decision.law,
        int(decision.answer),
        int(decision.phase),
        decision.wish,
        decision.reference.vector,
        decision.slack,
        decision.constraint,
        decision.constraint_ahead,
        "; ".join(a.name for a in active),
        [a.row for a in active],
        [a.ahead for a in active],
        [a.multiplier for a in active],
        decision.iterations,
        decision.residual,
        decision.lost_thruster,
        decision.response_error,
        decision.decision_time,
    )


def _reference(
    name: str,
    publishers: tuple[str, ...],
    subscribers: tuple[str, ...],
    *,
    qos: QosProfile = STREAM,
    every_step: bool = False,
    rank: int = LAST,
) -> Signal:
    return Signal(
        name=name,
        type="spacecraft_gnc_msgs/msg/RelativeReference",
        fields={
            "port_offset": Field(VECTOR3, "m"),
            "rotation_vector": Field(VECTOR3, "rad"),
        },
        publishers=publishers,
        subscribers=subscribers,
        frame=CHIEF_FRAME,
        qos=qos,
        every_step=every_step,
        rank=rank,
        pack=tuple,
        unpack=_unpack_reference,
    )


STATE: Final = Signal(
    name="relative_state",
    type="spacecraft_gnc_msgs/msg/RelativeState",
    fields={
        "port_offset": Field(VECTOR3, "m"),
        "port_velocity": Field(VECTOR3, "m/s"),
        "attitude": Field("float64[9]", "-", ROTATION),
        "orientation": Field(QUATERNION, "-"),
        "angular_velocity": Field(VECTOR3, "rad/s"),
        "measured_port_offset": Field(VECTOR3, "m"),
        "measured_port_velocity": Field(VECTOR3, "m/s"),
        "measured_attitude": Field("float64[9]", "-", ROTATION),
        "measured_angular_velocity": Field(VECTOR3, "rad/s"),
        "line_of_sight_margin": Field("float64", "m"),
        "clearance": Field("float64", "m"),
        "thrusters": Field("bool[6]"),
        "applied_wrench": Field(WRENCH, "N, N m"),
        "applied_source": Field("uint8", "-", _SOURCE),
        "chief_attitude": Field("float64[9]", "-", ROTATION),
    },
    publishers=(PLANT,),
    subscribers=(CONTROLLER, GOVERNOR),
    frame=CHIEF_FRAME,
    unique=True,
    rank=MOTION,
    pack=_pack_motion,
    unpack=_unpack_state,
)
COMMAND: Final = Signal(
    name="wrench_command",
    type="spacecraft_gnc_msgs/msg/WrenchCommand",
    fields={"wrench": Field(WRENCH, "N, N m"), "source": Field("uint8", "-", _SOURCE)},
    publishers=(CONTROLLER,),
    subscribers=(PLANT,),
    frame=CHIEF_FRAME,
    rank=CONTROL,
    pack=_pack_command,
    unpack=_unpack_command,
)
REFERENCE: Final = _reference(
    "docking_reference", (GOVERNOR,), (CONTROLLER,), every_step=True, rank=GUIDANCE
)
TARGET: Final = _reference("docking_target", (), (GOVERNOR,), qos=ON_DEMAND, rank=WISH)
"""Of users; what it says counts where the governor takes it."""
ACCEPTED_TARGET: Final = _reference("accepted_docking_target", (GOVERNOR,), (), qos=latched(10))
"""A target that the governor took in flight, and the step from which on it counts."""
GOVERNOR_STATUS: Final = Signal(
    name="periodic_governor_status",
    type="spacecraft_gnc_msgs/msg/PeriodicGovernorStatus",
    fields={
        "law": Field("string"),
        "status": Field("uint8", "-", Rule(most=max(Answer))),
        "phase": Field("uint8", "-", Rule(most=max(Phase))),
        "wish": Field("float64[6]", "m, rad"),
        "reference": Field("float64[6]", "m, rad"),
        "slack": Field("float64", "-", INFINITE),
        "constraint": Field("string"),
        "constraint_ahead": Field("int32", "-"),
        "active": Field("string"),
        "active_rows": Field("uint32[]", "-"),
        "active_ahead": Field("int32[]", "-"),
        "multipliers": Field("float64[]", "m^2 per unit of the row"),
        "iterations": Field("uint32", "-"),
        "residual": Field("float64", "-", ANY),
        "lost_thruster": Field("int8", "-"),
        "response_error": Field("float64", "m/s", ANY),
        "wall_decision_time": Field("float64", "s", ANY),
    },
    publishers=(GOVERNOR,),
    frame=CHIEF_FRAME,
    rank=GUIDANCE + 1,
    pack=_pack_decision,
)
POSE: Final = Signal(
    name="deputy_pose",
    type="geometry_msgs/msg/PoseStamped",
    fields={"pose": Field(POSE_KIND)},
    start=STAMPED,
    publishers=(PLANT,),
    frame=CHIEF_FRAME,
    rank=MOTION + 2,
)
"""The deputy's center of mass and attitude in the chief frame, for viewers."""
APPLIED: Final = Applied(STATE, "applied_wrench", "applied_source", COMMAND, "wrench")
SIGNALS: Final = (
    STATE,
    REFERENCE,
    TARGET,
    ACCEPTED_TARGET,
    COMMAND,
    GOVERNOR_STATUS,
    POSE,
)
