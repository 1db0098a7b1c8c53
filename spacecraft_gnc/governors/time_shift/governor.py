"""Time shift governor: the cheapest shifts of the commanded states that keep every constraint.

Each step enumerates all p^n combinations of shifts, constant over the horizon. Shifts that are
admissible stay so on the modeled loop (up to what lies beyond the horizon), so that there is
always a combination to choose once there was one. docs/time_shift_governor.md has theory and
figures.
Source: report of AFRL (Kolmanovsky 2016), section 3.3, (14)-(20).
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from spacecraft_gnc.arguments import as_count, require_kind, require_positive
from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.time_shift import choice
from spacecraft_gnc.governors.time_shift.choice import Choice
from spacecraft_gnc.governors.time_shift.deadlock import DeadlockWatch
from spacecraft_gnc.governors.time_shift.decision import NO_RESPONSE, Answer, TimeShiftDecision
from spacecraft_gnc.governors.time_shift.margins import Margin
from spacecraft_gnc.governors.time_shift.monitor import CraftMonitor
from spacecraft_gnc.governors.time_shift.passages import NO_PASSAGE
from spacecraft_gnc.governors.time_shift.prediction import Prediction, Predictor
from spacecraft_gnc.governors.time_shift.problem import Integers, TimeShiftProblem
from spacecraft_gnc.types import Array

_NONE: Final[Integers] = np.empty(0, dtype=np.int64)


class TimeShiftGovernor:
    """Time shift governor of one formation.

    Parameters
    ----------
    problem : TimeShiftProblem
    formed_within : float
        Distance from the commanded positions at which a formation is taken as reached [m].
    patience : int
        Steps after which unchanged shifts of a reached, undesired formation are a deadlock.
    resolves_deadlocks : bool
        Whether a passage leads out of a deadlock; else it is only published.
    monitor : CraftMonitor, optional
        Notices craft that no longer answer; None: one with its defaults.
    """

    def __init__(
        self,
        problem: TimeShiftProblem,
        *,
        formed_within: float = 10.0,
        patience: int = 5,
        resolves_deadlocks: bool = True,
        monitor: CraftMonitor | None = None,
    ) -> None:
        self.problem = require_kind("problem", problem, TimeShiftProblem)
        self.formed_within = require_positive("formed_within", formed_within)
        self._predictor = Predictor(problem)
        self._watch = DeadlockWatch(
            self._predictor, as_count("patience", patience), resolves=resolves_deadlocks
        )
        self._monitor = CraftMonitor(problem) if monitor is None else monitor
        self.reset()

    def reset(self) -> None:
        """Forget the last shifts, all that was observed, and any deadlock."""
        self._monitor.reset()
        self._watch.reset()
        self._shifts: Integers | None = None
        self._last: tuple[int, Array, Array] | None = None

    def memory(self) -> tuple[Any, ...] | None:
        """Return the last shifts and what was observed; None while the watch has none."""
        watch = self._watch.memory()
        return None if watch is None else (self._shifts, self._last, self._monitor.memory(), watch)

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the governor did whose `memory` it is."""
        self._shifts, self._last, monitor, watch = memory
        self._monitor.recall(monitor)
        self._watch.recall(watch)

    def warm_up(self) -> None:
        """Compile, or load, everything that a step calls, and search the passages."""
        self._watch.warm_up()
        n, p = self.problem.n_craft, self.problem.samples
        states = self.problem.commanded(0, np.arange(n))
        nowhere = np.full(p ** (n - 1), NO_PASSAGE)
        for lost in (np.zeros(n, dtype=np.bool_), np.arange(n) == 0):
            prediction = self._predictor.predict(0, states, np.zeros(n, dtype=np.int64), lost)
            choice.cheapest(self._predictor, prediction)
            choice.longest_kept(self._predictor, prediction)
            found = choice.least_violating(self._predictor, prediction)
            choice.nearest(self._predictor, prediction, nowhere, 0, found.shifts, is_whole=False)
            choice.cheaper(self._predictor, prediction, found.shifts, 1.0)
            choice.cost_of(self._predictor, prediction, found.shifts)

    def decide(self, step: int, states: object, applied: object | None = None) -> TimeShiftDecision:
        """Return the shifts of a step.

        Parameters
        ----------
        step : int
            Control step k.
        states : (n, 6) array
            Position [m] and velocity [m/s] of each craft at the start of the step, before its
            impulse.
        applied : (n, 3) array, optional
            Delta-v asked for in the step that ended here [m/s]; None: that of the craft's laws
            under the last decision.

        Raises
        ------
        ShapeError, ParameterError
            If an argument is not of that kind.
        """
        n = self.problem.n_craft
        k = as_count("step", step, 0, most=2**62)
        x = as_finite("states", states, (n, 6), f"{n} rows of 6 finite numbers")
        response = self._observe(k, x, applied)
        last = np.zeros(n, dtype=np.int64) if self._shifts is None else self._shifts
        prediction = self._predictor.predict(k, x, last, self._monitor.lost)
        chosen, answer = self._choose(prediction)
        decision = self._decision(prediction, x, chosen, answer, response)
        self._shifts = decision.shifts
        self._last = (k, x, self.problem.delta_v(k, x, decision.shifts))
        return decision

    def _observe(self, k: int, x: Array, applied: object | None) -> tuple[float, ...]:
        """Compare the states with those that the last delta-v should have led to."""
        n = self.problem.n_craft
        asked = None if applied is None else as_finite("applied", applied, (n, 3), f"{n} rows of 3")
        if self._last is None or self._last[0] != k - 1:
            return (NO_RESPONSE,) * n
        _, before, by_law = self._last
        return tuple(self._monitor.observe(before, by_law if asked is None else asked, x).tolist())

    def _choose(self, prediction: Prediction) -> tuple[Choice, Answer]:
        if self._shifts is not None:
            way_out = self._watch.way_out(prediction, self._shifts)
            if way_out is not None:
                return way_out, Answer.PASSAGE
        found = choice.cheapest(self._predictor, prediction)
        if found is not None:
            return found, Answer.OPTIMAL
        if self._shifts is not None and not prediction.lost.any():
            return Choice(self._shifts, 0), Answer.HELD
        if prediction.lost.any():
            longest = choice.longest_kept(self._predictor, prediction)
            if longest is not None:
                return longest, Answer.LONGEST_KEPT
        return choice.least_violating(self._predictor, prediction), Answer.LEAST_VIOLATING

    def _decision(
        self,
        prediction: Prediction,
        x: Array,
        chosen: Choice,
        answer: Answer,
        response: tuple[float, ...],
    ) -> TimeShiftDecision:
        problem, shifts = self.problem, chosen.shifts
        shift_cost, state_cost = choice.cost_of(self._predictor, prediction, shifts)
        error = self._error(prediction, x, shifts)
        arrived = error < self.formed_within
        held = self._shifts is not None and np.array_equal(shifts, self._shifts)
        self._watch.notice(
            prediction, shifts, held=held, arrived=arrived, is_equal=shift_cost == 0.0
        )
        is_stuck = self._watch.is_deadlocked and shift_cost > 0.0
        return TimeShiftDecision(
            step=prediction.step,
            shifts=shifts,
            answer=answer,
            shift_cost=shift_cost,
            state_cost=state_cost,
            n_admissible=chosen.n_admissible,
            n_candidates=problem.samples ** int(np.count_nonzero(~prediction.lost)),
            margin=self._least(prediction, shifts),
            refused=self._refused(prediction, shifts, shift_cost + state_cost),
            error=error,
            formed=shift_cost == 0.0 and arrived and not prediction.lost.all(),
            deadlocked=is_stuck,
            waypoint=shifts if answer == Answer.PASSAGE else _NONE,
            waypoints_left=self._watch.left(shifts) if is_stuck else 0,
            lost=prediction.lost,
            response=response,
        )

    def _error(self, prediction: Prediction, x: Array, shifts: Integers) -> float:
        """Return the largest distance from the commanded positions [m]."""
        away = (x - self.problem.commanded(prediction.step, shifts))[~prediction.lost, :3]
        return math.sqrt(np.einsum("ij,ij->i", away, away).max(initial=0.0))

    def _least(self, prediction: Prediction, shifts: Integers) -> Margin | None:
        found = self._predictor.margins(prediction, shifts)
        return min(found, key=lambda margin: margin.share) if found else None

    def _refused(self, prediction: Prediction, shifts: Integers, cost: float) -> Margin | None:
        wish = choice.cheaper(self._predictor, prediction, shifts, cost)
        return None if wish is None else self._least(prediction, wish)


def require_admissible(problem: TimeShiftProblem, states: object) -> None:
    """Refuse a start (n, 6) at step 0 from which no combination of shifts is admissible.

    Raises
    ------
    ParameterError
        With the constraint, craft, step and amount of the least violating combination.
    """
    missed = start_violation(problem, states)
    if missed is not None:
        raise ParameterError(
            f"start: received one from which none of the {problem.samples**problem.n_craft} "
            f"combinations of time shifts keeps every limit; missed at the least by "
            f"{-100.0 * missed.share:.3g} %: {missed.text()}; required one that keeps them all; "
            "start nearer, or widen that limit"
        )


def start_violation(problem: TimeShiftProblem, states: object) -> Margin | None:
    """Return what the least violating combination exceeds at step 0; None if one is admissible.

    Parameters
    ----------
    problem : TimeShiftProblem
    states : (n, 6) array
        Position [m] and velocity [m/s] of each craft.
    """
    n = problem.n_craft
    x = as_finite("states", states, (n, 6), f"{n} rows of 6 finite numbers")
    predictor = Predictor(problem)
    none = np.zeros(n, dtype=np.bool_)
    prediction = predictor.predict(0, x, np.zeros(n, dtype=np.int64), none)
    if choice.cheapest(predictor, prediction) is not None:
        return None
    shifts = choice.least_violating(predictor, prediction).shifts
    return min(predictor.margins(prediction, shifts), key=lambda found: found.share)
