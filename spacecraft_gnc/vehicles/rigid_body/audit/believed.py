"""Steps of the body that a planner believes, and commands that keep its bounds, many at once.

With the quaternion (q0, q) of the turn F the step's implicit equation is

    2 q0 J q + 2 q x J q = h Pi,   q0 = sqrt(1 - |q|^2),

solved here by Newton's method from h J^-1 Pi / 2. What torque does not reach is F^T Pi, so that
bounds on the next momentum are bounds on the torque.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit.matrices import hats, times, transposed
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import plan_parameters, real_limits
from spacecraft_gnc.vehicles.rigid_body.scenario import known_inertia

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

_SOLVES: Final = 12
"""Newton steps: each squares the error of a step that turns by less than a quarter."""
_GUARDED: Final = 0.5
"""Share of the momentum's reserve that commands keep, too: docs/planned.md."""


@dataclass(frozen=True, slots=True, eq=False)
class Believed:
    """The body that is planned for, with the control period as its step, and its real bounds."""

    inertia: Array
    """(3, 3) [kg m^2]."""
    period: float
    """h [s]."""
    limits: Array
    """(4, 3) lower and upper torque [N m], lower and upper momentum [N m s]."""

    @classmethod
    def of(cls, scenario: Scenario) -> Believed:
        """Return that of a scenario which plans."""
        inertia = known_inertia(scenario, "nmpc_controller", scenario.controller.inertia)
        kept = 1.0 - _GUARDED * plan_parameters(scenario).momentum_reserve
        limits = np.array(real_limits(scenario))
        limits[2:] *= kept
        return cls(np.asarray(inertia), scenario.period, limits)

    def turns(self, momenta: Array) -> Array:
        """Return F (m, 3, 3) of momenta (m, 3); NaN where the step does not exist."""
        J, h = self.inertia, self.period
        q: Array = np.asarray(0.5 * h * np.linalg.solve(J, momenta.T).T, dtype=np.float64)
        with np.errstate(all="ignore"):
            for _ in range(_SOLVES):
                q0 = np.sqrt(1.0 - np.sum(q * q, axis=1))[:, None]
                Jq = q @ J
                off = 2.0 * q0 * Jq + 2.0 * np.cross(q, Jq) - h * momenta
                slope = 2.0 * (q0[:, :, None] * J + hats(q) @ J - hats(Jq))
                slope -= 2.0 * Jq[:, :, None] * (q / q0)[:, None, :]
                sound = np.isfinite(slope).all(axis=(1, 2)) & np.isfinite(off).all(axis=1)
                slope[~sound], off[~sound] = np.eye(3), np.nan
                q = np.asarray(q - np.linalg.solve(slope, off[:, :, None])[:, :, 0])
            q0 = np.sqrt(1.0 - np.sum(q * q, axis=1))[:, None, None]
        Q = hats(q)
        return np.asarray(np.eye(3) + 2.0 * q0 * Q + 2.0 * Q @ Q)

    def kept(self, momenta: Array, torques: Array) -> Array:
        """Return the torques (m, 3) nearest to some that keep the bounds, those on torque first.

        A step that does not exist changes no momentum.
        """
        low, high, least, most = self.limits
        free, h = times(transposed(self.turns(momenta)), momenta), self.period
        free = np.where(np.isfinite(free), free, momenta)
        inside = np.clip(torques, (least - free) / h, (most - free) / h)
        return np.clip(inside, low, high)

    def ahead(self, attitude: Array, momentum: Array, torques: Array) -> tuple[Array, Array]:
        """Return attitude (3, 3) and momentum (3,) after torques (m, 3), kept within the bounds."""
        R, Pi = attitude, momentum[None]
        for torque in torques:
            kept, F = self.kept(Pi, torque[None]), self.turns(Pi)
            R, Pi = R @ F[0], times(transposed(F), Pi) + self.period * kept
        return R, Pi[0]
