"""Governor of a flight along plans, which starts with the plan that the bag tells.

That plan may come from a file, which is not in the bag, and of two optima that cost the same a file
may hold the other one. `transfers` certifies it; here it is only flown once more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from spacecraft_gnc.governors.planned.governor import PlannedGovernor
from spacecraft_gnc.governors.planned.report import Cause
from spacecraft_gnc.ocp.transfer import AttitudeTransfer, TransferSolution
from spacecraft_gnc.ocp.transfer.conditions import Residuals
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.governors.laws import PLANNED
from spacecraft_gnc.vehicles.rigid_body.plan_keeper import guard_of, keeper_of
from spacecraft_gnc.vehicles.rigid_body.signals import ATTITUDE_PLAN
from spacecraft_gnc.vehicles.rigid_body.transfer import transfer_of

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
    """Return the plan of the start; None where it was not told, or is not of the scenario."""
    columns = evidence.columns[ATTITUDE_PLAN]
    problem = transfer_of(evidence.scenario)
    for i in np.flatnonzero(columns.fields["cause"] == Cause.START)[:1]:
        row = {name: values[i] for name, values in columns.fields.items()}
        if int(np.isfinite(row["torques"]).sum()) == 3 * problem.n_steps:
            return _solution(problem, row)
    return None


def _solution(problem: AttitudeTransfer, row: Mapping[str, Any]) -> TransferSolution:
    """Return the told plan of a transfer; what only tells how it was found is left out."""
    n = problem.n_steps

    def nodes(name: str, count: int, width: int = 3) -> Array:
        values = np.asarray(row[name], dtype=np.float64)[: width * count]
        return np.ascontiguousarray(values).reshape(count, width)

    return TransferSolution(
        problem=problem,
        status=Status.CONVERGED,
        torque=nodes("torques", n),
        momentum=nodes("momenta", n + 1),
        attitude=nodes("attitudes", n + 1, 9).reshape(-1, 3, 3),
        co_momentum=nodes("co_momenta", n),
        zeta=row["zeta"],
        torque_multipliers=nodes("torque_multipliers", n),
        momentum_multipliers=nodes("momentum_multipliers", n + 1),
        active_torque=np.zeros((n, 3), dtype=np.int64),
        active_momentum=np.zeros((n + 1, 3), dtype=np.int64),
        cost=float(row["cost"]),
        residuals=Residuals(*[math.nan] * len(Residuals._fields)),
        min_curvature=math.nan,
        iterations=0,
        tried=(),
        reason="told in the bag",
        solve_time=math.nan,
    )
