"""Core values to serialized messages and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock
from spacecraft_gnc_msgs.msg import (
    AttitudeReference,
    AttitudeState,
    PlantInvariants,
    TorqueCommand,
    WallTiming,
)
from std_msgs.msg import Header, String

from spacecraft_gnc import lie
from spacecraft_gnc.loop import guards
from spacecraft_gnc.loop.protocols import (
    Command,
    Invariants,
    Reference,
    Source,
    State,
)
from spacecraft_gnc.ros.cdr import Layout
from spacecraft_gnc.ros.topics import BODY_FRAME, INERTIAL_FRAME
from spacecraft_gnc.types import Vector3

_NS_PER_S = 1_000_000_000
_INERTIAL = Header(frame_id=INERTIAL_FRAME)
_BODY = Header(frame_id=BODY_FRAME)
_STATE = Layout(AttitudeState(header=_INERTIAL))
_REFERENCE = Layout(AttitudeReference(header=_INERTIAL))
_TORQUE = Layout(TorqueCommand(header=_BODY))
_INVARIANTS = Layout(PlantInvariants(header=_INERTIAL))
_POSE = Layout(PoseStamped(header=_INERTIAL))
_ERROR = Layout(Vector3Stamped(header=_BODY))
_CLOCK = Layout(Clock())
_WALL_TIMING = Layout(WallTiming())

# Where the numbers lie: every message of ours starts with seconds, nanoseconds, step.
_STEP = 2
_ATTITUDE = slice(3, 12)
_STATE_MOMENTUM = slice(16, 19)
_STATE_RATE = slice(19, 22)
_REFERENCE_RATE = slice(16, 19)
_REFERENCE_TORQUE = slice(19, 22)
_TORQUE_VECTOR = slice(3, 6)
_TORQUE_SOURCE = 6
_SOURCES = tuple(Source)

Stamp = tuple[int, int]
"""Seconds and nanoseconds."""


class Refused(Exception):
    """A message that must not reach a core, and why."""


class Torque(NamedTuple):
    """A torque command as received."""

    step: int
    torque: Vector3
    source: Source


def period_ns(period: float) -> int:
    """Return the control period in whole nanoseconds: simulated time never rounds again."""
    return round(period * _NS_PER_S)


def stamp_of(step: int, period_in_ns: int) -> Stamp:
    """Return the simulated time t_k of a control step."""
    return divmod(step * period_in_ns, _NS_PER_S)


def encode_state(stamp: Stamp, state: State, angular_velocity: Vector3) -> bytes:
    """Serialize an AttitudeState."""
    return _STATE.pack(
        [
            *stamp,
            state.step,
            *state.attitude.ravel().tolist(),
            *lie.to_quaternion_xyzw(state.attitude).tolist(),
            *state.momentum.tolist(),
            *angular_velocity.tolist(),
        ]
    )


def decode_state(data: bytes, last_step: int) -> tuple[Stamp, State, Vector3]:
    """Return stamp, state and body rate (3,) [rad/s] of an AttitudeState.

    Raises
    ------
    Refused
        If it is no state, or older than ``last_step``.
    """
    v = _read(_STATE, data)
    attitude, momentum = v[_ATTITUDE], v[_STATE_MOMENTUM]
    _check(guards.reject_state(v[_STEP], attitude, momentum, last_step))
    _check(guards.reject_vector("angular_velocity", v[_STATE_RATE]))
    state = State(v[_STEP], np.array(attitude).reshape(3, 3), np.array(momentum))
    return (v[0], v[1]), state, np.array(v[_STATE_RATE])


def encode_reference(stamp: Stamp, step: int, reference: Reference) -> bytes:
    """Serialize an AttitudeReference."""
    return _REFERENCE.pack(
        [
            *stamp,
            step,
            *reference.attitude.ravel().tolist(),
            *lie.to_quaternion_xyzw(reference.attitude).tolist(),
            *reference.angular_velocity.tolist(),
            *reference.torque.tolist(),
        ]
    )


def decode_reference(data: bytes, last_step: int = 0) -> tuple[int, Reference]:
    """Return step and reference of an AttitudeReference.

    Raises
    ------
    Refused
        If it is no reference, or older than ``last_step``.
    """
    v = _read(_REFERENCE, data)
    rate, torque = v[_REFERENCE_RATE], v[_REFERENCE_TORQUE]
    _check(guards.reject_reference(v[_STEP], v[_ATTITUDE], last_step))
    _check(guards.reject_vector("angular_velocity", rate))
    _check(guards.reject_vector("torque", torque))
    attitude = np.array(v[_ATTITUDE]).reshape(3, 3)
    return v[_STEP], Reference(attitude, np.array(rate), np.array(torque))


def encode_torque(stamp: Stamp, step: int, command: Command) -> bytes:
    """Serialize a TorqueCommand."""
    return _TORQUE.pack([*stamp, step, *command.torque.tolist(), int(command.source)])


def decode_torque(data: bytes) -> Torque:
    """Return a TorqueCommand.

    Raises
    ------
    Refused
        If it is none.
    """
    v = _read(_TORQUE, data)
    torque, source = v[_TORQUE_VECTOR], v[_TORQUE_SOURCE]
    _check(guards.reject_vector("torque", torque))
    if source >= len(_SOURCES):
        raise Refused(f"source is {source}; required 0 to {len(_SOURCES) - 1}")
    return Torque(v[_STEP], np.array(torque), _SOURCES[source])


def encode_invariants(
    stamp: Stamp, step: int, invariants: Invariants, applied: tuple[Vector3, Source]
) -> bytes:
    """Serialize a PlantInvariants; ``applied`` is what acted over the step that ended now."""
    energy, momentum, orthogonality_error = invariants
    torque, source = applied
    return _INVARIANTS.pack(
        [
            *stamp,
            step,
            energy,
            *momentum.tolist(),
            orthogonality_error,
            *torque.tolist(),
            int(source),
        ]
    )


def encode_pose(stamp: Stamp, state: State) -> bytes:
    """Serialize a PoseStamped at the origin of the inertial frame."""
    quaternion = lie.to_quaternion_xyzw(state.attitude).tolist()
    return _POSE.pack([*stamp, 0.0, 0.0, 0.0, *quaternion])


def encode_attitude_error(stamp: Stamp, state: State, reference: Reference) -> bytes:
    """Serialize the rotation vector of R_ref' R as a Vector3Stamped, body frame [rad].

    Its length is the angle from the reference to the attitude.
    """
    error = lie.log(reference.attitude.T @ state.attitude)
    return _ERROR.pack([*stamp, *error.tolist()])


def encode_clock(stamp: Stamp) -> bytes:
    """Serialize a Clock."""
    return _CLOCK.pack(stamp)


def encode_wall_timing(stamp: Stamp, step: int, timing: Sequence[float]) -> bytes:
    """Serialize a WallTiming from its six fields after ``step``."""
    return _WALL_TIMING.pack([*stamp, step, *timing])


def decode_string(data: bytes) -> str:
    """Return the text of a String."""
    return str(deserialize_message(data, String).data)


def _read(layout: Layout, data: bytes) -> list[Any]:
    try:
        return layout.read(data)
    except (RuntimeError, ValueError) as error:
        name = layout.message_type.__name__
        raise Refused(f"{len(data)} bytes that are no {name} ({error})") from error


def _check(reason: str | None) -> None:
    if reason is not None:
        raise Refused(reason)
