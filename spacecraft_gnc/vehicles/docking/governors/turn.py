"""Turn of the deputy to an attitude: the law that asks for the moment, and what it will do."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array, Matrix3, Vector3

_BANDWIDTH: Final = 0.4  # of the turn, times the control period
_DAMPING: Final = 0.9
_SHARE: Final = 0.95  # of the moment, for what the law leaves out


class Turn:
    """Saturated proportional and derivative law about the axis of the turn.

    Parameters
    ----------
    inertia : (3, 3) array
        As believed, deputy frame [kg m^2].
    port : (3,) array
        Docking port of the deputy, deputy frame [m].
    max_moment : float
        Largest component [N m].
    period : float
        Control period [s].
    steps : int
        Control steps foretold.
    """

    def __init__(
        self, inertia: Matrix3, port: Vector3, max_moment: float, period: float, steps: int
    ) -> None:
        self.port = port
        self._inertia, self._limit = inertia, max_moment
        self._period, self._steps = period, steps
        frequency = _BANDWIDTH / period
        self._stiffness, self._damping = frequency**2, 2.0 * _DAMPING * frequency
        self._most = _SHARE * max_moment / float(np.linalg.eigvalsh(inertia)[-1])

    def moment(self, attitude: Matrix3, rate: Vector3, goal: Matrix3) -> Vector3:
        """Return the moment (3,) toward a goal, chief frame [N m].

        What turns the chief, and what couples the axes, is left out: it is less than 1 % of the
        limit.
        """
        inertia = attitude @ self._inertia @ attitude.T
        wanted = inertia @ self._acceleration(lie.log(goal @ attitude.T), rate)
        return np.clip(wanted, -self._limit, self._limit)

    def foretold(self, attitude: Matrix3, rate: Vector3, goal: Matrix3) -> Array:
        """Return attitudes (N + 1, 3, 3) of the next steps, as of a turn about one axis."""
        found = np.empty((self._steps + 1, 3, 3))
        found[0] = attitude
        left, w, h = lie.log(goal @ attitude.T), rate, self._period
        for k in range(self._steps):
            change = self._acceleration(left, w)
            left = left - h * w - 0.5 * h * h * change
            w = w + h * change
            found[k + 1] = lie.exp(-left) @ goal
        return found

    def _acceleration(self, left: Vector3, rate: Vector3) -> Vector3:
        return np.clip(self._stiffness * left - self._damping * rate, -self._most, self._most)
