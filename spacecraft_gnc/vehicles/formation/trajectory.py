"""Natural trajectory on which the craft form up, and what they are to track on it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array, read_only
from spacecraft_gnc.vehicles.formation.state import FormationReference


class NaturalTrajectory:
    """Closed unforced trajectory, sampled at the control steps of one orbit.

    Parameters
    ----------
    states : (p, 6) array
        Position [m] and velocity [m/s], Hill's frame: row k + 1 follows from row k without a
        change of velocity, row 0 from the last one.
    phases : sequence of int
        Desired place of each craft, theta_i [control steps].
    """

    def __init__(self, states: Array, phases: Sequence[int]) -> None:
        self.states = read_only(np.asarray(states, dtype=np.float64))
        self.phases = np.array(phases, dtype=np.int64)
        self.phases.setflags(write=False)

    @property
    def period(self) -> int:
        """Control steps p of an orbit."""
        return len(self.states)

    def reference(self, step: int, shift: NDArray[np.int64]) -> FormationReference:
        """Return what the craft are to track at a step under shifts tau (n,): Kolmanovsky (17)."""
        chosen = np.array(shift, dtype=np.int64)
        states = self.states[(step + self.phases + chosen) % self.period]
        for array in (chosen, states):
            array.setflags(write=False)
        return FormationReference(chosen, states[:, :3], states[:, 3:])
