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

    @property
    def difference(self) -> Array:
        """(k,) largest difference of a wheel's acceleration [rad/s^2]."""
        return np.asarray(np.abs(self.replayed - self.recorded).max(axis=1))

    @property
    def first_difference(self) -> int | None:
        """First step whose commands are not equal bit for bit; None where all are."""
        differ = (self.replayed != self.recorded).any(axis=1)
        return int(self.steps[np.argmax(differ)]) if differ.any() else None
