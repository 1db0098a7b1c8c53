"""Attitude over time as quaternions, roll-pitch-yaw angles and rotation vectors.

All of them describe the rotation R that maps body to inertial components. Rows that are not a
rotation because the recording lost them are NaN, and a series goes on behind them.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array

GIMBAL_LOCK_DEG: Final = 1.0
"""Distance of the pitch from +-90 deg [deg] below which roll and yaw cannot be told apart."""


class Representation(NamedTuple):
    """How to label one description of the attitude."""

    name: str
    title: str
    components: tuple[str, ...]
    unit: str
    convention: str


QUATERNION: Final = Representation(
    "quaternion",
    "Attitude as unit quaternion x, y, z, w",
    ("x", "y", "z", "w"),
    "-",
    "Unit quaternion in the order x, y, z, w (w is the scalar part, as in ROS), body to inertial. "
    "q and -q are the same attitude: the sign is chosen so that the curve is continuous, and w is "
    "not negative at the start.",
)
ROLL_PITCH_YAW: Final = Representation(
    "roll_pitch_yaw",
    "Attitude as roll, pitch, yaw",
    ("roll", "pitch", "yaw"),
    "deg",
    "R = Rz(yaw) Ry(pitch) Rx(roll), body to inertial: turns about the inertial x, y, z axes in "
    "this order, or about the body z, y', x'' axes. Pitch lies in -90 to 90 deg; roll and yaw go "
    "on beyond 180 deg instead of jumping. Gimbal lock: at pitch +-90 deg only the sum or the "
    "difference of roll and yaw is defined, and both may jump.",
)
ROTATION_VECTOR: Final = Representation(
    "rotation_vector",
    "Attitude as rotation vector",
    ("x", "y", "z"),
    "rad",
    "Axis times angle, R = exp(hat(v)), body to inertial; v has the same components in both "
    "frames. Its length goes on beyond pi instead of jumping to the opposite axis.",
)
REPRESENTATIONS: Final = (QUATERNION, ROLL_PITCH_YAW, ROTATION_VECTOR)


def values(representation: Representation, attitudes: Array) -> Array:
    """Return (n, components) values of a representation for attitudes (n, 3, 3)."""
    functions = {
        QUATERNION.name: quaternions_xyzw,
        ROLL_PITCH_YAW.name: roll_pitch_yaw_deg,
        ROTATION_VECTOR.name: rotation_vectors,
    }
    return functions[representation.name](attitudes)


def quaternions_xyzw(attitudes: Array) -> Array:
    """Return (n, 4) unit quaternions x, y, z, w of attitudes (n, 3, 3), continuous in sign.

    w >= 0 in the first row. As in `lie.to_quaternion_xyzw`, the largest of the four squared
    components is found first, so that nothing is divided by a small number.
    """
    r = np.asarray(attitudes)
    trace = np.trace(r, axis1=1, axis2=2)
    squares = np.column_stack([1.0 + 2.0 * np.diagonal(r, axis1=1, axis2=2) - trace[:, None],
                               1.0 + trace])  # fmt: skip
    skew = np.column_stack(
        [r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]]
    )
    # Rows of 4 q q^T; the one of the largest component is the best conditioned.
    outer = np.empty((len(r), 4, 4))
    outer[:, :3, :3] = r + r.transpose(0, 2, 1)
    outer[:, :3, 3] = outer[:, 3, :3] = skew
    outer[:, range(4), range(4)] = squares
    largest = np.argmax(np.where(np.isnan(squares), -np.inf, squares), axis=1)
    raw = outer[np.arange(len(r)), largest]
    return _continuous(raw / np.linalg.norm(raw, axis=1, keepdims=True))


def _continuous(quaternions: Array) -> Array:
    """Choose each sign so that no row lies opposite to the known one before it."""
    known = np.isfinite(quaternions).all(axis=1)
    q = quaternions[known]
    if not len(q):
        return quaternions
    turned = np.where(np.einsum("ni,ni->n", q[1:], q[:-1]) < 0.0, -1.0, 1.0)
    start = -1.0 if q[0, 3] < 0.0 else 1.0
    result = quaternions.copy()
    result[known] = q * np.cumprod(np.append(start, turned))[:, None]
    return result


def roll_pitch_yaw_deg(attitudes: Array) -> Array:
    """Return (n, 3) roll, pitch, yaw of R = Rz(yaw) Ry(pitch) Rx(roll) [deg].

    Roll and yaw continue beyond 180 deg. Within `GIMBAL_LOCK_DEG` of pitch +-90 deg they are not
    well defined (`near_gimbal_lock`).
    """
    r = np.asarray(attitudes)
    roll = np.arctan2(r[:, 2, 1], r[:, 2, 2])
    pitch = np.arctan2(-r[:, 2, 0], np.hypot(r[:, 0, 0], r[:, 1, 0]))
    yaw = np.arctan2(r[:, 1, 0], r[:, 0, 0])
    angles = np.column_stack([_unwrapped(roll), pitch, _unwrapped(yaw)])
    return np.asarray(np.degrees(angles))


def near_gimbal_lock(attitudes: Array) -> NDArray[np.bool_]:
    """Tell of (n,) attitudes whether the pitch is within `GIMBAL_LOCK_DEG` of +-90 deg."""
    cosine = np.hypot(attitudes[:, 0, 0], attitudes[:, 1, 0])
    return np.asarray(cosine < math.sin(math.radians(GIMBAL_LOCK_DEG)))


def rotation_vectors(attitudes: Array) -> Array:
    """Return (n, 3) rotation vectors [rad], continuous beyond the half turn."""
    q = quaternions_xyzw(attitudes)
    sine = np.linalg.norm(q[:, :3], axis=1)
    angle = 2.0 * np.arctan2(sine, q[:, 3])
    factor = np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 2.0)
    return np.asarray(factor[:, None] * q[:, :3])


def _unwrapped(angles: Array) -> Array:
    """Remove jumps by whole turns [rad]; rows that are NaN stay so."""
    known = np.isfinite(angles)
    result = angles.copy()
    result[known] = np.unwrap(angles[known])
    return result
