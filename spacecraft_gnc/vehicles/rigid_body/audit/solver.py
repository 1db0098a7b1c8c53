"""Audit the solves: certificate, command and source of each step."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp.neighboring import FORMULATION as NEIGHBORING
from spacecraft_gnc.recording.columns import Columns
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.status import NO_SOLVE, Status
from spacecraft_gnc.vehicles.rigid_body.audit.certificate import CertificateAudit, Rows
from spacecraft_gnc.vehicles.rigid_body.audit.corrections import CorrectionAudit
from spacecraft_gnc.vehicles.rigid_body.audit.failures import FAILURES, SOLVED, FailureAudit
from spacecraft_gnc.vehicles.rigid_body.audit.plans import (
    Certificates,
    Certifier,
    Plans,
)
from spacecraft_gnc.vehicles.rigid_body.audit.rungs import LadderAudit
from spacecraft_gnc.vehicles.rigid_body.audit.standstills import STANDSTILLS, StandstillAudit
from spacecraft_gnc.vehicles.rigid_body.signals import STATE, TORQUE

_UNSOLVED: Final = [source for source in Source if source.is_fallback] + [
    Source.NEIGHBORING_EXTREMAL
]
"""Where the torque of a step comes from whose solve did not."""


class SolverAudit:
    """Audits solves block by block.

    Parameters
    ----------
    evidence
        The flight.
    certifier
        Problem of the method; None where it makes no plans that are known here.
    ledger, counts
        Get the verdicts.
    any_failure
        Whether a claimed failure may be one of another kind when it is solved again.
    """

    def __init__(
        self,
        evidence: Evidence,
        certifier: Certifier,
        ledger: Ledger,
        counts: Counts,
        *,
        any_failure: bool = False,
    ) -> None:
        self._evidence = evidence
        self._certifier = certifier
        self._ledger = ledger
        parameters = evidence.scenario.controller
        self._certificate = CertificateAudit(certifier, ledger, parameters)
        self._ladder = LadderAudit(evidence, certifier, ledger)
        self._standstill = StandstillAudit(evidence, certifier, ledger, counts)
        self._corrections = CorrectionAudit(evidence, certifier, ledger)
        self._failures = FailureAudit(
            evidence, certifier, self._certificate, ledger, counts, any_failure
        )

    def audit(self, block: Columns) -> None:
        """Audit a block of solver messages."""
        solved = np.isin(block.fields["status"], SOLVED)
        solved &= block.steps < self._evidence.n
        self._sources(block, solved)
        self._formulations(block)
        steps = block.steps[solved]
        rows = {name: values[solved] for name, values in block.fields.items()}
        whole = self._whole(steps, rows)
        steps, rows = steps[whole], {name: values[whole] for name, values in rows.items()}
        plans = self._plans(steps, rows)
        self._ladder.audit(self._fallbacks(block, solved, TORQUE), steps, plans, rows)
        self._failures.audit(block, self._fallbacks(block, solved), steps, plans, rows)
        if not steps.size:
            answered = self._certifier.has_law and (block.fields["status"] == NO_SOLVE).all()
            why = "no step was solved: the law answered" if answered else "no solve converged"
            for name in ("length of the plan", "plan starts at the state", STANDSTILLS):
                self._ledger.skip(name, why)
            return
        self._standstill.audit(steps, plans, rows)
        self._corrections.audit(steps, plans, rows)
        found = self._certifier.certify(plans)
        for formulation in dict.fromkeys(rows["formulation"]):
            chosen = rows["formulation"] == formulation
            own = {name: values[chosen] for name, values in rows.items()}
            own_plans = Plans(*(values[chosen] for values in plans))
            own_found = Certificates(*(values[chosen] for values in found))
            self._start_and_command(steps[chosen], own, own_plans)
            self._certificate.audit(str(formulation), steps[chosen], own, own_plans, own_found)

    def finish(self) -> None:
        """Audit what no solver message tells of."""
        self._failures.audit_unsaid()
        if FAILURES not in self._ledger.checks:
            self._ledger.skip(FAILURES, "no failure is claimed")

    def _fallbacks(
        self, block: Columns, solved: NDArray[np.bool_], *topics: Signal
    ) -> NDArray[np.int64]:
        """Return the steps that the ladder answered: not those that a law answers by itself.

        Of those whose state, reference and ``topics`` were recorded.
        """
        failed = ~solved & (block.steps < self._evidence.n)
        if self._certifier.has_law:
            failed &= block.fields["status"] != NO_SOLVE
        steps = block.steps[failed]
        for topic in (STATE, REFERENCE, *topics):
            steps = np.intersect1d(steps, self._evidence.columns[topic].steps)
        return steps

    def _sources(self, block: Columns, solved: NDArray[np.bool_]) -> None:
        """Require that a converged solve flies, and that only such a one is called optimal."""
        steps = block.steps[block.steps < self._evidence.n]
        steps = np.intersect1d(steps, self._evidence.columns[TORQUE].steps)
        at = np.searchsorted(block.steps, steps)
        source = self._evidence.rows(TORQUE, "source", steps)
        corrected = block.fields["formulation"][at] == NEIGHBORING
        best = np.where(corrected, Source.NEIGHBORING_EXTREMAL, Source.OPTIMAL)
        kept = np.where(solved[at], source == best, np.isin(source, _UNSOLVED))
        self._ledger.require(
            "source follows from the status", "always", steps, "torque_command.source", kept
        )

    def _formulations(self, block: Columns) -> None:
        """Require a formulation of the method of each solve, and none where there was no solve.

        It says what is asked of a plan.
        """
        within = block.steps < self._evidence.n
        claimed = block.fields["formulation"][within].astype(str)
        none = block.fields["status"][within] == NO_SOLVE
        known = self._certifier.formulations
        kept = np.where(none, claimed == "", np.isin(claimed, known))
        name, where = "formulation of the method", "solver_status.formulation"
        self._ledger.require(name, " or ".join(known), block.steps[within], where, kept)

    def _whole(self, steps: NDArray[np.int64], rows: Rows) -> NDArray[np.bool_]:
        """Return whose plan has the length of the horizon and whose step has all its messages."""
        n = self._certifier.ocp.horizon
        sizes = {
            "predicted_attitudes": 9 * (n + 1),
            "predicted_momenta": 3 * (n + 1),
            "predicted_torques": 3 * n,
        }
        name = "length of the plan"
        kept: NDArray[np.bool_] = np.ones(len(steps), dtype=bool)
        for field, size in sizes.items():
            values = rows[field]
            whole = np.isfinite(values[:, :size]).sum(axis=1) == size
            right = whole & (np.isfinite(values[:, size:]).sum(axis=1) == 0)
            self._ledger.require(name, f"N = {n}", steps, f"solver_status.{field}", right)
            kept &= right
        for topic in (STATE, REFERENCE):
            kept &= np.isin(steps, self._evidence.columns[topic].steps)
        return kept

    def _plans(self, steps: NDArray[np.int64], rows: Rows) -> Plans:
        n, m = self._certifier.ocp.horizon, len(steps)
        references = self._evidence.rows(REFERENCE, "attitude", steps)
        motion = [
            self._evidence.rows(REFERENCE, name, steps) for name in ("angular_velocity", "torque")
        ]
        shapes = ((9 * (n + 1), (m, n + 1, 3, 3)), (3 * (n + 1), (m, n + 1, 3)), (3 * n, (m, n, 3)))
        names = ("predicted_attitudes", "predicted_momenta", "predicted_torques")
        attitudes, momenta, torques = (
            np.ascontiguousarray(rows[name][:, :size]).reshape(shape)
            for name, (size, shape) in zip(names, shapes, strict=True)
        )
        references = references.reshape(m, 3, 3)
        first = rows["first_costate"]
        return Plans(references, attitudes, momenta, torques, first, np.stack(motion, axis=1))

    def _start_and_command(self, steps: NDArray[np.int64], rows: Rows, plans: Plans) -> None:
        compare, evidence = self._ledger.compare, self._evidence
        where = "solver_status.predicted_attitudes"
        state = evidence.rows(STATE, "attitude", steps)
        first = plans.attitudes[:, 0].reshape(-1, 9)
        compare("plan starts at the state", steps, {where: first}, {where: state})
        where = "solver_status.predicted_momenta"
        momentum = evidence.rows(STATE, "angular_momentum", steps)
        compare("plan starts at the state", steps, {where: plans.momenta[:, 0]}, {where: momentum})
        flown = (rows["status"] != Status.ESCAPING) & np.isin(steps, evidence.columns[TORQUE].steps)
        where = self._certifier.command
        command = evidence.rows(TORQUE, "torque", steps[flown])
        compare(
            "command = first torque of the plan", steps[flown], {where: command},
            {where: plans.torques[flown, 0]},
        )  # fmt: skip
