"""Steps along plans, made again: what of a plan belongs to each, and when another is taken.

A further plan is due where the target has changed, or where the attitude is further off the plan
than the scenario allows. Asked for at step k, it is taken at step k + ``plan.replan_lead``; where
none was found, it is asked for again some steps later (docs/planned.md).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.governors.planned.report import Cause, Phase
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.rigid_body.audit.believed import Believed
from spacecraft_gnc.vehicles.rigid_body.audit.matrices import transposed, vee
from spacecraft_gnc.vehicles.rigid_body.audit.transfers import Told
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import plan_parameters
from spacecraft_gnc.vehicles.rigid_body.signals import PLAN_STATUS, STATE

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

PAUSE: Final = 10
"""Steps from a first search without success to the next one; they double with each further one."""
ELSEWHERE: Final = math.radians(1.0)
"""Error [rad] at which a flight starts elsewhere than planned, where no other one is given."""
SAME: Final = 1e-9
"""Angle [rad] up to which two targets are one."""
ANGLE: Final = 1e-12
"""[rad]"""
ROUNDING: Final = 1e-13
"""Of the motion of a reference, over the sizes of what it is made of."""
TAKEN: Final = "plans are taken when they are due"


class _Row(NamedTuple):
    """What belongs to a step."""

    number: int
    plan_step: int
    attitude: Array
    momentum: Array
    torque: Array
    moves: bool


def audit_plan_steps(
    evidence: Evidence, ledger: Ledger, plans: tuple[Told, ...], targets: Mapping[int, Matrix3]
) -> None:
    """Compare every PlanStatus with the told plans, and follow when these are due."""
    steps = evidence.common(PLAN_STATUS, STATE)
    rows, known = _rows(steps, plans)
    where = f"{PLAN_STATUS}.number"
    ledger.require("plan of each step told", "before it", steps, where, known)
    steps = steps[known]
    name = "step of the plan = plan"
    for field in ("number", "plan_step", "attitude", "momentum", "torque"):
        made = np.array([np.ravel(getattr(row, field)) for row in rows], dtype=np.float64)
        recorded = evidence.rows(PLAN_STATUS, field, steps).reshape(made.shape)
        where = f"{PLAN_STATUS}.{field}"
        ledger.compare(name, steps, {where: recorded}, {where: made})
    if not len(steps):
        return
    _errors(evidence, ledger, steps)
    _references(evidence, ledger, steps, np.array([row.moves for row in rows]))
    _Follower(evidence.scenario, plans, targets).enter(evidence, ledger, steps)


def _rows(
    steps: NDArray[np.int64], plans: tuple[Told, ...]
) -> tuple[list[_Row], NDArray[np.bool_]]:
    """Return what belongs to steps by the last plan taken before, and which have one."""
    at = np.searchsorted([each.step for each in plans], steps, side="right") - 1
    rows = []
    for step, i in zip(steps[at >= 0].tolist(), at[at >= 0].tolist(), strict=True):
        each = plans[i]
        k, plan = min(max(0, step - each.first_step), each.n_steps), each.plan
        if k == each.n_steps:
            rows.append(_Row(each.number, k, plan.goal, np.zeros(3), np.zeros(3), moves=False))
            continue
        parts = plan.attitudes[k], plan.momenta[k], plan.torques[k]
        rows.append(_Row(each.number, k, *parts, moves=True))
    return rows, np.asarray(at >= 0)


def _errors(evidence: Evidence, ledger: Ledger, steps: NDArray[np.int64]) -> None:
    """Compare what is told of the distance from the plan with states and planned states."""
    planned = evidence.rows(PLAN_STATUS, "attitude", steps).reshape(-1, 3, 3)
    flown = evidence.rows(STATE, "attitude", steps).reshape(-1, 3, 3)
    turn = transposed(planned) @ flown
    cosine = 0.5 * (np.trace(turn, axis1=1, axis2=2) - 1.0)
    angle = np.arctan2(np.linalg.norm(vee(turn), axis=1), cosine)
    off = angle - evidence.rows(PLAN_STATUS, "attitude_error", steps)
    where = f"{PLAN_STATUS}.attitude_error"
    ledger.bound("angle off the plan", steps, where, off, ANGLE, "rad")
    where = f"{PLAN_STATUS}.momentum_error"
    momentum = evidence.rows(STATE, "angular_momentum", steps)
    made = momentum - evidence.rows(PLAN_STATUS, "momentum", steps)
    recorded = evidence.rows(PLAN_STATUS, "momentum_error", steps)
    ledger.compare("momentum off the plan", steps, {where: recorded}, {where: made})


def _references(
    evidence: Evidence, ledger: Ledger, steps: NDArray[np.int64], moves: NDArray[np.bool_]
) -> None:
    """Require of a reference's motion that the body on it has the planned momentum and torque.

    A body that turns by h |w| about w in a step has the momentum sin(h |w|) / (h |w|) J w in its
    middle, and needs (sin(h |w| / 2) / (h |w| / 2))^2 w x J w to do so.
    """
    name = "reference = motion of the plan"
    rate, torque = (
        evidence.rows(PLAN_STATUS, field, steps) for field in ("reference_rate", "reference_torque")
    )
    still = steps[~moves]
    for field, values in (("reference_rate", rate), ("reference_torque", torque)):
        where = f"{PLAN_STATUS}.{field}"
        at_rest = {where: values[~moves]}, {where: np.zeros((len(still), 3))}
        ledger.compare("reference at rest after the plan", still, *at_rest)
    w, tau, there = rate[moves], torque[moves], steps[moves]
    u = evidence.rows(PLAN_STATUS, "torque", there)
    Pi = evidence.rows(PLAN_STATUS, "momentum", there)
    believed, h = Believed.of(evidence.scenario), evidence.scenario.plant.time_step
    angle = h * np.linalg.norm(w, axis=1, keepdims=True)
    Jw = w @ believed.inertia
    off = np.sinc(angle / np.pi) * Jw - (Pi - 0.5 * h * u)
    scale = np.abs(Pi).max(initial=1e-300)
    ledger.bound(name, there, f"{PLAN_STATUS}.reference_rate", off / scale, ROUNDING)
    gyroscopic = np.cross(w, Jw)
    off = tau - u - (1.0 - np.sinc(0.5 * angle / np.pi) ** 2) * gyroscopic
    scale = max(float(np.abs(u).max(initial=1e-300)), float(np.abs(gyroscopic).max(initial=0.0)))
    ledger.bound(name, there, f"{PLAN_STATUS}.reference_torque", off / scale, ROUNDING)


class _Search(NamedTuple):
    """A plan that was asked for."""

    first_step: int
    cause: Cause
    goal: Matrix3


class _Follower:
    """Follows step by step when a plan is asked for and taken."""

    def __init__(
        self, scenario: Scenario, plans: tuple[Told, ...], targets: Mapping[int, Matrix3]
    ) -> None:
        parameters = plan_parameters(scenario)
        self._most = math.radians(parameters.replan_error_deg)
        self._lead = parameters.replan_lead
        self._waits = scenario.plant.mode != "free_run"
        self._plans = {each.step: each for each in plans}
        self._targets = targets
        self._plan: Told | None = None
        self._search: _Search | None = None
        self._target: Matrix3 | None = None
        self._failed, self._next_search, self._pause = False, 0, PAUSE

    def enter(self, evidence: Evidence, ledger: Ledger, steps: NDArray[np.int64]) -> None:
        """Compare plans and phases with those that are due."""
        errors = evidence.rows(PLAN_STATUS, "attitude_error", steps)
        phases = evidence.rows(PLAN_STATUS, "phase", steps)
        taken, same = np.zeros(len(steps), dtype=bool), np.zeros(len(steps), dtype=bool)
        for i, step in enumerate(steps.tolist()):
            taken[i] = self._take(step, int(phases[i]))
            same[i] = self._step(step, float(errors[i])) == phases[i]
        where = f"{PLAN_STATUS}.phase"
        ledger.require(TAKEN, "and no others", steps, "attitude_plan", taken)
        ledger.require("phase of the plan", "the same", steps, where, same)

    def _take(self, step: int, phase: int) -> bool:
        """Take the plan of a step; return whether it was due."""
        told, search, target = self._plans.get(step), self._search, self._targets.get(step)
        if target is not None:
            if self._target is not None and not _same(self._target, target):
                search = self._search = None
                self._failed, self._pause = False, PAUSE
            self._target = target
        if told is not None and told.cause == Cause.START:
            due = told.number == 0 and told.first_step == step
            self._search, self._failed, self._pause = None, False, PAUSE
        elif search is None or step < search.first_step:
            due = told is None
        elif told is not None:
            number = -1 if self._plan is None else self._plan.number
            due = (told.number, told.first_step, told.cause) == (
                number + 1, search.first_step, search.cause,
            )  # fmt: skip
            self._search, self._failed, self._pause = None, False, PAUSE
        else:
            due = True
            if self._waits or phase != Phase.REPLANNING:  # what is not found in time may come later
                self._search, self._failed, self._next_search = None, True, step + self._pause
                self._pause *= 2
        self._plan = told or self._plan
        return due

    def _step(self, step: int, error: float) -> Phase:
        """Return the phase of a step, and ask for another plan where one is due."""
        each, target = self._plan, self._targets.get(step)
        assert each is not None  # noqa: S101
        cause, most = None, self._most or math.inf
        if each.step == step and each.number == 0:
            most = self._most or ELSEWHERE
        if target is not None and not _same(each.plan.goal, target):
            cause = Cause.TARGET
        elif error > most:
            cause = Cause.DEVIATION
        searching = self._search is not None
        due = not searching and not (self._failed and step < self._next_search)
        if cause is not None and due:
            goal = each.plan.goal if target is None else target
            self._search = _Search(step + self._lead, cause, goal)
        if searching or (cause is not None and due):
            return Phase.REPLANNING
        if cause is not None and self._failed:
            return Phase.NOT_FOUND
        return Phase.ARRIVED if step - each.first_step >= each.n_steps else Phase.FLYING


def _same(first: Matrix3, second: Matrix3) -> bool:
    return np.array_equal(first, second) or lie.angle_between(first, second) <= SAME
