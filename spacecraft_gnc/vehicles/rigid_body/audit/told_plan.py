"""Governor of a flight along plans, which starts with the plan that the bag tells.

That plan may come from a file, which is not in the bag, and of two optima that cost the same a file
may hold the other one. `transfers` certifies it; here it is only flown once more.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.governors.planned.governor import PlannedGovernor
from spacecraft_gnc.governors.planned.report import Cause
from spacecraft_gnc.ocp.transfer import AttitudeTransfer, TransferSolution
from spacecraft_gnc.ocp.transfer.conditions import Residuals
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.rigid_body.audit.transfers import Told, read_told
from spacecraft_gnc.vehicles.rigid_body.governors.laws import PLANNED
from spacecraft_gnc.vehicles.rigid_body.planner.keeper import guard_of, keeper_of
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import transfer_of

if TYPE_CHECKING:
    from spacecraft_gnc.audit.evidence import Evidence
    from spacecraft_gnc.loop.protocols import Governor

    AnyGovernor: TypeAlias = Governor[Any, Any]


def governor_of(evidence: Evidence) -> AnyGovernor:
    """Return the governor of a flight."""
    scenario = evidence.scenario
    first = _first_plan(evidence) if scenario.law is PLANNED else None
    if first is None:
        governor: AnyGovernor = scenario.build_governor()
        return governor
    return PlannedGovernor(keeper_of(scenario, guard_of(scenario), first))


def _first_plan(evidence: Evidence) -> TransferSolution | None:
    """Return the plan of the start; None where it was not told whole, or is not of the scenario."""
    problem = transfer_of(evidence.scenario)
    starts = (each for each in read_told(evidence, Ledger()) if each.cause == Cause.START)
    first = next(starts, None)
    if first is None or first.n_steps != problem.n_steps:
        return None
    return _solution(problem, first)


def _solution(problem: AttitudeTransfer, first: Told) -> TransferSolution:
    """Return the told plan of a transfer; what only tells how it was found is left out."""
    plan, n = first.plan, first.n_steps
    return TransferSolution(
        problem=problem,
        status=Status.CONVERGED,
        torque=plan.torques,
        momentum=plan.momenta,
        attitude=plan.attitudes,
        co_momentum=plan.co_momenta,
        zeta=plan.zeta,
        torque_multipliers=plan.torque_multipliers,
        momentum_multipliers=plan.momentum_multipliers,
        active_torque=np.zeros((n, 3), dtype=np.int64),
        active_momentum=np.zeros((n + 1, 3), dtype=np.int64),
        cost=first.told["cost"],
        residuals=Residuals(*[math.nan] * len(Residuals._fields)),
        min_curvature=math.nan,
        iterations=0,
        tried=(),
        reason="told in the bag",
        solve_time=math.nan,
    )
