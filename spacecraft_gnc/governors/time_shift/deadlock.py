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

from typing import Any

import numpy as np

from spacecraft_gnc.governors.time_shift import choice
from spacecraft_gnc.governors.time_shift.choice import Choice
from spacecraft_gnc.governors.time_shift.passages import (
    NO_PASSAGE,
    Passages,
    passages,
    warm_up_around,
)
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
        self.reset()

    def reset(self) -> None:
        """Forget any deadlock."""
        self._parked_for = 0
        self._lost: Mask | None = None
        self._passages: Passages | None = None
        self.is_deadlocked = False
        """From when it is noticed; with a passage, until the desired formation is reached."""

    def memory(self) -> tuple[Any, ...] | None:
        """Return what was noticed; None on a passage around craft that drift as they did then."""
        way = self._passages
        if way is not None and way.is_whole:
            return None
        return self._parked_for, self._lost, way is not None, self.is_deadlocked

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the watch did whose `memory` it is; its passages are searched again."""
        self._parked_for, self._lost, has_way, self.is_deadlocked = memory
        self._passages = passages(self._predictor, self._lost) if has_way else None

    def warm_up(self) -> None:
        """Search the passages of the whole formation."""
        if self._resolves:
            passages(self._predictor, np.zeros(self._predictor.problem.n_craft, dtype=np.bool_))
            warm_up_around()

    def way_out(self, prediction: Prediction, shifts: Integers) -> Choice | None:
        """Return the next combination on the passage from the last ``shifts`` (n,).

        Those themselves while none is nearer; None without a deadlock or a passage, after a new
        loss, and where they are not admissible any more.
        """
        if not self.is_deadlocked or self._has_changed(prediction.lost):
            return None
        left, way = self.left(shifts), self._passages
        if left == NO_PASSAGE or way is None:
            return None
        return choice.nearest(
            self._predictor, prediction, way.distances, max(left - 1, 0), shifts,
            is_whole=way.is_whole,
        )  # fmt: skip

    def notice(
        self,
        prediction: Prediction,
        shifts: Integers,
        *,
        held: bool,
        arrived: bool,
        is_equal: bool,
    ) -> None:
        """Note the shifts (n,) of a step: held from the last one, craft arrived, all equal."""
        if self._has_changed(prediction.lost):
            self.reset()
            self._lost = prediction.lost
        if self.is_deadlocked and self.left(shifts) != NO_PASSAGE:
            self.is_deadlocked = not (is_equal and arrived)
            return
        self._parked_for = self._parked_for + 1 if held and arrived and not is_equal else 0
        is_new = not self.is_deadlocked
        self.is_deadlocked = self._parked_for >= self._patience
        if self.is_deadlocked and is_new and self._resolves:
            self._passages = self._ways(prediction, shifts)

    def left(self, shifts: Integers) -> int:
        """Return the transitions still needed from shifts (n,), `NO_PASSAGE` if there is none."""
        return NO_PASSAGE if self._passages is None else self._passages.distance(shifts)

    def _ways(self, prediction: Prediction, shifts: Integers) -> Passages:
        """Return the passages around lost craft as they drift now, if there is one from here."""
        if prediction.lost.any():
            around = Passages(self._predictor, prediction.lost, prediction)
            if around.distance(shifts) != NO_PASSAGE:
                return around
        return passages(self._predictor, prediction.lost)

    def _has_changed(self, lost: Mask) -> bool:
        return self._lost is None or not np.array_equal(lost, self._lost)
