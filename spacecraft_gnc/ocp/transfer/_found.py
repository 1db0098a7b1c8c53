"""What the starts of a transfer led to, and the best of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array

_TIE: Final = 1e-9  # relative, of the cost


class Found(NamedTuple):
    """What one start led to."""

    status: Status
    plan: tuple[Array, Array, Array, Array]
    multipliers: tuple[Array, Array]
    sets: tuple[NDArray[np.int64], NDArray[np.int64]]
    iterations: int
    error: float
    """Largest residual relative to the units."""
    work: float
    """Passes along the stages, times their number."""

    @property
    def cost(self) -> float:
        """Sum of |u|^2 / 2."""
        return 0.5 * float(np.sum(self.plan[0] ** 2))

    @property
    def rank(self) -> tuple[int, float]:
        """Order of preference, the best first."""
        if self.status == Status.CONVERGED:
            return 0, self.cost
        return (1, self.cost) if self.status == Status.SADDLE else (2, self.error)


def best_of(tried: Sequence[Found]) -> Found:
    """Return the best, the first one of those that are as good to rounding, as mirror images are.

    Which one is flown then depends on the order of the starts, not on units or on the machine.
    """
    best = min(tried, key=lambda one: one.rank)
    kind, least = best.rank
    most = least + _TIE * abs(least)
    return next((one for one in tried if one.rank[0] == kind and one.rank[1] <= most), best)
