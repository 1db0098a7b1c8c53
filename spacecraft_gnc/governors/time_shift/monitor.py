"""Monitor of the craft: which no longer answer, by their state against the predicted one.

The delta-v that a craft gave in a sample follows from its states at both ends, dv = (A B)^+ (x+ -
A x). Its response is the part of the asked-for delta-v that it gave, over the last samples:
sum(given . asked) / sum(asked . asked). A craft is lost once that is below half while the
asked-for delta-v together exceeds a threshold; it then stays so.
"""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np

from spacecraft_gnc.arguments import as_count, require_positive
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
        Delta-v of the window from which on a response can be told [m/s]; several times what errors
        of the measured states make of it.
    window : int
        Samples over which a response is taken.
    """

    def __init__(
        self, problem: TimeShiftProblem, threshold: float = 0.005, window: int = 3
    ) -> None:
        self._problem = problem
        self._threshold = require_positive("threshold", threshold)
        self._window = as_count("window", window)
        self._given = np.linalg.pinv(problem.state_map[:, 3:])
        self.reset()

    def reset(self) -> None:
        """Forget everything; all craft answer."""
        self.lost: Mask = np.zeros(self._problem.n_craft, dtype=np.bool_)
        self._seen: deque[tuple[Array, Array]] = deque(maxlen=self._window)

    def observe(self, before: Array, asked: Array, after: Array) -> Array:
        """Note the states (n, 6) at both ends of a sample and the delta-v (n, 3) asked for.

        Returns
        -------
        (n,) array
            Response of each craft; NaN where too little was asked to tell.
        """
        given = (after - before @ self._problem.state_map.T) @ self._given.T
        asked_for = np.einsum("ij,ij->i", asked, asked)
        self._seen.append((np.einsum("ij,ij->i", given, asked), asked_for))
        answered, total = np.sum(self._seen, axis=0)
        tells = total >= self._threshold**2
        response = np.full(len(total), np.nan)
        response[tells] = answered[tells] / total[tells]
        self.lost |= tells & (response < _HALF)
        return response
