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

    def foretold(self, attitude: Matrix3, rate: Vector3, goals: Array) -> Array:
        """Return attitudes (c, N + 1, 3, 3) of the next steps, for goals (c, 3, 3).

        As of turns about one axis each.
        """
        h, w = self._period, np.tile(rate, (len(goals), 1))
        left = np.empty((self._steps + 1, len(goals), 3))
        left[0] = [lie.log(goal @ attitude.T) for goal in goals]
        for k in range(self._steps):
            change = self._acceleration(left[k], w)
            left[k + 1] = left[k] - h * w - 0.5 * h * h * change
            w = w + h * change
        return _exponentials(-left.transpose(1, 0, 2)) @ goals[:, None]

    def _acceleration(self, left: Array, rate: Array) -> Array:
        return np.clip(self._stiffness * left - self._damping * rate, -self._most, self._most)


def _exponentials(rotation_vectors: Array) -> Array:
    """Return `lie.exp` of vectors (..., 3)."""
    x, y, z = np.moveaxis(rotation_vectors, -1, 0)
    zero = np.zeros_like(x)
    hat = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    half = 0.5 * np.linalg.norm(rotation_vectors, axis=-1)[..., None, None]
    sinc = np.sinc(half / np.pi)
    return np.asarray(np.eye(3) + sinc * (np.cos(half) * hat + 0.5 * sinc * hat @ hat))
