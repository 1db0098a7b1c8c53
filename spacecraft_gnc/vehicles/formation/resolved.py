"""Comparison of recorded changes of velocity with those of another controller."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array


class Resolved(NamedTuple):
    """Recorded delta-v beside that of another controller; row i is step ``steps[i]``."""

    steps: NDArray[np.int64]
    """(k,) steps compared; those without a recorded state, reference or command are not."""
    times: Array
    """(k,) [s]."""
    recorded: Array
    """(k, n, 3) delta-v of the craft as they flew [m/s]."""
    replayed: Array
    """(k, n, 3) those of the other controller."""
    wall_times: Array
    """(k,) of its answers for all craft [s]."""

    @property
    def differences(self) -> Array:
        """Lengths (k, n) of the differences [m/s]."""
        return np.asarray(np.linalg.norm(self.replayed - self.recorded, axis=-1))

    @property
    def largest_difference(self) -> float:
        """Largest of them [m/s]."""
        return float(self.differences.max())

    @property
    def first_difference(self) -> int | None:
        """First step whose commands are not equal bit for bit; None where all are."""
        differ = (self.replayed != self.recorded).any(axis=(1, 2))
        return int(self.steps[np.argmax(differ)]) if differ.any() else None
