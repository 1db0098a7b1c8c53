"""Geometry of pointing zones as cones.

An exclusion cone of half-angle a about d is an inclusion cone of half-angle pi - a about -d, so
every zone becomes "angle(R v, d) <= a" and one rule does for all pairs.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array, Matrix3, Vector3

ANGLE_TOLERANCE: Final = 1e-9
"""Angle [rad] under which directions coincide and cones touch: rounding is a millionth of it."""


class Cone(NamedTuple):
    """The zone ``name``: keep body axis v, seen from the inertial frame, inside or outside."""

    name: str
    kind: str
    """``exclusion`` or ``inclusion``"""
    body_axis: Vector3
    """(3,) unit vector v, body frame."""
    cone_axis: Vector3
    """(3,) unit vector d, inertial frame."""
    half_angle: float
    """[rad]"""

    @property
    def is_exclusion(self) -> bool:
        """Tell whether the body axis has to stay outside."""
        return self.kind == "exclusion"

    @property
    def allowed(self) -> tuple[Vector3, float]:
        """Axis (3,) and half-angle [rad] of the cone that the body axis has to stay inside."""
        if self.is_exclusion:
            return -self.cone_axis, math.pi - self.half_angle
        return self.cone_axis, self.half_angle

    def angle(self, attitude: Matrix3) -> float:
        """Return the angle [rad] between the body axis at an attitude (3, 3) and the cone axis."""
        return float(lie.vector_angle(attitude @ self.body_axis, self.cone_axis))

    def margin(self, attitude: Matrix3) -> float:
        """Return the angle [rad] left to the border at an attitude (3, 3); negative: violated."""
        excess = self.angle(attitude) - self.half_angle
        return excess if self.is_exclusion else -excess

    def is_violated(self, attitude: Matrix3) -> bool:
        """Tell whether the body axis is on the wrong side of the cone at an attitude (3, 3)."""
        return self.margin(attitude) < -ANGLE_TOLERANCE

    def shrunk(self, margin: float) -> Cone:
        """Return the zone that leaves less by an angle [rad] at its border."""
        change = margin if self.is_exclusion else -margin
        return self._replace(half_angle=self.half_angle + change)

    def mirrored(self) -> Cone:
        """Return the same demand, put to the opposite body axis."""
        return self._replace(body_axis=-self.body_axis, cone_axis=-self.cone_axis)


def direction(vector: Array) -> Vector3:
    """Return a vector (3,), not zero, at length 1; no length of a float overflows."""
    scaled = vector / np.abs(vector).max()
    return np.asarray(scaled / np.linalg.norm(scaled))


def leave_nothing(first: Cone, second: Cone) -> bool:
    """Tell whether no attitude satisfies both zones (but where their cones just touch).

    Over all directions b_i inside the cones (d_i, a_i), angle(b_1, b_2) takes every value in
    [0, pi] from angle(d_1, d_2) - a_1 - a_2 to angle(d_1, d_2) + a_1 + a_2, while a rotation keeps
    it at angle(v_1, v_2). Both zones can hold if and only if that value is among them:

        |angle(v_1, v_2) - angle(d_1, d_2)| <= a_1 + a_2
    """
    (axis_1, half_1), (axis_2, half_2) = first.allowed, second.allowed
    between_bodies = lie.vector_angle(first.body_axis, second.body_axis)
    gap = abs(between_bodies - lie.vector_angle(axis_1, axis_2)) - half_1 - half_2
    return bool(gap >= -ANGLE_TOLERANCE)


def implies(first: Cone, second: Cone) -> bool:
    """Tell whether the first zone leaves the second, of the same kind, nothing to forbid."""
    if first.kind != second.kind:
        return False
    if first.body_axis @ second.body_axis < 0.0:
        second = second.mirrored()
    if lie.vector_angle(first.body_axis, second.body_axis) > ANGLE_TOLERANCE:
        return False
    (axis_1, half_1), (axis_2, half_2) = first.allowed, second.allowed
    return bool(lie.vector_angle(axis_1, axis_2) + half_1 <= half_2 + ANGLE_TOLERANCE)
