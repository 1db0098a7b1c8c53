"""Constraint rows C_k x + D_k v <= c_k of the docking loop, in its linear coordinates.

Force and moment are linear in (x, v), and so is the line of sight. A vertex of the deputy is at
port offset + R (vertex - port), of which the rows take the part linear in the rotation vector.
Source: report of AFRL (Kolmanovsky 2016), 3.2.2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from spacecraft_gnc.governors.periodic import PeriodicConstraints
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.law import FeedbackLaw

_SIGNS: Final = ("+", "-")
_AXES: Final = ("x", "y", "z")
WRENCH_NAMES: Final = tuple(
    f"{part} {sign}{axis}" for sign in _SIGNS for part in ("force", "moment") for axis in _AXES
)
SIGHT_NAMES: Final = tuple(f"line of sight {sign}{axis}" for axis in "yz" for sign in _SIGNS)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bounds:
    """What the docking loop has to keep.

    Attributes
    ----------
    force, moment : float
        Largest component [N], [N m].
    slope : float
        Tangent of the half angle of the line-of-sight pyramid.
    slack : float
        By how much it is wider on each side [m].
    depth : float
        By how much a vertex may pass the docking face [m].
    arms : (8, 3) array
        Vertices of the deputy from its port, deputy frame [m].
    """

    force: float
    moment: float
    slope: float
    slack: float
    depth: float
    arms: Array

    @property
    def wrench(self) -> Array:
        """Largest components (6,) of force and moment."""
        return np.repeat([self.force, self.moment], 3)


def constraints(law: FeedbackLaw, bounds: Bounds) -> PeriodicConstraints:
    """Return the rows of force, moment, line of sight and clearance at the start of each step."""
    p, (states, limits) = law.period, _state_rows(bounds)
    most, held = bounds.wrench, law.model.feedforward
    gains, through = law.gains, law.reference_gains
    return PeriodicConstraints(
        np.concatenate([-gains, gains, np.tile(states, (p, 1, 1))], axis=1),
        np.concatenate([through, -through, np.zeros((p, len(states), 6))], axis=1),
        np.concatenate([most - held, most + held, np.tile(limits, (p, 1))], axis=1),
        (*WRENCH_NAMES, *SIGHT_NAMES, *vertex_names(len(bounds.arms))),
    )


def vertex_names(count: int) -> tuple[str, ...]:
    """Return the names of the rows of clearance."""
    return tuple(f"vertex {i + 1} off the docking face" for i in range(count))


def _state_rows(bounds: Bounds) -> tuple[Array, Array]:
    """Return rows (12, 12) on the state alone, and their limits (12,)."""
    rows, limits = np.zeros((4 + len(bounds.arms), 12)), np.full(4, bounds.slack)
    for i, (axis, sign) in enumerate(((1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0))):
        rows[i, 0], rows[i, axis] = -bounds.slope, sign
    for row, arm in zip(rows[4:], bounds.arms, strict=True):
        row[0], row[7], row[8] = -1.0, -arm[2], arm[1]  # (delta x arm)_x
    return rows, np.concatenate([limits, bounds.arms[:, 0] + bounds.depth])
