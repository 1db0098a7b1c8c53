"""Signals of a spacecraft with reaction wheels: state, command, solve and diagnosis."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.signals import ANY, ROTATION, Field, Message, Rule, Signal
from spacecraft_gnc.signals.applied import Applied
from spacecraft_gnc.signals.attitude import (
    ACCEPTED_TARGET,
    ATTITUDE_ERROR,
    BODY_FRAME,
    GOVERNOR_STATUS,
    INERTIAL_FRAME,
    POSE,
    REFERENCE,
    TARGET,
    quaternion_of,
)
from spacecraft_gnc.signals.graph import CONTROL, CONTROLLER, GOVERNOR, MOTION, PLANT
from spacecraft_gnc.signals.structures import QUATERNION, VECTOR3
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Mode, Rest, Terminal
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

_SOURCE: Final = Rule(most=max(Source))
_SOURCES: Final = tuple(Source)
_OF_A_SOLVE: Final = Rule(when=("status", 0))
"""Finite in what SolverStatus.CONVERGED says was found."""


class Accelerations(NamedTuple):
    """Wheel accelerations as commanded or applied."""

    control: Array
    """(m,) relative to the bus [rad/s^2]."""
    source: Source


class Motion(NamedTuple):
    """A state, what acted over the step before it, and its energy."""

    state: WheelState
    applied: Accelerations
    kinetic_energy: float
    """[J]"""


def _pack_motion(motion: Motion) -> tuple[Any, ...]:
    state, (acceleration, source), energy = motion
    return (
        state.attitude,
        quaternion_of(state.attitude),
        state.angular_velocity,
        state.total_momentum,
        state.wheel_speed,
        state.healthy,
        acceleration,
        int(source),
        energy,
    )


def _unpack_state(message: Message) -> WheelState:
    return WheelState(
        message.step,
        message.array("attitude").reshape(3, 3),
        message.array("angular_velocity"),
        message.array("wheel_speed"),
        message.array("total_momentum"),
        np.array(message["healthy"], dtype=bool),
        message.array("applied_acceleration"),
    )


def _pack_command(command: Any) -> tuple[Any, ...]:
    return command.control, int(command.source)


def _unpack_command(message: Message) -> Accelerations:
    return Accelerations(message.array("acceleration"), _SOURCES[message["source"]])


STATE: Final = Signal(
    name="wheel_state",
    type="spacecraft_gnc_msgs/msg/WheelState",
    fields={
        "attitude": Field("float64[9]", "-", ROTATION),
        "orientation": Field(QUATERNION, "-"),
        "angular_velocity": Field(VECTOR3, "rad/s"),
        "total_momentum": Field(VECTOR3, "N m s"),
        "wheel_speed": Field("float64[]", "rad/s"),
        "healthy": Field("bool[]"),
        "applied_acceleration": Field("float64[]", "rad/s^2"),
        "applied_source": Field("uint8", "-", _SOURCE),
        "kinetic_energy": Field("float64", "J"),
    },
    publishers=(PLANT,),
    subscribers=(CONTROLLER, GOVERNOR),
    frame=INERTIAL_FRAME,
    unique=True,
    rank=MOTION,
    pack=_pack_motion,
    unpack=_unpack_state,
)
COMMAND: Final = Signal(
    name="wheel_command",
    type="spacecraft_gnc_msgs/msg/WheelCommand",
    fields={
        "acceleration": Field("float64[]", "rad/s^2"),
        "source": Field("uint8", "-", _SOURCE),
    },
    publishers=(CONTROLLER,),
    subscribers=(PLANT,),
    frame=BODY_FRAME,
    rank=CONTROL,
    pack=_pack_command,
    unpack=_unpack_command,
)
SOLVER_STATUS: Final = Signal(
    name="wheel_solver_status",
    type="spacecraft_gnc_msgs/msg/WheelSolverStatus",
    fields={
        "method": Field("string"),
        "model": Field("string"),
        "solver": Field("string"),
        "status": Field("uint8", "-"),
        "terminal": Field("uint8", "-", Rule(most=max(Terminal))),
        "iterations": Field("uint32", "-"),
        "restarts": Field("uint32", "-"),
        "residual": Field("float64", "-", _OF_A_SOLVE),
        "cost": Field("float64", "-", _OF_A_SOLVE),
        "terminal_violation": Field("float64", "rad", _OF_A_SOLVE),
        "min_curvature": Field("float64", "-", ANY),
        "terminal_attitude": Field("float64[9]", "-", _OF_A_SOLVE),
        "planned": Field("bool[]"),
        "drift": Field("float64[]", "rad/s", _OF_A_SOLVE),
        "predicted_attitudes": Field("float64[]", "-", _OF_A_SOLVE),
        "predicted_speeds": Field("float64[]", "rad/s", _OF_A_SOLVE),
        "predicted_accelerations": Field("float64[]", "rad/s^2", _OF_A_SOLVE),
        "predicted_torques": Field("float64[]", "N m", _OF_A_SOLVE),
        "terminal_multipliers": Field("float64[]", "-", _OF_A_SOLVE),
        "wall_solve_time": Field("float64", "s", ANY),
        "wall_deadline_slack": Field("float64", "s", ANY),
    },
    publishers=(CONTROLLER,),
    frame=BODY_FRAME,
    rank=CONTROL + 1,
)
DIAGNOSIS: Final = Signal(
    name="wheel_diagnosis",
    type="spacecraft_gnc_msgs/msg/WheelDiagnosis",
    fields={
        "healthy": Field("bool[]"),
        "residual": Field("float64[]", "rad/s", ANY),
        "threshold": Field("float64[]", "rad/s", ANY),
        "response": Field("float64[]", "-", ANY),
        "mode": Field("uint8", "-", Rule(most=max(Mode))),
        "rest": Field("uint8", "-", Rule(most=max(Rest))),
        "remaining_rate": Field(VECTOR3, "rad/s"),
        "held_attitude": Field("float64[9]", "-", ROTATION),
        "pointing_loss": Field("float64", "rad"),
    },
    publishers=(CONTROLLER,),
    frame=BODY_FRAME,
    rank=CONTROL + 1,
)
APPLIED: Final = Applied(STATE, "applied_acceleration", "applied_source", COMMAND, "acceleration")
SIGNALS: Final = (
    STATE,
    REFERENCE,
    TARGET,
    ACCEPTED_TARGET,
    COMMAND,
    SOLVER_STATUS,
    DIAGNOSIS,
    ATTITUDE_ERROR,
    GOVERNOR_STATUS,
    POSE,
)
