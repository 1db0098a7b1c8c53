"""Audit of a rigid body's flight: motion, references, solves, torques."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.applied import held_steps
from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import Evidence, Progress, Topics
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.audit.limits import Exceedance
from spacecraft_gnc.audit.telemetry import audit_latched, error_of, pose_of
from spacecraft_gnc.audit.vehicle import Watch
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.status import NO_SOLVE
from spacecraft_gnc.vehicles.rigid_body.audit.decisions import audit_decisions
from spacecraft_gnc.vehicles.rigid_body.audit.failures import FAILURES
from spacecraft_gnc.vehicles.rigid_body.audit.motion import applied_torques, audit_motion
from spacecraft_gnc.vehicles.rigid_body.audit.planned import PlannedAudit
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier
from spacecraft_gnc.vehicles.rigid_body.audit.references import audit_references
from spacecraft_gnc.vehicles.rigid_body.audit.rungs import LAW, audit_law
from spacecraft_gnc.vehicles.rigid_body.audit.solver import SolverAudit
from spacecraft_gnc.vehicles.rigid_body.audit.torques import audit_torques
from spacecraft_gnc.vehicles.rigid_body.markers import zone_markers
from spacecraft_gnc.vehicles.rigid_body.metrics.limits import limits_exceeded
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import plans
from spacecraft_gnc.vehicles.rigid_body.recorded import PLANS, acted, whole_steps
from spacecraft_gnc.vehicles.rigid_body.signals import (
    APPLIED,
    ATTITUDE_PLAN,
    INVARIANTS,
    PLAN_STATUS,
    SOLVER_STATUS,
    STATE,
    TORQUE,
    ZONE_MARKERS,
)

_TOPICS: Final = Topics(
    every_step=(STATE, INVARIANTS, REFERENCE, GOVERNOR_STATUS, TORQUE, SOLVER_STATUS),
    sparse=(ACCEPTED_TARGET, WALL_TIMING, ATTITUDE_PLAN, PLAN_STATUS),
    solves=SOLVER_STATUS,
    plans=PLANS,
    telemetry=(pose_of(STATE), error_of(STATE, TORQUE)),
    later=dict.fromkeys((ATTITUDE_PLAN, PLAN_STATUS), plans),
)

_PLANS: Final = "plans of the solver"


class RigidBodyAudit:
    """Implements `audit.vehicle.VehicleAudit`."""

    topics = _TOPICS

    def require_flight(self, evidence: Evidence) -> None:
        """Refuse what holds no whole control step."""
        whole_steps(evidence.bag, evidence.columns, acted(evidence.columns))

    def held_steps(self, evidence: Evidence) -> NDArray[np.int64]:
        """Return the steps for which the plant says that no command came in time."""
        return held_steps(evidence, APPLIED)

    def audit(
        self,
        evidence: Evidence,
        ledger: Ledger,
        counts: Counts,
        held: NDArray[np.int64],
        tolerance: float | None,
        watch: Watch,
    ) -> tuple[Exceedance, ...]:
        """Enter every check of the flight; return the limits that it exceeded."""
        audit_motion(evidence, ledger, tolerance, watch("integrating"))
        audit_references(evidence, ledger)
        audit_decisions(evidence, ledger, tolerance, watch("asking the governor"))
        planned = PlannedAudit(evidence)
        planned.audit(ledger, held, watch("certifying plans"))
        if planned.is_blind:
            ledger.skip(_PLANS, "plan_status was not recorded: what was tracked is not known")
        else:
            _solves(planned.tracked, ledger, counts, tolerance, watch("certifying"))
        audit_torques(evidence, held, ledger)  # last: where a command differs, its plan says so
        zones = zone_markers(evidence.scenario.controller.zones)
        audit_latched(evidence, ledger, ZONE_MARKERS, (zones,), tolerance)
        return _exceeded(evidence)


AUDIT: Final = RigidBodyAudit()


def _exceeded(evidence: Evidence) -> tuple[Exceedance, ...]:
    """Return the limits exceeded by the recorded states and by the torques that acted."""
    steps = np.arange(evidence.n + 1)
    attitudes = evidence.rows(STATE, "attitude", steps).reshape(-1, 3, 3)
    momenta = evidence.rows(STATE, "angular_momentum", steps)
    return limits_exceeded(evidence.scenario, attitudes, momenta, applied_torques(evidence))


def _solves(
    evidence: Evidence,
    ledger: Ledger,
    counts: Counts,
    tolerance: float | None,
    progress: Progress | None,
) -> None:
    """Certify plans, and have the laws that make none give their commands once more."""
    scenario = evidence.scenario
    certifier, method = Certifier.from_scenario(scenario), scenario.controller.method
    solves, solver = evidence.columns[SOLVER_STATUS], None
    if certifier is not None:
        any_failure = tolerance is not None
        solver = SolverAudit(evidence, certifier, ledger, counts, any_failure=any_failure)
    else:
        makes = "makes no solves" if scenario.method.memoryless else "is a plug-in's"
        ledger.skip(FAILURES, f"method {method} {makes}")
    if not solves.steps.size:
        why = "solver_status was not recorded: no command is certified"
        ledger.skip(_PLANS, why)
        if solver is not None:
            solver.finish()
        return
    if scenario.vehicle.method(method) is not None:
        same = solves.fields["method"] == method
        ledger.require("method", f"{method}", solves.steps, "solver_status.method", same)
    ledger.skip("iterations and wall times", "they tell of the run, not of the plan")
    if solver is not None:
        for block in evidence.solves(progress):
            solver.audit(block)
        solver.finish()
    else:
        none = solves.fields["status"] == NO_SOLVE
        same, where = solves.fields["formulation"][none] == "", "solver_status.formulation"
        ledger.require("formulation of the method", "none", solves.steps[none], where, same)
        ledger.skip(_PLANS, f"method {method} makes none that is known here")
    if not scenario.method.memoryless and (certifier is None or not certifier.has_law):
        if certifier is None:
            ledger.skip(LAW, f"method {method} is a plug-in's, which may remember its past")
        return
    steps = solves.steps[(solves.fields["status"] == NO_SOLVE) & (solves.steps < evidence.n)]
    for topic in (STATE, REFERENCE, TORQUE):
        steps = np.intersect1d(steps, evidence.columns[topic].steps)
    controller = scenario.build_controller()
    controller.warm_up()
    audit_law(evidence, controller, steps, ledger)
