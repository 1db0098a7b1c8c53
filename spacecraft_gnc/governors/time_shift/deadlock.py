"""Deadlocks: formations parked for good in another order, noticed and left by a passage.

The angle constraint keeps craft from passing one another, so that some starts end in a permuted
formation: the errors vanish, W does not, and every cheaper combination breaks a constraint. (With a
small weight of W there may be none that is cheaper.) The craft are deadlocked once such a formation
is reached within a tolerance and its shifts have not changed for a number of steps.

The way out: of the admissible combinations, go on to the one with the fewest transitions left
(`Passages`), whenever there is one with fewer; once none is left, keep all shifts equal until the
formation is reached. The transitions left only ever decrease, so that this ends.
"""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.governors.time_shift import choice
from spacecraft_gnc.governors.time_shift.choice import Choice
from spacecraft_gnc.governors.time_shift.passages import NO_PASSAGE, Passages, passages
from spacecraft_gnc.governors.time_shift.prediction import Mask, Prediction, Predictor
from spacecraft_gnc.governors.time_shift.problem import Integers


class DeadlockWatch:
    """Notice a deadlock, and lead out of it.

    Parameters
    ----------
    predictor : Predictor
    patience : int
        Steps after which unchanged shifts of a reached, undesired formation are a deadlock.
    resolves : bool
        Whether to lead out of it; else it is only noticed.
    """

    def __init__(self, predictor: Predictor, patience: int, *, resolves: bool) -> None:
        self._predictor, self._patience, self._resolves = predictor, patience, resolves
        self._passages: dict[bytes, Passages] = {}
        self.reset()

    def reset(self) -> None:
        """Forget any deadlock."""
        self._parked_for = 0
        self._lost: Mask | None = None
        self.is_deadlocked = False
        """From when it is noticed; with a passage, until the desired formation is reached."""

    def warm_up(self) -> None:
        """Search the passages of the whole formation."""
        if self._resolves:
            self._of(np.zeros(self._predictor.problem.n_craft, dtype=np.bool_))

    def way_out(self, prediction: Prediction, shifts: Integers) -> Choice | None:
        """Return the next combination on the passage from the last ``shifts`` (n,).

        Those themselves while none is nearer; None without a deadlock or a passage, after a new
        loss, and where they are not admissible any more.
        """
        if not self.is_deadlocked or self._has_changed(prediction.lost):
            return None
        left = self.left(shifts)
        if left == NO_PASSAGE:
            return None
        distances = self._of(prediction.lost).distances
        return choice.nearest(self._predictor, prediction, distances, max(left - 1, 0), shifts)

    def notice(
        self, lost: Mask, shifts: Integers, *, held: bool, arrived: bool, is_equal: bool
    ) -> None:
        """Note the shifts (n,) of a step: held from the last one, craft arrived, all equal."""
        if self._has_changed(lost):
            self.reset()
            self._lost = lost
        if self.is_deadlocked and self.left(shifts) != NO_PASSAGE:
            self.is_deadlocked = not (is_equal and arrived)
            return
        self._parked_for = self._parked_for + 1 if held and arrived and not is_equal else 0
        self.is_deadlocked = self._parked_for >= self._patience

    def left(self, shifts: Integers) -> int:
        """Return the transitions still needed from shifts (n,), `NO_PASSAGE` if there is none."""
        if self._lost is None or not self._resolves:
            return NO_PASSAGE
        return self._of(self._lost).distance(shifts)

    def _has_changed(self, lost: Mask) -> bool:
        return self._lost is None or not np.array_equal(lost, self._lost)

    def _of(self, lost: Mask) -> Passages:
        key = lost.tobytes()
        if key not in self._passages:
            self._passages[key] = passages(self._predictor, lost)
        return self._passages[key]
