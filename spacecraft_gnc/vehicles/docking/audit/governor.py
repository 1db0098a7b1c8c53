"""Audit of the governor: references, wishes, and the optimality conditions of every program."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.audit.evidence import Evidence, Progress
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.vehicles.docking.audit.admissible import Responses
from spacecraft_gnc.vehicles.docking.audit.equations import ATTITUDE, OFFSET, VELOCITY
from spacecraft_gnc.vehicles.docking.audit.law import Model, loop_of
from spacecraft_gnc.vehicles.docking.audit.motion import recorded_rows
from spacecraft_gnc.vehicles.docking.audit.programs import MEMBER, Programs
from spacecraft_gnc.vehicles.docking.audit.told import Told
from spacecraft_gnc.vehicles.docking.decision import Answer, Phase
from spacecraft_gnc.vehicles.docking.signals import (
    ACCEPTED_TARGET,
    COMMAND,
    GOVERNOR_STATUS,
    REFERENCE,
    STATE,
)
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS

_TOLD: Final = "reference = status of the governor"
_WISH: Final = "wish = target"
_LAW: Final = "law of the governor"
_PHASE: Final = "phase of the governor"
_ABORT: Final = "abort asks no force of the lost direction"
_NEAR, _SLOW = 0.5, 0.01
"""Distance [m] and speed [m/s] within which the hold point is reached."""
_FORCE: Final = 1e-6  # [N]


def audit_governor(
    evidence: Evidence, ledger: Ledger, model: Model, progress: Progress | None
) -> None:
    """Check every decision of a law of this vehicle."""
    kind = evidence.scenario.governor.governor
    steps = evidence.common(GOVERNOR_STATUS, STATE, REFERENCE)
    if kind not in ("none", "periodic", "time_invariant"):
        ledger.skip(MEMBER, f"governor {kind} is a plug-in's")
        return
    if not steps.size:
        ledger.skip(MEMBER, f"{GOVERNOR_STATUS} was not recorded")
        return
    told = Told(evidence, steps)
    _audit_told(told, ledger)
    if kind == "none":
        same = told.reference == told.wish
        ledger.require("reference = target", "the same", steps, REFERENCE.name, same.all(axis=1))
        ledger.skip(MEMBER, "governor none solves nothing")
        return
    _audit_abort(told, ledger)
    loop = loop_of(evidence.scenario, model if kind == "periodic" else model.mean)
    Programs(told, Responses(evidence.scenario, loop), ledger).audit(progress)


def _audit_told(told: Told, ledger: Ledger) -> None:
    """Compare what was told twice, and the wish with what was asked for."""
    evidence, steps, g = told.evidence, told.steps, told.evidence.scenario.governor
    where = f"{GOVERNOR_STATUS}.reference"
    ledger.compare(_TOLD, steps, {where: told.field("reference")}, {where: told.reference})
    hold = np.concatenate([g.hold_port_offset, np.zeros(3)]) if g.governor != "none" else 0.0
    wanted = np.where(told.docking[:, None], told.targets, hold)
    where = f"{GOVERNOR_STATUS}.wish"
    ledger.compare(_WISH, steps, {where: told.wish}, {where: wanted})
    same = np.array([law == g.governor for law in told.text("law")])
    ledger.require(_LAW, "the scenario's", steps, f"{GOVERNOR_STATUS}.law", same)
    passed = told.field("status") == Answer.PASSED
    kept = passed == (g.governor == "none")
    ledger.require(_LAW, "the scenario's", steps, f"{GOVERNOR_STATUS}.status", kept)
    count = evidence.columns[ACCEPTED_TARGET].steps.size
    if count:
        ledger.check(_WISH, "", f"targets taken in flight: {count}")


def _audit_abort(told: Told, ledger: Ledger) -> None:
    """Check when an abort begins, its phases, and that it asks no force of what is lost."""
    steps, g, status = told.steps, told.evidence.scenario.governor, told.field("status")
    lost = told.field("lost_thruster").astype(int)
    where = f"{GOVERNOR_STATUS}.phase"
    aborts = (lost >= 0) & g.aborts
    ledger.require(_PHASE, "as defined", steps, where, told.docking == ~aborts)
    at = np.flatnonzero(aborts)
    if not at.size:
        ledger.skip(_ABORT, "there was no abort")
        return
    y = recorded_rows(told.evidence, steps[at], "measured_")
    far = np.linalg.norm(y[:, OFFSET] - g.hold_port_offset, axis=1)
    slow = np.linalg.norm(y[:, VELOCITY], axis=1) < _SLOW
    holds = told.field("phase")[at] == Phase.HOLDING
    ledger.require(_PHASE, "as defined", steps[at], where, holds == ((far < _NEAR) & slow))
    axes = np.vstack([np.eye(3), -np.eye(3)])[lost[at]]
    asked = np.einsum("nij,nj->ni", y[:, ATTITUDE].reshape(-1, 3, 3), axes)
    commanded = np.isin(steps[at], told.evidence.common(COMMAND))  # none at the end of a flight
    answered = steps[at][commanded]
    force = told.evidence.rows(COMMAND, "wrench", answered)[:, :3]
    along = np.maximum(0.0, np.sum(asked[commanded] * force, axis=1))
    ledger.bound(_ABORT, answered, f"{COMMAND}.wrench", along, _FORCE, "N")
    named = np.array([f"no force {DIRECTIONS[i]}" for i in lost[at]], dtype=object)
    same = np.array([told.text("constraint")[i] for i in at], dtype=object) == named
    ledger.require(f"{_ABORT}: constraint", "the lost direction", steps[at],
                   f"{GOVERNOR_STATUS}.constraint", same)  # fmt: skip
    least = np.where(told.slack_of(at) == 0.0, Answer.OPTIMAL, Answer.LEAST_VIOLATION)
    kept = (status[at] == least) & (told.slack_of(at) <= 0.0)
    ledger.require(f"{_ABORT}: status", "that of the slack", steps[at],
                   f"{GOVERNOR_STATUS}.status", kept)  # fmt: skip
