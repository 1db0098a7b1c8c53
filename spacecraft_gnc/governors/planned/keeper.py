"""Plan that is flown: what of it belongs to a step, and when another one takes its place."""

from __future__ import annotations

import math
from concurrent.futures import Future
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_count, as_limit, require_kind
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import GncError, ParameterError
from spacecraft_gnc.governors.planned.guard import BoundGuard
from spacecraft_gnc.governors.planned.motion import PlannedMotion
from spacecraft_gnc.governors.planned.replanner import Replanner
from spacecraft_gnc.governors.planned.report import Cause, Phase, Planned, PlanReport
from spacecraft_gnc.ocp.transfer import TransferSolution, TransferSolver
from spacecraft_gnc.types import Array, Matrix3, State, Vector3, read_only

_PAUSE: Final = 10  # steps from a first search without success to the next one; it doubles
_ELSEWHERE: Final = math.radians(1.0)
"""Attitude error at which a flight starts elsewhere than planned, where no other is given."""
_SAME: Final = 1e-9
"""Angle [rad] up to which two targets are one."""
_NOT_TRACKED: Final = read_only(np.full(3, math.nan))


class _Search(NamedTuple):
    """Another plan that is sought."""

    first_step: int
    cause: Cause
    goal: Matrix3
    asked: tuple[Any, ...]
    """Arguments of `Replanner.ask`, which tell the answer."""
    answer: Future[TransferSolution | None]


class PlanKeeper:
    """Keep a plan in flight, and have another one made where it no longer fits.

    Another plan is due where the target has changed, where the attitude is further off the plan
    than ``replan_error``, or where the flight starts elsewhere than planned. Asked for at step k,
    it starts at step k + ``lead``, from the state that is predicted for that step, and is taken
    there; until then the old plan counts.

    Parameters
    ----------
    plan : TransferSolution
        The first one; it begins with the flight.
    guard : BoundGuard
        Bounds that the prediction keeps.
    plant_step : float
        Step of the integrator that is to follow [s].
    solver : TransferSolver, optional
        Makes the further plans.
    replan_error : float
        [rad]; 0: the plan is kept however far off the body is.
    lead : int
        Steps from the request of a plan to its start.

    Attributes
    ----------
    waits : bool
        Whether a plan that is due at a step is waited for there, which makes flights repeatable. If
        not, it is taken as soon as it is found.
    """

    def __init__(
        self,
        plan: TransferSolution,
        guard: BoundGuard,
        plant_step: float,
        *,
        solver: TransferSolver | None = None,
        replan_error: float = math.radians(2.0),
        lead: int = 5,
    ) -> None:
        self._first = require_kind("plan", plan, TransferSolution)
        self._guard = require_kind("guard", guard, BoundGuard)
        self._plant_step = plant_step
        self._replanner = Replanner(plan.problem, solver)
        self._replan_error = as_limit("replan_error", replan_error)
        self._lead = as_count("lead", lead)
        self.waits = True
        self.reset()

    @property
    def body(self) -> RigidBody:
        """Body that is believed, with the control period as its step."""
        return self._first.problem.body

    @property
    def goal(self) -> Matrix3:
        """Attitude (3, 3) at which the first plan ends, body to inertial."""
        return self._first.problem.goal

    def reset(self) -> None:
        """Return to the first plan, which begins with the step that is asked for next."""
        self._motion = PlannedMotion(self._first, 0, self._plant_step)
        self._number = -1
        self._asked: tuple[Any, ...] | None = None  # for the plan that is flown; None: the first
        self._search: _Search | None = None
        self._cause: Cause | None = None
        self._target = self.goal
        self._failed, self._next_search, self._pause = False, 0, _PAUSE

    def memory(self) -> tuple[Any, ...]:
        """Return what is flown and sought, each by what was asked for, and why."""
        search = self._search
        sought = None if search is None else (*search[:3], search.asked)
        flown = self._number, self._motion.first_step, self._asked
        pauses = self._failed, self._next_search, self._pause
        return flown, sought, self._cause, self._target, pauses

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the keeper did whose `memory` it is; its plans are made again.

        Raises
        ------
        GncError
            If none is found, which cannot be where the keepers are equal.
        """
        flown, sought, cause, self._target, pauses = memory
        self._number, first_step, self._asked = flown
        self._failed, self._next_search, self._pause = pauses
        self._cause = None if cause is None else Cause(cause)
        found = self._first if self._asked is None else self._replanner.find(*self._asked)
        if found is None:
            raise ParameterError(
                "memory: received one of a plan that is not found again; required an equal keeper"
            )
        self._motion = PlannedMotion(found, first_step, self._plant_step)
        self._search = None
        if sought is not None:
            step, why, goal, asked = sought
            self._search = _Search(step, Cause(why), goal, asked, self._replanner.ask(*asked))

    def look(self, state: State, target: Matrix3) -> PlanReport:
        """Return what belongs to the step that starts at ``state``; `seek` is to follow.

        Parameters
        ----------
        state : State
        target : (3, 3) array
            Attitude that is finally wanted, body to inertial.
        """
        if not _is_same(self._target, target):
            self._failed, self._pause = False, _PAUSE
            if self._search is not None:
                self._search.answer.cancel()
                self._search = None
        told = self._take(state.step)
        motion = self._motion
        here = motion.at(state.step)
        error = lie.angle_between(here.attitude, state.attitude)
        self._target, self._cause = target, self._cause_of_another(target, error, bool(told))
        return PlanReport(
            number=self._number,
            plan_step=here.plan_step,
            phase=self._phase(state.step, here.plan_step),
            attitude_error=error,
            momentum_error=state.momentum - here.momentum,
            attitude=here.attitude,
            momentum=here.momentum,
            torque=here.torque,
            reference=here.reference,
            nominal_torque=_NOT_TRACKED,
            told=told,
        )

    def seek(self, state: State, torques: Array | None = None) -> None:
        """Have another plan made, where `look` found that one is due at this step.

        Parameters
        ----------
        state : State
            That of `look`.
        torques : (m, 3) array, optional
            What is going to be commanded from this step on, before the bounds are kept [N m]; those
            of the plan where it is not given, and after its end.
        """
        if self._cause is None or not self._is_due(state.step):
            return
        first_step = state.step + self._lead
        try:
            start = self._predict(state, torques)
        except GncError:  # of a state that is no state, or too fast for any step
            self._fail(state.step)
            return
        steps = self._first.problem.n_steps
        left = self._motion.first_step + self._motion.n_steps - first_step
        if self._cause is Cause.DEVIATION:
            steps = max(left, 1)
        asked = (*start, self._target, steps)
        answer = self._replanner.ask(*asked)
        self._search = _Search(first_step, self._cause, self._target, asked, answer)

    def _take(self, step: int) -> tuple[Planned, ...]:
        """Take the plan that is due, and return it."""
        if self._number < 0:
            return (self._begin(self._first, step, Cause.START),)
        search = self._search
        if search is None or step < search.first_step:
            return ()
        if not (self.waits or search.answer.done()):
            return ()
        self._search = None
        found = search.answer.result()
        if found is None:
            self._fail(step)
            return ()
        self._asked = search.asked
        return (self._begin(found, search.first_step, search.cause),)

    def _begin(self, plan: TransferSolution, first_step: int, cause: Cause) -> Planned:
        self._motion = PlannedMotion(plan, first_step, self._plant_step)
        self._number += 1
        self._failed, self._pause = False, _PAUSE
        return Planned(self._number, first_step, cause, plan)

    def _fail(self, step: int) -> None:
        self._failed, self._next_search = True, step + self._pause
        self._pause *= 2

    def _cause_of_another(self, target: Matrix3, error: float, is_new: bool) -> Cause | None:
        """Return why another plan is wanted; None: this one fits."""
        if not _is_same(self._motion.goal, target):
            return Cause.TARGET
        most = self._replan_error or math.inf
        if is_new and self._number == 0:
            most = self._replan_error or _ELSEWHERE
        return Cause.DEVIATION if error > most else None

    def _is_due(self, step: int) -> bool:
        return self._search is None and not (self._failed and step < self._next_search)

    def _phase(self, step: int, plan_step: int) -> Phase:
        if self._search is not None or (self._cause is not None and self._is_due(step)):
            return Phase.REPLANNING
        if self._cause is not None and self._failed:
            return Phase.NOT_FOUND
        return Phase.ARRIVED if plan_step == self._motion.n_steps else Phase.FLYING

    def _predict(self, state: State, torques: Array | None) -> tuple[Matrix3, Vector3]:
        """Return the state (3, 3), (3,) of the believed body, ``lead`` steps on."""
        _, attitude, momentum = state
        ahead = self._motion.torques(state.step, self._lead)
        if torques is not None:
            known = min(len(torques), self._lead)
            ahead[:known] = torques[:known]
        for torque in ahead:
            kept = self._guard.clip(momentum, torque)
            attitude, momentum = self.body.step(attitude, momentum, kept)
        return attitude, momentum


def _is_same(first: Matrix3, second: Matrix3) -> bool:
    return np.array_equal(first, second) or lie.angle_between(first, second) <= _SAME
