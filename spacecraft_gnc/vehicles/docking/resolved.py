"""Comparison of recorded wrenches with those of another controller."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array


class Resolved(NamedTuple):
    """Recorded wrenches beside those of another controller; row i is step ``steps[i]``."""

    steps: NDArray[np.int64]
    """(k,) steps compared; those without a recorded state, reference or command are not."""
    times: Array
    """(k,) [s]."""
    recorded: Array
    """(k, 6) force [N] and moment [N m] as they flew."""
    replayed: Array
    """(k, 6) those of the other controller."""
    wall_times: Array
    """(k,) of its answers [s]."""

    @property
    def largest_differences(self) -> tuple[float, float]:
        """Largest differences of a component of the force [N] and of the moment [N m]."""
        off = np.abs(self.replayed - self.recorded)
        return float(off[:, :3].max()), float(off[:, 3:].max())

    @property
    def first_difference(self) -> int | None:
        """First step whose commands are not equal bit for bit; None where all are."""
        differ = (self.replayed != self.recorded).any(axis=1)
        return int(self.steps[np.argmax(differ)]) if differ.any() else None
