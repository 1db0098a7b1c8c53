"""Constraints of the closed loop along the whole response to a constant reference.

No set is needed: a pair of state and reference is admissible if the simulated response keeps every
constraint at every step until nothing of the start is left, and in steady state with its margin.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.audit.law import Loop
from spacecraft_gnc.vehicles.docking.scenario import Scenario

STEADY: Final = -1
_LEFT: Final = 1e-6  # of a start, at which the response counts as steady
_MOST: Final = 20_000
NAMES: Final = (
    *(f"{part} {sign}{axis}" for sign in "+-" for part in ("force", "moment") for axis in "xyz"),
    *(f"line of sight {sign}{axis}" for axis in "yz" for sign in "+-"),
    *(f"vertex {i} off the docking face" for i in range(1, 9)),
)
"""Constraints as the governor names them; vertices with x counting slowest, from the negative."""
_CORNERS: Final = np.array(list(product((-0.5, 0.5), repeat=3)))


class Rows(NamedTuple):
    """Rows state x + reference v <= bound of one step."""

    state: Array
    """(r, 12)"""
    reference: Array
    """(r, 6)"""
    bound: Array
    """(r,): the room of each where the port is docked."""
    constraint: NDArray[np.int64]
    """(r,) index of `NAMES`."""
    ahead: NDArray[np.int64]
    """(r,) steps ahead; -1 in steady state."""

    def slacks(self, x: Array, v: Array) -> Array:
        """Return the slacks (r,) as shares of the rooms where the port is docked."""
        return np.asarray((self.bound - self.state @ x - self.reference @ v) / self.bound)


@dataclass(slots=True, eq=False)
class Responses:
    """Rows of every step of a period, made where they are asked for.

    Parameters
    ----------
    scenario
        Whose limits, margins and share of steady states count.
    loop
        What the governor believes.
    """

    scenario: Scenario
    loop: Loop
    _of: dict[int, Rows]
    _steady: Rows
    _now: tuple[Array, Array, Array]
    horizon: int
    """Steps after which nothing of a start is left."""

    def __init__(self, scenario: Scenario, loop: Loop) -> None:
        self.scenario, self.loop, self._of = scenario, loop, {}
        self._now = _constraints(scenario, loop)
        self.horizon = _decay(loop.closed[0])
        self._steady = self._in_steady_state()

    def at(self, step: int) -> Rows:
        """Return the rows of a step: those ahead, then those in steady state."""
        k = step % self.loop.period
        if k not in self._of:
            self._of[k] = self._rows(k)
        return self._of[k]

    def _rows(self, k: int) -> Rows:
        (C, D, b), p = self._now, self.loop.period
        A, B = self.loop.closed
        response = np.empty((self.horizon + 1, 12, 18))
        response[0] = np.eye(12, 18)
        for j in range(self.horizon):
            i = (k + j) % p
            response[j + 1] = A[i] @ response[j]
            response[j + 1, :, 12:] += B[i]
        phases = (k + np.arange(self.horizon + 1)) % p
        rows = C[phases] @ response
        rows[:, :, 12:] += D[phases]
        m, s = C.shape[1], self._steady
        flat = rows.reshape(-1, 18)
        return Rows(
            np.concatenate([flat[:, :12], s.state]),
            np.concatenate([flat[:, 12:], s.reference]),
            np.concatenate([b[phases].ravel(), s.bound]),
            np.concatenate([np.tile(np.arange(m), len(phases)), s.constraint]),
            np.concatenate([np.repeat(np.arange(len(phases)), m), s.ahead]),
        )

    def _in_steady_state(self) -> Rows:
        """Return the rows of the steady states of all phases, which keep a part of each bound."""
        (C, D, b), (A, B) = self._now, self.loop.closed
        p, m = self.loop.period, C.shape[1]
        around, pushed = np.eye(12), np.zeros((12, 6))
        for a, c in zip(A, B, strict=True):
            around, pushed = a @ around, a @ pushed + c
        state = np.linalg.solve(np.eye(12) - around, pushed)
        rows = np.empty((p, m, 6))
        for k in range(p):
            rows[k] = C[k] @ state + D[k]
            state = A[k] @ state + B[k]
        share = self.scenario.governor.steady_share
        return Rows(
            np.zeros((p * m, 12)),
            rows.reshape(-1, 6),
            (b - (1.0 - share) * np.abs(b)).ravel(),
            np.tile(np.arange(m), p),
            np.full(p * m, STEADY),
        )


def _constraints(scenario: Scenario, loop: Loop) -> tuple[Array, Array, Array]:
    """Return C (p, m, 12), D (p, m, 6), c (p, m) of C x + D v <= c at the start of each step."""
    plant, g, p = scenario.plant, scenario.governor, loop.period
    limits = np.repeat([plant.max_force - g.force_margin, plant.max_moment - g.moment_margin], 3)
    slope = np.tan(np.radians(plant.line_of_sight_half_angle_deg))
    arms = _CORNERS * plant.deputy_size - plant.deputy_port
    states = np.zeros((12, 12))
    for i, (axis, sign) in enumerate(product((1, 2), (1.0, -1.0))):
        states[i, 0], states[i, axis] = -slope, sign
    # x of a vertex from the chief's port is rho_x + (arm + delta x arm)_x, to first order.
    states[4:, 0], states[4:, 7], states[4:, 8] = -1.0, -arms[:, 2], arms[:, 1]
    sight = np.full(4, plant.line_of_sight_slack - g.distance_margin)
    # The port lies on the docking face.
    face = arms[:, 0] + plant.clearance_tolerance - g.distance_margin
    fixed = np.concatenate([sight, face])
    C = np.concatenate([-loop.K, loop.K, np.tile(states, (p, 1, 1))], axis=1)
    D = np.concatenate([loop.through, -loop.through, np.zeros((p, 12, 6))], axis=1)
    return C, D, np.hstack([limits - loop.U0, limits + loop.U0, np.tile(fixed, (p, 1))])


def _decay(closed: Array) -> int:
    """Return the steps after which nothing of any start is left, at least a period."""
    left: Any = np.eye(12)
    for count in range(_MOST):
        if count >= len(closed) and np.abs(left).max() < _LEFT:
            return count
        left = closed[count % len(closed)] @ left
    return _MOST
