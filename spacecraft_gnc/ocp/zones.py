"""Pointing zones: cones that a body axis keeps out of, or stays in."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import (
    as_real,
    as_tuple,
    require_kind,
    require_positive,
    require_word,
)
from spacecraft_gnc.arrays import as_stack
from spacecraft_gnc.types import Array, ArrayLike, unit_vector


@dataclass(frozen=True, slots=True)
class PointingZone:
    """A soft cone that a body axis must keep out of, or stay in.

    Attributes
    ----------
    kind : {"exclusion", "inclusion"}
    body_axis : (3,) array
        Direction fixed in the body, body frame; normalized here.
    inertial_axis : (3,) array
        Axis of the cone, inertial frame; normalized here.
    half_angle : float
        Half-angle of the cone [rad], in (0, pi).
    penalty : float
        Weight mu_i of h max(0, H_i)^2, with H_i = +-(v . R^T d - cos(half_angle)) (30).
    """

    kind: Literal["exclusion", "inclusion"]
    body_axis: ArrayLike
    inertial_axis: ArrayLike
    half_angle: float
    penalty: float

    def __post_init__(self) -> None:
        require_word("kind", self.kind, ("exclusion", "inclusion"))
        object.__setattr__(self, "body_axis", unit_vector("body_axis", self.body_axis))
        object.__setattr__(self, "inertial_axis", unit_vector("inertial_axis", self.inertial_axis))
        half_angle = as_real(
            "half_angle", self.half_angle, lambda x: 0.0 < x < math.pi,
            "a number between 0 and pi [rad]", "convert degrees to radians",
        )  # fmt: skip
        object.__setattr__(self, "half_angle", half_angle)
        object.__setattr__(self, "penalty", require_positive("penalty", self.penalty))

    @property
    def sign(self) -> float:
        """+1 for an exclusion, -1 for an inclusion zone."""
        return 1.0 if self.kind == "exclusion" else -1.0

    def margin(self, attitudes: Array) -> Array:
        """Return the angle [rad] from attitudes (..., 3, 3) to the cone (negative: violated)."""
        pointing = as_stack("attitudes", attitudes) @ np.asarray(self.body_axis)
        angle = lie.vector_angle(pointing, np.asarray(self.inertial_axis))
        return np.asarray(self.sign * (angle - self.half_angle))

    def cosine_room(self, attitudes: Array) -> Array:
        """Return -H_i of (30) at attitudes (..., 3, 3): smooth, and negative where violated."""
        return np.asarray(self.sign * (math.cos(self.half_angle) - self._cosine(attitudes)))

    def _cosine(self, attitudes: Array) -> Array:
        axes = (self.body_axis, as_stack("attitudes", attitudes), self.inertial_axis)
        return np.asarray(np.einsum("i,...ji,j->...", *axes))


def as_zones(zones: Iterable[PointingZone]) -> tuple[PointingZone, ...]:
    """Return zones as a tuple; raise ParameterError if one of them is none."""
    given = as_tuple("zones", zones, "PointingZone")
    return tuple(require_kind(f"zones[{i}]", zone, PointingZone) for i, zone in enumerate(given))
