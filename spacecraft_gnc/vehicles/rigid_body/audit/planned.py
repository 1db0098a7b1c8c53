"""Audit of flights along plans: the plans, the steps along them, and commands within bounds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.channels import is_expected
from spacecraft_gnc.audit.evidence import Evidence, Progress
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.audit.order import audit_each_step, audit_stamps, stamps_of
from spacecraft_gnc.governors.planned.report import Cause
from spacecraft_gnc.recording.columns import Columns
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, REFERENCE
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.rigid_body.audit.believed import Believed
from spacecraft_gnc.vehicles.rigid_body.audit.failures import SOLVED
from spacecraft_gnc.vehicles.rigid_body.audit.plan_steps import audit_plan_steps
from spacecraft_gnc.vehicles.rigid_body.audit.transfers import (
    WHOLE,
    Told,
    TransferAudit,
    read_told,
)
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import makes_plans, plans
from spacecraft_gnc.vehicles.rigid_body.signals import (
    ATTITUDE_PLAN,
    PLAN_STATUS,
    STATE,
    TORQUE,
)

KEPT: Final = "command = what the tracking asks for, within the bounds"
ROUNDING: Final = 1e-9
"""Of a command on a bound, over the largest torque."""


class PlannedAudit:
    """Audits a flight of ``method: planned`` or ``governor: planned``.

    Parameters
    ----------
    evidence
        The flight.
    """

    def __init__(self, evidence: Evidence) -> None:
        self._evidence = evidence
        scenario = evidence.scenario
        self.is_tracked = makes_plans(scenario.method)
        """Whether the controller plans."""
        self.applies = plans(scenario)
        """Whether anything does."""

    @np.errstate(all="ignore")  # numbers of a recording may be of any size
    def audit(self, ledger: Ledger, held: NDArray[np.int64], progress: Progress | None) -> None:
        """Enter the checks of plans, of the steps along them, and of the commands."""
        if not self.applies:
            return
        evidence = self._evidence
        audit_each_step(evidence, ledger, PLAN_STATUS, held)
        audit_stamps(evidence, ledger, PLAN_STATUS)
        targets = self._targets()
        if evidence.columns[ATTITUDE_PLAN].steps.size == 0 and is_expected(evidence, ATTITUDE_PLAN):
            ledger.fail(WHOLE, "one at least", 0, f"{ATTITUDE_PLAN} (missing)")
        elif not evidence.columns[ATTITUDE_PLAN].steps.size:
            ledger.skip(WHOLE, "attitude_plan was not recorded: no plan is certified")
        else:
            told = read_told(evidence, ledger)
            audit = TransferAudit(evidence, ledger)
            asked = {audit.asked(each) for each in told if each.cause != Cause.START}
            audit.audit(told, targets, self._ahead(asked), progress)
            self._steps(ledger, told, targets)
        if self.is_tracked:
            self._commands(ledger)
        else:
            self._published(ledger)

    @property
    def is_blind(self) -> bool:
        """Whether nothing is known of what was tracked."""
        return self.is_tracked and not self._evidence.columns[PLAN_STATUS].steps.size

    @property
    def tracked(self) -> Evidence:
        """The flight as the tracking sees it: with the plan as its reference, before the bounds."""
        evidence = self._evidence
        if not self.is_tracked or self.is_blind:
            return evidence
        status = evidence.columns[PLAN_STATUS]
        fields = {"attitude": "attitude", "angular_velocity": "reference_rate",
                  "torque": "reference_torque"}  # fmt: skip
        seen = {name: status.fields[field] for name, field in fields.items()}
        steps = evidence.common(PLAN_STATUS, TORQUE)
        asked = {
            "torque": evidence.rows(PLAN_STATUS, "nominal_torque", steps),
            "source": evidence.rows(TORQUE, "source", steps),
        }
        columns = {
            **evidence.columns,
            REFERENCE: Columns(status.steps, status.stamps, seen),
            TORQUE: Columns(steps, stamps_of(steps, evidence.scenario.period), asked),
        }
        return replace(evidence, columns=columns)

    def _targets(self) -> dict[int, Matrix3]:
        """Return the attitudes that are finally wanted, by step."""
        evidence = self._evidence
        if self.is_tracked:
            columns = evidence.columns[REFERENCE]
            attitudes = columns.fields.get("attitude", np.empty((0, 9))).reshape(-1, 3, 3)
            return dict(zip(columns.steps.tolist(), attitudes, strict=True))
        changes = evidence.columns[ACCEPTED_TARGET]
        taken = changes.fields.get("attitude", np.empty((0, 9))).reshape(-1, 3, 3)
        known = dict(zip(changes.steps.tolist(), taken, strict=True))
        target = lie.exp(evidence.scenario.governor.target_rotation_vector)
        found: dict[int, Matrix3] = {}
        for step in range(evidence.n + 1):
            target = known.get(step, target)
            found[step] = target
        return found

    def _ahead(self, asked: set[int]) -> Mapping[int, Array]:
        """Return the torques that solves foresaw at steps; none where they did not converge."""
        none = np.empty((0, 3))
        if not self.is_tracked:
            return dict.fromkeys(asked, none)
        found: dict[int, Array] = {}
        for block in self._evidence.solves() if asked else ():
            solved = np.isin(block.fields["status"], SOLVED)
            for i in np.flatnonzero(np.isin(block.steps, sorted(asked))).tolist():
                torques = block.fields["predicted_torques"][i]
                known = torques[np.isfinite(torques)].reshape(-1, 3)
                found[int(block.steps[i])] = known if solved[i] else none
        return found

    def _steps(
        self, ledger: Ledger, told: tuple[Told, ...], targets: Mapping[int, Matrix3]
    ) -> None:
        if self._evidence.columns[PLAN_STATUS].steps.size:
            audit_plan_steps(self._evidence, ledger, told, targets)

    def _commands(self, ledger: Ledger) -> None:
        """Compare the commands with what the tracking asked for, kept within the bounds."""
        evidence, where = self._evidence, f"{TORQUE}.torque"
        steps = evidence.common(PLAN_STATUS, TORQUE, STATE)
        if not steps.size:
            ledger.skip(KEPT, "plan_status or torque_command was not recorded")
            return
        momenta = evidence.rows(STATE, "angular_momentum", steps)
        nominal = evidence.rows(PLAN_STATUS, "nominal_torque", steps)
        believed, recorded = Believed.of(evidence.scenario), evidence.rows(TORQUE, "torque", steps)
        made = believed.kept(momenta, nominal)
        near = ROUNDING * max(float(np.abs(made).max()), 1e-300)
        free = np.ones(made.shape, dtype=bool)
        for side in (-near, near):  # rounding may tip what lies on a bound
            free &= believed.kept(momenta, nominal + side) == nominal + side
        ledger.bound(KEPT, steps, where, recorded - made, np.where(free, 0.0, near), "N m")
        cut = int((np.abs(made - nominal) > near).any(axis=1).sum())
        ledger.check(KEPT, "", f"cut at {cut} of {len(steps)} steps")

    def _published(self, ledger: Ledger) -> None:
        """Compare the references published with the motion of the plan."""
        evidence, name = self._evidence, "reference published = step of the plan"
        steps = evidence.common(PLAN_STATUS, REFERENCE)
        fields = {"attitude": "attitude", "reference_rate": "angular_velocity",
                  "reference_torque": "torque"}  # fmt: skip
        for ours, theirs in fields.items():
            where = f"{REFERENCE}.{theirs}"
            recorded = evidence.rows(REFERENCE, theirs, steps)
            made = evidence.rows(PLAN_STATUS, ours, steps)
            ledger.compare(name, steps, {where: recorded}, {where: made})
