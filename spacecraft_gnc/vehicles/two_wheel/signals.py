"""Signals of a spacecraft with reaction wheels: its state and its command."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.signals import ROTATION, Field, Message, Rule, Signal
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
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

_SOURCE: Final = Rule(most=max(Source))
_SOURCES: Final = tuple(Source)


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
APPLIED: Final = Applied(STATE, "applied_acceleration", "applied_source", COMMAND, "acceleration")
SIGNALS: Final = (
    STATE,
    REFERENCE,
    TARGET,
    ACCEPTED_TARGET,
    COMMAND,
    ATTITUDE_ERROR,
    GOVERNOR_STATUS,
    POSE,
)
