"""State of several spacecraft relative to a circular orbit, and the states they are to track."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array


class FormationState(NamedTuple):
    """State at the start of control step ``step``, before its impulses; the arrays are read-only.

    Row i belongs to craft i. Hill's frame: x radial and outward, y along the track, z along the
    orbit normal.
    """

    step: int
    position: Array
    """(n, 3) [m]."""
    velocity: Array
    """(n, 3) [m/s]."""
    healthy: NDArray[np.bool_]
    """(n,) whether each craft can change its velocity in this step: the truth, which no law
    reads."""
    applied: Array
    """(n, 3) delta-v asked for at the start of the step that ended here [m/s]; zero at step 0."""

    @property
    def vectors(self) -> Array:
        """(n, 6) positions beside velocities."""
        return np.hstack([self.position, self.velocity])


class FormationReference(NamedTuple):
    """States that the craft are to track at one control step, and the shifts they follow from."""

    shift: NDArray[np.int64]
    """(n,) time shift of each craft along the natural trajectory [control steps]."""
    position: Array
    """(n, 3) [m]."""
    velocity: Array
    """(n, 3) [m/s]."""

    @property
    def vectors(self) -> Array:
        """(n, 6) positions beside velocities."""
        return np.hstack([self.position, self.velocity])
