"""Rotation group SO(3)."""

from spacecraft_gnc.lie.so3 import (
    angle_between,
    angles_between,
    exp,
    from_quaternion_xyzw,
    hat,
    is_rotation,
    log,
    orthonormalize,
    to_quaternion_xyzw,
    vector_angle,
    vee,
)

__all__ = [
    "angle_between",
    "angles_between",
    "exp",
    "from_quaternion_xyzw",
    "hat",
    "is_rotation",
    "log",
    "orthonormalize",
    "to_quaternion_xyzw",
    "vector_angle",
    "vee",
]
