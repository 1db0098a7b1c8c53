"""3-2-1 Euler angles: yaw about z, then pitch about y, then roll about x."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.arrays import as_finite, as_stack
from spacecraft_gnc.types import Array, Matrix3, Vector3


def from_euler_321(angles: Vector3) -> Matrix3:
    """Return R = Rz(yaw) Ry(pitch) Rx(roll) (3, 3), body to inertial.

    Parameters
    ----------
    angles : (3,) array
        Roll, pitch, yaw [rad].

    Raises
    ------
    ShapeError, ParameterError
        If it is not three finite numbers.
    """
    vector = as_finite("angles", angles, (3,), "roll, pitch, yaw [rad]")
    (cr, cp, cy), (sr, sp, sy) = np.cos(vector), np.sin(vector)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def to_euler_321(attitude: Array) -> Array:
    """Return roll, pitch, yaw (..., 3) [rad] of rotations (..., 3, 3), body to inertial.

    Roll and yaw lie in [-pi, pi], pitch in [-pi/2, pi/2]. NaN where the rotation is not known.
    Raises ShapeError if it is no stack of 3x3 matrices.

    Notes
    -----
    At pitch +-pi/2 only yaw -+ roll is defined; where the last row gives no roll, it is 0. Close to
    it roll is ill-conditioned, by 1 over the cosine of pitch, but yaw is computed from R Rx(-roll)
    and not from the first column, so that the three angles give R back to rounding everywhere.
    """
    r = as_stack("attitude", attitude)
    down, right, up = r[..., 2, 0], r[..., 2, 1], r[..., 2, 2] + 0.0  # + 0.0: no minus zero
    roll = np.arctan2(right, up)
    cosine, sine = np.cos(roll), np.sin(roll)
    pitch = np.arctan2(-down, np.hypot(right, up))
    yaw = np.arctan2(
        sine * r[..., 0, 2] - cosine * r[..., 0, 1], cosine * r[..., 1, 1] - sine * r[..., 1, 2]
    )
    return np.stack([roll, pitch, yaw], axis=-1)
