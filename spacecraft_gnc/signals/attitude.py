"""Signals of vehicles whose reference is an attitude: references, targets, the governor's account.

Attitudes map body to inertial components; quaternions are x, y, z, w, as in ROS 2.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.signals.graph import (
    CONTROL,
    CONTROLLER,
    GOVERNOR,
    GUIDANCE,
    MOTION,
    PLANT,
    WISH,
)
from spacecraft_gnc.signals.message import Message
from spacecraft_gnc.signals.qos import COMMAND, STREAM, QosProfile, latched
from spacecraft_gnc.signals.rules import INFINITE, ROTATION
from spacecraft_gnc.signals.signal import LAST, STAMPED, Field, Signal
from spacecraft_gnc.signals.structures import POSE as POSE_KIND
from spacecraft_gnc.signals.structures import QUATERNION, VECTOR3
from spacecraft_gnc.types import Array, GovernorDecision, Matrix3, Reference, read_only

INERTIAL_FRAME: Final = "inertial"
BODY_FRAME: Final = "body"
SLEW_ACTION: Final = "slew_to"
"""Name of the action SlewTo."""
_STILL: Final = read_only(np.zeros(3))


_Known = tuple[Matrix3, Array]
_recent: tuple[_Known, ...] = ((read_only(np.eye(3)), np.array([0.0, 0.0, 0.0, 1.0])),)


def quaternion_of(attitude: Matrix3) -> Array:
    """Return the quaternion (4,) x, y, z, w of an attitude; those of the last two are at hand.

    A state and its pose are one attitude, and most references are the one before. Two, because all
    nodes may live in one process.
    """
    global _recent  # noqa: PLW0603 - a memo of two entries, replaced as a whole
    newest, *older = _recent
    if attitude is newest[0]:
        return newest[1]
    for entry in older:
        if attitude is entry[0]:
            _recent = entry, newest
            return entry[1]
    quaternion = lie.to_quaternion_xyzw(attitude)
    if not attitude.flags.writeable:
        _recent = (attitude, quaternion), newest
    return quaternion


def _pack_reference(reference: Reference) -> tuple[Any, ...]:
    attitude = reference.attitude
    return attitude, quaternion_of(attitude), reference.angular_velocity, reference.torque


def _unpack_reference(message: Message) -> Reference:
    attitude = message.array("attitude").reshape(3, 3)
    return Reference(attitude, message.array("angular_velocity"), message.array("torque"))


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
        type="spacecraft_gnc_msgs/msg/AttitudeReference",
        fields={
            "attitude": Field("float64[9]", "-", ROTATION),
            "orientation": Field(QUATERNION, "-"),
            "angular_velocity": Field(VECTOR3, "rad/s"),
            "torque": Field(VECTOR3, "N m"),
        },
        publishers=publishers,
        subscribers=subscribers,
        frame=INERTIAL_FRAME,
        qos=qos,
        every_step=every_step,
        rank=rank,
        pack=_pack_reference,
        unpack=_unpack_reference,
    )


REFERENCE: Final = _reference(
    "attitude_reference", (GOVERNOR,), (CONTROLLER,), every_step=True, rank=GUIDANCE
)
TARGET: Final = _reference("target_attitude", (), (GOVERNOR,), qos=COMMAND, rank=WISH)
"""Of users; what it says counts where the governor takes it."""
ACCEPTED_TARGET: Final = _reference("accepted_target", (GOVERNOR,), (), qos=latched(10))
"""A target that the governor took in flight, and the step from which on it counts."""


def _pack_decision(decision: GovernorDecision) -> tuple[Any, ...]:
    return (
        decision.alpha,
        decision.admissible,
        decision.margin,
        decision.active_constraint,
        decision.evaluations,
        decision.violation_step,
        decision.horizon,
        decision.waypoints,
    )


GOVERNOR_STATUS: Final = Signal(
    name="governor_status",
    type="spacecraft_gnc_msgs/msg/GovernorStatus",
    fields={
        "alpha": Field("float64", "-"),
        "admissible": Field("bool"),
        "margin": Field("float64", "", INFINITE),
        "active_constraint": Field("string"),
        "evaluations": Field("uint32", "-"),
        "violation_step": Field("int32", "-"),
        "horizon": Field("uint32", "-"),
        "waypoints": Field("uint32", "-"),
    },
    publishers=(GOVERNOR,),
    frame=INERTIAL_FRAME,
    rank=GUIDANCE + 1,
    pack=_pack_decision,
)
ATTITUDE_ERROR: Final = Signal(
    name="attitude_error",
    type="geometry_msgs/msg/Vector3Stamped",
    fields={"vector": Field(VECTOR3, "rad")},
    start=STAMPED,
    publishers=(CONTROLLER,),
    frame=BODY_FRAME,
    rank=CONTROL + 2,
)
"""Rotation vector from the reference to the attitude, of each step that was answered."""
POSE: Final = Signal(
    name="pose",
    type="geometry_msgs/msg/PoseStamped",
    fields={"pose": Field(POSE_KIND)},
    start=STAMPED,
    publishers=(PLANT,),
    frame=INERTIAL_FRAME,
    rank=MOTION + 2,
)
"""The attitude at the origin of the inertial frame, for viewers."""


def pose_of(attitude: Matrix3) -> tuple[Any, ...]:
    """Return the value of `POSE` for an attitude (3, 3)."""
    return ([0.0, 0.0, 0.0, *quaternion_of(attitude).tolist()],)


def error_of(attitude: Matrix3, reference: Reference) -> tuple[Any, ...]:
    """Return the value of `ATTITUDE_ERROR`: the rotation vector (3,) of R_ref' R [rad]."""
    return (lie.log(reference.attitude.T @ attitude),)


def at_rest(attitude: Matrix3) -> Reference:
    """Return a reference (3, 3) without feed-forward."""
    return Reference(attitude, _STILL, _STILL)
