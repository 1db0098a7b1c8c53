"""Comparison of recorded commands with those of another controller."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array


class Resolved(NamedTuple):
    """Recorded commands beside those of another controller; row i is step ``steps[i]``."""

    steps: NDArray[np.int64]
    """(k,) steps compared; those without a recorded state, reference or command are not."""
    times: Array
    """(k,) [s]."""
    recorded: Array
    """(k, m) accelerations as they flew [rad/s^2]."""
    replayed: Array
    """(k, m) accelerations of the other controller [rad/s^2]."""
    wall_times: Array
    """(k,) of its answers [s]."""
    recorded_costs: Array
    """(k,) of the plans that flew; NaN where none was found."""
    replayed_costs: Array
    """(k,) of the plans of the other controller; NaN likewise."""

    @property
    def difference(self) -> Array:
        """(k,) largest difference of a wheel's acceleration [rad/s^2]."""
        return np.asarray(np.abs(self.replayed - self.recorded).max(axis=1))

    @property
    def first_difference(self) -> int | None:
        """First step whose commands are not equal bit for bit; None where all are."""
        differ = (self.replayed != self.recorded).any(axis=1)
        return int(self.steps[np.argmax(differ)]) if differ.any() else None

    @property
    def cost_difference(self) -> float | None:
        """Largest difference of costs where both found a plan, over 1 + the cost; None: nowhere."""
        off = np.abs(self.replayed_costs - self.recorded_costs) / (1.0 + self.recorded_costs)
        known = off[np.isfinite(off)]
        return float(known.max()) if known.size else None
