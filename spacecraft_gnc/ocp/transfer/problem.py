"""Optimal control problem of an attitude transfer: from state to state in a fixed time.

    minimize   sum over k < N of |u_k|^2 / 2
    subject to the steps of `spacecraft_gnc.dynamics`,
               (R_0, Pi_0) and (R_N, Pi_N) given,
               u_low <= u_k <= u_high  for k = 0 .. N-1,
               Pi_low <= Pi_k <= Pi_high  for k = 1 .. N-1.

Source: Phogat et al., (3.1)-(3.4), with bounds that need not be symmetric.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_count, require_kind
from spacecraft_gnc.arrays import as_float
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Matrix3,
    Vector3,
    as_rotation,
    as_vector3,
    read_only,
)

REST: Final = np.zeros(3)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class AttitudeTransfer:
    """Transfer between two attitudes in ``n_steps`` steps of the body.

    Attributes
    ----------
    body : RigidBody
        Inertia, and the time step h.
    n_steps : int
        N; the transfer takes N h.
    start, goal : (3, 3) arrays
        First and last attitude, body to inertial.
    start_momentum, goal_momentum : (3,) arrays
        First and last momentum, body frame [N m s].
    torque, momentum : bounds, optional
        None: none. A number or (3,): two-sided, per component. A pair of such: lower and upper
        bounds, where infinity is none [N m], [N m s].

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused, or the first or last momentum lies outside its bounds.
    """

    body: RigidBody
    n_steps: int
    goal: Matrix3
    start: Matrix3 = field(default_factory=lambda: np.eye(3))
    start_momentum: Vector3 = field(default_factory=lambda: REST)
    goal_momentum: Vector3 = field(default_factory=lambda: REST)
    torque: ArrayLike | tuple[ArrayLike, ArrayLike] | None = None
    momentum: ArrayLike | tuple[ArrayLike, ArrayLike] | None = None
    limits: Array = field(init=False, repr=False)
    """(4, 3): lower and upper torque, lower and upper momentum."""

    def __post_init__(self) -> None:
        require_kind("body", self.body, RigidBody)
        limits = np.vstack([_bounds("torque", self.torque), _bounds("momentum", self.momentum)])
        checked = {
            "n_steps": as_count("n_steps", self.n_steps, least=2, remedy="lengthen the transfer"),
            "start": as_rotation("start", self.start),
            "goal": as_rotation("goal", self.goal),
            "start_momentum": as_vector3("start_momentum", self.start_momentum),
            "goal_momentum": as_vector3("goal_momentum", self.goal_momentum),
            "limits": read_only(limits),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        for name in ("start_momentum", "goal_momentum"):
            value = getattr(self, name)
            self.body.require_solvable(name, value)
            if (value < limits[2]).any() or (value > limits[3]).any():
                raise ParameterError(
                    f"{name}: received {value.tolist()} N m s; required within the bounds "
                    f"{limits[2].tolist()} to {limits[3].tolist()}; widen the bounds"
                )

    @property
    def duration(self) -> float:
        """N h [s]."""
        return self.n_steps * self.body.time_step

    @property
    def angle(self) -> float:
        """Angle between the two attitudes [rad]."""
        return lie.angle_between(self.start, self.goal)


def _bounds(name: str, value: ArrayLike | tuple[ArrayLike, ArrayLike] | None) -> Array:
    """Return bounds as (2, 3), lower and upper."""
    if value is None:
        return np.array([[-math.inf] * 3, [math.inf] * 3])
    if isinstance(value, tuple) and len(value) == 2:
        pair = [as_float(name, side, "a number or three") for side in value]
    else:
        size = as_float(name, value, "a number or three")
        pair = [-size, size]
    try:
        bounds = np.array([np.broadcast_to(side, (3,)) for side in pair])
    except ValueError:
        bounds = np.full((2, 3), math.nan)
    if not ((bounds[0] < 0.0) & (bounds[1] > 0.0)).all():
        raise ParameterError(
            f"{name}: received bounds {bounds.tolist()}; required lower ones below zero and upper "
            "ones above; give a positive number, or None for no bound"
        )
    return bounds
