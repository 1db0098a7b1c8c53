"""Audit of recorded plans, by code that calls no solver."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Evidence, Progress
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.recording.columns import Columns
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.status import NO_SOLVE, Status
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.audit.certificates import Planned
from spacecraft_gnc.vehicles.two_wheel.audit.torque_plans import MODEL as BUS_MODEL
from spacecraft_gnc.vehicles.two_wheel.audit.torque_plans import (
    TorqueProblem,
    audit_torque_plans,
)
from spacecraft_gnc.vehicles.two_wheel.audit.wheel_problem import WheelProblem, integrated_turns
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Terminal
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321
from spacecraft_gnc.vehicles.two_wheel.signals import COMMAND, SOLVER_STATUS, STATE

PLANS: Final = "plans told"
_NAMES: Final = "method, model and solver"
_NAMED: Final = ("method", "model", "solver")
MODELS: Final = ("simplified", "euler_321", "so3")
_EVERY: Final = 8
"""Plans of which one has its curvature worked out."""
_ROUNDING: Final = 1e-12
_TIGHT: Final = 1e-9
_SOLVED: Final = 1e-6
"""Distance from the end [rad] that a solved plan may have; solvers stop at 1e-8."""
_STATIONARY: Final = 2e-7
"""Residual likewise: of multipliers that solvers do not have to take."""
_CURVATURE: Final = 1e-3
"""Relative error of a curvature: of the differences of gradients."""


class _Row(NamedTuple):
    """One recorded solve that succeeded."""

    step: int
    model: str
    terminal: Terminal
    planned: NDArray[np.bool_]
    attitude: Array
    """(3, 3) of the state."""
    speed: Array
    """(2,) of the state."""
    end: Array
    """(3, 3) that the plan is to end at."""
    drift: Array
    """(N+1, 3) body frame."""
    attitudes: Array
    speeds: Array
    accelerations: Array
    told: dict[str, float]


class _Found(NamedTuple):
    """What is wrong with one plan; 0: nothing."""

    start: float
    """State and first node."""
    sums: float
    """Speeds against sums of accelerations [rad/s]."""
    rest: float
    """Wheel speeds at the end [rad/s]."""
    excess: float
    """Beyond the limits, over them."""
    flow: float
    """Attitudes against the own integration, over its tolerance."""
    cost: float
    """Relative."""
    violation: float
    """Angle off the end against what is told [rad]."""
    end: float
    """Angle off the end where that is a condition [rad]."""
    residual: float
    curvature: float
    """Relative; NaN: not worked out."""
    convex: float
    """0 where the least curvature is positive."""


_CHECKS: Final = {
    "plan starts at the state": ("start", "predicted_speeds", _ROUNDING),
    "planned speeds = sums of accelerations": ("sums", "predicted_speeds", 1e-10),
    "plan ends at rest": ("rest", "predicted_speeds", _TIGHT),
    "plan within the limits": ("excess", "predicted_accelerations", _TIGHT),
    "planned attitudes = own integration": ("flow", "predicted_attitudes", 1.0),
    "cost of the plan": ("cost", "cost", _TIGHT),
    "angle off the end": ("violation", "terminal_violation", 1e-7),
    "plan ends where it has to": ("end", "predicted_attitudes", _SOLVED),
    "first-order conditions": ("residual", "predicted_accelerations", _STATIONARY),
    "curvature of the plan": ("curvature", "min_curvature", _CURVATURE),
    "plan is a minimum": ("convex", "min_curvature", 0.0),
}


def audit_plans(evidence: Evidence, ledger: Ledger, progress: Progress | None) -> None:
    """Certify every plan, and hold the commands of two wheels against theirs."""
    if not evidence.columns[SOLVER_STATUS].steps.size:
        ledger.skip(PLANS, f"{SOLVER_STATUS} was not recorded")
        return
    commands = evidence.columns[COMMAND].steps
    told = np.isin(commands, evidence.columns[SOLVER_STATUS].steps)
    ledger.require(PLANS, "one told of each command", commands, str(SOLVER_STATUS), told)
    audit = _PlanAudit(evidence, ledger)
    torque_problems: dict[bytes, TorqueProblem] = {}
    for block in evidence.solves(progress):
        _audit_names(evidence, ledger, block)
        audit.enter(block)
        audit_torque_plans(evidence, ledger, block, torque_problems)


def _audit_names(evidence: Evidence, ledger: Ledger, block: Columns) -> None:
    """Require method, model and solver of the scenario's method: they say what is asked of a plan.

    Where there was no solve, model and solver are empty.
    """
    c = evidence.scenario.controller
    if evidence.scenario.vehicle.method(c.method) is None:
        ledger.skip(_NAMES, f"method {c.method} is a plug-in's")
        return
    bus = ("shooting", BUS_MODEL, "shooting")
    wheels = ("underactuated", c.prediction_model, c.solver)
    known = {"shooting": [bus], "underactuated": [wheels], "fault_tolerant": [bus, wheels]}
    made, nothing = known.get(c.method, []), [(c.method, "", "")]
    told = zip(*(block.fields[name] for name in _NAMED), strict=True)
    statuses = block.fields["status"].tolist()
    kept = [
        names in (nothing if status == NO_SOLVE else made)
        for names, status in zip(told, statuses, strict=True)
    ]
    where = f"{SOLVER_STATUS}.{', '.join(_NAMED)}"
    ledger.require(_NAMES, "the scenario's", block.steps, where, np.array(kept))


class _PlanAudit:
    """Plans of one flight, block by block."""

    def __init__(self, evidence: Evidence, ledger: Ledger) -> None:
        self.evidence, self.ledger = evidence, ledger
        self.count = 0
        self._problems: dict[tuple[str, bytes], WheelProblem] = {}
        self._flown: _Row | None = None

    def enter(self, block: Columns) -> None:
        """Enter the checks of a block of solves."""
        rows = list(self._rows(block))
        if not rows:
            return
        steps = np.array([row.step for row in rows], dtype=np.int64)
        found = [self._examine(row) for row in rows]
        for name, (part, field, limit) in _CHECKS.items():
            values = np.array([getattr(one, part) for one in found])
            known = np.isfinite(values) | (part != "curvature")
            where = f"{SOLVER_STATUS}.{field}"
            self.ledger.bound(name, steps[known], where, values[known], limit)
        self._references(steps, rows)
        self._commands(block, rows)

    def _rows(self, block: Columns) -> Iterator[_Row]:
        """Yield the solves of a block that found a plan of two wheels."""
        solved = (block.fields["status"] == Status.CONVERGED) & np.isin(
            block.fields["model"].astype(str), MODELS
        )
        solved &= np.isin(block.steps, self.evidence.common(COMMAND, STATE, REFERENCE))
        steps = block.steps[solved]
        attitudes = self.evidence.rows(STATE, "attitude", steps).reshape(-1, 3, 3)
        speeds = self.evidence.rows(STATE, "wheel_speed", steps)
        for i, k in enumerate(np.flatnonzero(solved).tolist()):
            yield _row(block, k, attitudes[i], speeds[i])

    def _examine(self, row: _Row) -> _Found:
        """Return what is wrong with a plan."""
        problem = self._problem(row.planned, row.model)
        soft = row.terminal is Terminal.SOFT
        turn = problem.frame
        error = turn.T @ row.end.T @ row.attitude @ turn
        plan = Planned(
            problem, row.model, soft, error, row.drift @ turn, row.speed, row.accelerations
        )
        u = row.accelerations[None]
        speeds = problem.speeds(row.speed, u)
        errors = problem.errors(row.model, error, plan.drift, speeds)
        cost = float(problem.cost(errors, speeds, u, soft)[0])
        first = plan.certify()
        self.count += 1
        curvature = plan.curvature(first) if self.count % _EVERY == 1 else np.nan
        told = row.told
        angle = lie.angle_between(row.attitudes[-1], row.end)
        return _Found(
            start=max(_largest(row.speeds[0] - row.speed),
                      _largest(row.attitudes[0] - row.attitude)),
            sums=_largest(row.speeds - speeds[0]),
            rest=_largest(row.speeds[-1]),
            excess=max(_excess(row.speeds[1:], problem.max_speed),
                       _excess(row.accelerations, problem.max_acceleration)),
            flow=_flow_defect(problem, row, errors[0]),
            cost=abs(cost - told["cost"]) / max(abs(cost), 1e-12),
            violation=abs(angle - told["terminal_violation"]),
            end=0.0 if soft else angle,
            residual=first.residual,
            curvature=_relative(curvature, told["min_curvature"]),
            convex=float(not told["min_curvature"] > 0.0),
        )  # fmt: skip

    def _problem(self, planned: NDArray[np.bool_], model: str) -> WheelProblem:
        key = model, planned.tobytes()
        if key not in self._problems:
            self._problems[key] = WheelProblem.of(self.evidence.scenario, planned, model)
        return self._problems[key]

    def _references(self, steps: NDArray[np.int64], rows: list[_Row]) -> None:
        """Compare the ends with the references, where they are not waypoints."""
        direct = np.array([row.terminal is not Terminal.WAYPOINT for row in rows])
        ends = np.array([row.end.ravel() for row in rows])
        where = f"{SOLVER_STATUS}.terminal_attitude"
        wanted = self.evidence.rows(REFERENCE, "attitude", steps)
        self.ledger.compare(
            "end of the plan = reference", steps[direct], {where: ends[direct]},
            {where: wanted[direct]},
        )  # fmt: skip

    def _commands(self, block: Columns, rows: list[_Row]) -> None:
        """Compare the commands with the plans: that of the step, or the rest of an earlier one."""
        made = {row.step: row for row in rows}
        steps, wanted = [], []
        sources = self.evidence.rows(COMMAND, "source", block.steps)
        for step, source in zip(block.steps.tolist(), sources.tolist(), strict=True):
            if source == Source.OPTIMAL:
                self._flown = made.get(step)
            flown = self._flown
            if flown is None or source not in (Source.OPTIMAL, Source.SHIFTED_PLAN):
                continue
            done = step - flown.step
            steps.append(step)
            full = np.full(flown.planned.size, np.nan)
            full[flown.planned] = flown.accelerations[done] if done < len(flown.drift) - 1 else 0.0
            wanted.append(full)
        if not steps:
            return
        numbers, expected = np.array(steps, dtype=np.int64), np.array(wanted)
        where = f"{COMMAND}.acceleration"
        recorded = self.evidence.rows(COMMAND, "acceleration", numbers)
        recorded = np.where(np.isnan(expected), 0.0, recorded)
        self.ledger.compare(
            "command = plan", numbers, {where: recorded}, {where: np.nan_to_num(expected)}
        )


def _row(block: Columns, k: int, attitude: Array, speed: Array) -> _Row:
    """Return message ``k`` of a block, with the state that it was made for."""

    def listed(name: str, width: int) -> Array:
        values = np.asarray(block.fields[name][k], dtype=np.float64)
        return values[np.isfinite(values)].reshape(-1, width)

    planned = block.fields["planned"][k] == 1.0
    speeds, drift = listed("predicted_speeds", 2), listed("drift", 3)
    return _Row(
        int(block.steps[k]),
        str(block.fields["model"][k]),
        Terminal(int(block.fields["terminal"][k])),
        planned,
        attitude,
        speed[planned],
        block.fields["terminal_attitude"][k].reshape(3, 3),
        drift if drift.size else np.zeros((len(speeds), 3)),
        listed("predicted_attitudes", 9).reshape(-1, 3, 3),
        speeds,
        listed("predicted_accelerations", 2),
        {
            name: float(block.fields[name][k])
            for name in ("cost", "terminal_violation", "min_curvature")
        },
    )


def _flow_defect(problem: WheelProblem, row: _Row, errors: Array) -> float:
    """Return what the attitudes are off the own integration, over its tolerance.

    Turns of the exact models are integrated step by step by the Runge-Kutta method, to the order
    of the predictions; the simplified model is summed up in closed form.
    """
    turn = problem.frame
    if row.model == "simplified":
        own = np.array([from_euler_321(angles) for angles in errors])
        return _largest(row.end @ turn @ own @ turn.T - row.attitudes) / 1e-10
    rates = row.speeds @ (turn @ problem.rates).T + row.drift
    before, after, period = rates[:-1], rates[1:], problem.period
    own = integrated_turns(before, after, period)
    recorded = row.attitudes[:-1].transpose(0, 2, 1) @ row.attitudes[1:]
    size = np.linalg.norm(rates, axis=1)
    turned = period * np.maximum(size[:-1], size[1:])
    turned += np.sqrt(period * np.linalg.norm(after - before, axis=1))
    limits = 3e-3 * turned**5 + _ROUNDING
    return float((np.abs(recorded - own).max(axis=(1, 2)) / limits).max())


def _largest(values: Array) -> float:
    return float(np.abs(values).max())


def _excess(values: Array, limit: float) -> float:
    """Return by what values exceed a limit, over it; 0 where there is none."""
    return max(_largest(values) / limit - 1.0, 0.0) if limit else 0.0


def _relative(own: float, told: float) -> float:
    """Return the relative difference of two numbers; 0 where both are infinite."""
    return 0.0 if own == told else abs(own - told) / max(abs(own), 1e-300)
