"""Monitor of the craft: which no longer answer, by their state against the predicted one.

The delta-v that a craft gave in a sample follows from its states at both ends, dv = (A B)^+ (x+ -
A x). Its response is the part of the asked-for delta-v that it gave, (given . asked) / |asked|^2. A
craft whose response to a delta-v above a threshold is below one half is lost, and stays so.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from spacecraft_gnc.arguments import require_positive
from spacecraft_gnc.governors.time_shift.prediction import Mask
from spacecraft_gnc.governors.time_shift.problem import TimeShiftProblem
from spacecraft_gnc.types import Array

_HALF: Final = 0.5


class CraftMonitor:
    """Notice craft that no longer answer.

    Parameters
    ----------
    problem : TimeShiftProblem
    threshold : float
        Delta-v from which on a response can be told [m/s]. Half of it has to stand out from what
        errors of the states make of a measured delta-v: 13 of its standard deviations give a false
        alarm once in some 10^10 samples.
    """

    def __init__(self, problem: TimeShiftProblem, threshold: float = 0.005) -> None:
        self._problem = problem
        self.threshold = require_positive("threshold", threshold)
        self._given = np.linalg.pinv(problem.state_map[:, 3:])
        self.reset()

    def reset(self) -> None:
        """Forget everything; all craft answer."""
        self.lost: Mask = np.zeros(self._problem.n_craft, dtype=np.bool_)

    def memory(self) -> tuple[Any, ...]:
        """Return which craft are lost."""
        return (self.lost,)

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the monitor did whose `memory` it is."""
        (self.lost,) = memory

    def observe(self, before: Array, asked: Array, after: Array) -> Array:
        """Note the states (n, 6) at both ends of a sample and the delta-v (n, 3) asked for.

        Returns
        -------
        (n,) array
            Response of each craft; NaN where too little was asked to tell.
        """
        given = (after - before @ self._problem.state_map.T) @ self._given.T
        answered, total = np.einsum("ij,ij->i", given, asked), np.einsum("ij,ij->i", asked, asked)
        tells = total >= self.threshold**2
        response = np.full(len(total), np.nan)
        response[tells] = answered[tells] / total[tells]
        self.lost = self.lost | (tells & (response < _HALF))
        return response
