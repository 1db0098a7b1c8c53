"""Plans of forces that lead to the hold point with one thruster direction lost.

The center of mass moves linearly, s_{j+1} = A s_j + B (F_j - F0), whatever the attitude; with the
attitudes of a turn foretold, the lost direction n_j is known, and so is how far the vertices reach
toward the chief. Over N steps with forces constant in blocks,

    min sum (s_j - hold)' Q (s_j - hold) + (F_j - F_hold)' R (F_j - F_hold) + misses
    |F_j| <= limit by component, n_j . F_j <= 0, vertices off the docking face, port in sight,

where the last two may be missed, at a price: of the face a high one, of the sight a lower one. An
attitude in which the force that holds the hold point is not to be had costs more as well.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import daqp
import numpy as np
from scipy.linalg import solve_discrete_are

from spacecraft_gnc.types import Array, Vector3
from spacecraft_gnc.vehicles.docking.geometry import Cuboid
from spacecraft_gnc.vehicles.docking.governors.rows import Bounds
from spacecraft_gnc.vehicles.docking.linear import LinearMotion

_BLOCKS: Final = (1, 1, 1, 1, 1, 2, 2, 2, 2, 3, 4, 4, 4, 4, 8)
STEPS: Final = sum(_BLOCKS)
_FORCES: Final = 3 * len(_BLOCKS)
_UNKNOWNS: Final = _FORCES + 2
_BLOCK_OF: Final = np.repeat(np.arange(len(_BLOCKS)), _BLOCKS)
_Q: Final = np.diag(np.repeat([0.01, 0.3], 3))
_R: Final = 0.3 * np.eye(3)
_DEPTH_PRICE: Final = 1e4
_SIGHT_PRICE: Final = 300.0
_DEPTH_MARGIN: Final = 0.05  # [m]
_HOLD_PRICE: Final = 100.0  # [1/N] of an attitude in which the hold point cannot be held
_HOLD_MARGIN: Final = 0.01  # [N] by which the force that holds it is off the lost direction
_MOST_ITERATIONS: Final = 2000
_FREE: Final = 1e30  # no bound, for the solver
_TURNING: Final = 1e-3  # of a direction in a step, from which on both its ends count
_SOLVED: Final = 1


class Plan(NamedTuple):
    """Force of the next step, and what the plan costs."""

    force: Vector3
    """(3,) chief frame [N]."""
    cost: float
    depth_miss: float
    """[m] beyond the margin off the docking face."""
    sight_miss: float
    """[m] outside the line of sight."""
    iterations: int


class Retreat:
    """Plans from any state.

    Parameters
    ----------
    model : LinearMotion
        As believed.
    deputy : Cuboid
    bounds : Bounds
    """

    def __init__(self, model: LinearMotion, deputy: Cuboid, bounds: Bounds) -> None:
        self.model, self.deputy, self.bounds = model, deputy, bounds
        mean = model.averaged()
        a, b = mean.transition[0, :6, :6], mean.control[0, :6, :3]
        self.last_weight = solve_discrete_are(a, b, _Q, _R)

    def at(self, step: int, center: Array) -> Plans:
        """Return the plans from offset and velocity (6,) of the center of mass at a step."""
        return Plans(self, step, center)


class Plans:
    """Plans from one state; `Retreat.at` returns them."""

    def __init__(self, retreat: Retreat, step: int, center: Array) -> None:
        self._of = retreat
        model = retreat.model
        free, forced = np.empty((STEPS + 1, 6)), np.zeros((STEPS + 1, 6, _UNKNOWNS))
        free[0] = center
        phases = (step + np.arange(STEPS)) % model.period
        for j, k in enumerate(phases):
            a, b = model.transition[k, :6, :6], model.control[k, :6, :3]
            free[j + 1] = a @ free[j] - b @ model.feedforward[k, :3]
            forced[j + 1] = a @ forced[j]
            forced[j + 1, :, 3 * _BLOCK_OF[j] : 3 * _BLOCK_OF[j] + 3] += b
        self._free, self._forced = free[1:], forced[1:]
        self._phase = int(phases[0])
        weights = np.tile(_Q, (STEPS, 1, 1))
        weights[-1] = retreat.last_weight
        self._weights = weights
        self._weighted = weights @ self._forced
        hessian = np.einsum("jam,jan->mn", self._forced, self._weighted)
        lengths = np.repeat(_BLOCKS, 3)
        hessian[range(_FORCES), range(_FORCES)] += _R[0, 0] * lengths
        hessian[-2, -2], hessian[-1, -1] = _DEPTH_PRICE, _SIGHT_PRICE
        self._hessian = hessian + 1e-8 * np.eye(_UNKNOWNS)

    def best(self, attitudes: Array, lost: Vector3, hold: Vector3) -> Plan | None:
        """Return the best plan along attitudes (N + 1, 3, 3), None: there is none.

        ``lost`` is the direction that is lost, deputy frame; ``hold`` the port offset wished for.
        """
        port = self._of.deputy.port
        swung = attitudes @ port - port  # of the port from the center of mass
        goal = np.concatenate([hold - swung[-1], np.zeros(3)])
        held = self._holding(goal)
        slope, constant = self._slope(goal, held)
        constant += _HOLD_PRICE * max(0.0, float(attitudes[-1] @ lost @ held) + _HOLD_MARGIN)
        rows, upper = zip(
            self._lost_rows(attitudes @ lost),
            self._depth_rows(attitudes[1:]),
            self._sight_rows(swung[1:]),
            strict=True,
        )
        general = np.ascontiguousarray(np.concatenate(rows))
        most = self._of.bounds.force
        ends = np.full(_UNKNOWNS, most), np.full(_UNKNOWNS, -most)
        ends[0][-2:], ends[1][-2:] = _FREE, 0.0
        z, value, flag, info = daqp.solve(
            self._hessian, slope, general, np.concatenate([ends[0], *upper]),
            np.concatenate([ends[1], np.full(len(general), -_FREE)]),
            np.zeros(_UNKNOWNS + len(general), dtype=np.intc), iter_limit=_MOST_ITERATIONS,
        )  # fmt: skip
        if flag < _SOLVED:
            return None
        return Plan(z[:3], float(value) + constant, float(z[-2]), float(z[-1]), info["iterations"])

    def _holding(self, goal: Array) -> Vector3:
        """Return the force (3,) that holds the center of mass at a goal."""
        model, k = self._of.model, self._phase
        added = model.reference_feedforward[k, :3, :3] @ goal[:3]
        return np.asarray(model.feedforward[k, :3] + added)

    def _slope(self, goal: Array, held: Vector3) -> tuple[Array, float]:
        """Return linear and constant part of the cost."""
        short = self._free - goal
        slope = np.einsum("jam,ja->m", self._weighted, short)
        slope[:_FORCES] -= np.repeat(_BLOCKS, 3) * np.tile(_R @ held, len(_BLOCKS))
        slope[-2:] += _DEPTH_PRICE, _SIGHT_PRICE
        return slope, 0.5 * float(np.einsum("ja,jab,jb->", short, self._weights, short))

    def _lost_rows(self, lost: Array) -> tuple[Array, Array]:
        """Return the rows n_j . F_j <= 0, at both ends of a step in which n turns."""
        turning = np.abs(np.diff(lost, axis=0)).max(axis=1) > _TURNING
        steps = np.concatenate([np.arange(STEPS), np.flatnonzero(turning)])
        directions = np.concatenate([lost[:-1], lost[1:][turning]])
        rows = np.zeros((len(steps), _UNKNOWNS))
        for axis in range(3):
            rows[np.arange(len(steps)), 3 * _BLOCK_OF[steps] + axis] = directions[:, axis]
        return rows, np.zeros(len(rows))

    def _depth_rows(self, attitudes: Array) -> tuple[Array, Array]:
        """Return the rows of the deputy's vertices off the docking face."""
        deputy = self._of.deputy
        reach = np.abs(attitudes[:, 0]) @ (0.5 * deputy.size) + deputy.port[0]
        rows = -self._forced[:, 0]
        rows[:, -2] = -1.0
        return rows, self._free[:, 0] - reach - _DEPTH_MARGIN

    def _sight_rows(self, swung: Array) -> tuple[Array, Array]:
        """Return the rows of the port in the line-of-sight pyramid."""
        bounds, port = self._of.bounds, self._free[:, :3] + swung
        rows, upper = [], []
        for axis in (1, 2):
            for sign in (1.0, -1.0):
                row = sign * self._forced[:, axis] - bounds.slope * self._forced[:, 0]
                row[:, -1] = -1.0
                rows.append(row)
                upper.append(bounds.slack + bounds.slope * port[:, 0] - sign * port[:, axis])
        return np.concatenate(rows), np.concatenate(upper)
