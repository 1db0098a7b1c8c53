"""The audit of a bag, from the file to the table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from spacecraft_gnc.analysis.audit.order import audit_order
from spacecraft_gnc.analysis.limits import Exceedance, as_dicts, limits_exceeded
from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import Evidence, Progress, read_evidence
from spacecraft_gnc.audit.ledger import Check, Difference, Ledger
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.steps import REFERENCE, SOLVER_STATUS, STATE, TORQUE
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.fingerprint import fingerprint
from spacecraft_gnc.vehicles.rigid_body.audit.decisions import audit_decisions
from spacecraft_gnc.vehicles.rigid_body.audit.failures import FAILURES
from spacecraft_gnc.vehicles.rigid_body.audit.motion import applied_torques, audit_motion
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier
from spacecraft_gnc.vehicles.rigid_body.audit.references import audit_references
from spacecraft_gnc.vehicles.rigid_body.audit.rungs import LAW, NO_SOLVE, audit_law
from spacecraft_gnc.vehicles.rigid_body.audit.solver import SolverAudit
from spacecraft_gnc.vehicles.rigid_body.audit.torques import audit_torques, held_steps


@dataclass(frozen=True, slots=True)
class Audit:
    """What an audit found, and what it rests on.

    Attributes
    ----------
    path
        The bag.
    steps
        Control steps flown.
    checks
        The lines of the table.
    first
        The check, step and field that differ first; None where the bag holds what it says.
    counts
        Failures solved again, fallbacks justified, standstills looked for.
    scenario
        What flew, as the bag says: everything else rests on it.
    exceeded
        Limits that the flight exceeded by more than 0.1 %; no fault of the recording.
    remarks
        What of the bag is not read, one line each.
    """

    path: Path
    steps: int
    checks: tuple[Check, ...]
    first: tuple[Check, Difference] | None
    counts: Counts
    scenario: Scenario
    exceeded: tuple[Exceedance, ...] = ()
    remarks: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
        return self.first is None

    def as_dict(self) -> dict[str, Any]:
        """Return the audit as a JSON-able mapping."""
        found: dict[str, Any] | None = None
        if self.first is not None:
            check, difference = self.first
            found = {"check": check.name, **difference._asdict()}
        return {
            "bag": str(self.path),
            "steps": self.steps,
            "passed": self.passed,
            "first": found,
            "scenario_hash": fingerprint(self.scenario),
            "counts": self.counts.as_dict(),
            "limits_exceeded": as_dicts(self.exceeded),
            "remarks": list(self.remarks),
            "checks": [check.as_dict() for check in self.checks],
        }


def audit_bag(
    path: Path | str,
    *,
    tolerance: float | None = None,
    namespace: str | None = None,
    allow_unfinished: bool = False,
    progress: Callable[[str], Progress | None] | None = None,
) -> Audit:
    """Audit the flight in a bag.

    Parameters
    ----------
    path
        Bag folder or .mcap file.
    tolerance
        What motion and decisions may differ from those made again, as a share of each field's
        largest magnitude; None: not in a bit.
    namespace
        Of the spacecraft, where the bag holds several.
    allow_unfinished
        Audit what is whole of a bag that was cut off, or of a flight that was stopped.
    progress
        Returns, for the name of a part of the work, what is called with its progress.

    Raises
    ------
    RecordingError
        If there is no readable bag, no flight of one spacecraft in it, or no scenario.
    """
    watch = progress or (lambda _: None)
    ledger, counts = Ledger(), Counts()
    with open_bag(path, allow_unfinished=allow_unfinished) as bag:
        bag.verify(watch("checksums"))
        evidence = read_evidence(bag, namespace, watch("reading"), stopped=allow_unfinished)
        held = held_steps(evidence)
        audit_order(evidence, ledger, held, allow_unfinished)
        plant = evidence.scenario.build_plant()
        audit_motion(evidence, plant, ledger, tolerance, watch("integrating"))
        audit_references(evidence, ledger)
        audit_decisions(evidence, ledger, tolerance, watch("asking the governor"))
        _audit_solves(evidence, ledger, counts, tolerance, watch("certifying"))
        audit_torques(evidence, held, ledger)  # last: where a command differs, its plan says so
        remarks = tuple(bag.remarks())
        exceeded = _exceeded(evidence)
    return Audit(
        path=Path(path),
        steps=evidence.n,
        checks=tuple(ledger.checks.values()),
        first=ledger.first,
        counts=counts,
        scenario=evidence.scenario,
        exceeded=exceeded,
        remarks=remarks,
    )


def _exceeded(evidence: Evidence) -> tuple[Exceedance, ...]:
    """Return the limits exceeded by the recorded states and by the torques that acted."""
    steps = np.arange(evidence.n + 1)
    attitudes = evidence.rows(STATE, "attitude", steps).reshape(-1, 3, 3)
    momenta = evidence.rows(STATE, "angular_momentum", steps)
    return limits_exceeded(evidence.scenario, attitudes, momenta, applied_torques(evidence))


def _audit_solves(
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
        makes = "makes no solves" if scenario.traits.memoryless else "is a plug-in's"
        ledger.skip(FAILURES, f"method {method} {makes}")
    if not solves.steps.size:
        why = "solver_status was not recorded: no command is certified"
        ledger.skip("plans of the solver", why)
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
        ledger.skip("plans of the solver", f"method {method} makes none that is known here")
    if not scenario.traits.memoryless and (certifier is None or not certifier.has_law):
        if certifier is None:
            ledger.skip(LAW, f"method {method} is a plug-in's, which may remember its past")
        return
    steps = solves.steps[(solves.fields["status"] == NO_SOLVE) & (solves.steps < evidence.n)]
    for topic in (STATE, REFERENCE, TORQUE):
        steps = np.intersect1d(steps, evidence.columns[topic].steps)
    controller = scenario.build_controller()
    controller.warm_up()
    audit_law(evidence, controller, steps, ledger)
