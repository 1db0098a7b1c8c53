"""Audit of the governor: what the craft are to track, and how it was chosen."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from spacecraft_gnc.audit.evidence import Evidence, Progress
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.vehicles.formation.audit.conclusions import audit_formed, audit_losses
from spacecraft_gnc.vehicles.formation.audit.equations import ellipse, samples
from spacecraft_gnc.vehicles.formation.audit.graph import Ways
from spacecraft_gnc.vehicles.formation.audit.loop import Loop
from spacecraft_gnc.vehicles.formation.audit.passages import audit_deadlocks
from spacecraft_gnc.vehicles.formation.audit.shifts import ADMISSIBLE, audit_shifts
from spacecraft_gnc.vehicles.formation.audit.told import Told
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.signals import GOVERNOR_STATUS, REFERENCE, STATE

_LAW: Final = "law of the governor"
_REFERENCE: Final = "reference = natural ellipse, closed form"
_PARTS: Final = (("position", slice(3), "m"), ("velocity", slice(3, None), "m/s"))
_ROUNDING: Final = 1e-12


def audit_governor(evidence: Evidence, ledger: Ledger, progress: Progress | None) -> None:
    """Check every decision of a law of this vehicle."""
    kind = evidence.scenario.governor.governor
    steps = evidence.common(GOVERNOR_STATUS, STATE, REFERENCE)
    if kind not in ("none", "time_shift"):
        ledger.skip(ADMISSIBLE, f"governor {kind} is a plug-in's")
        return
    if not steps.size:
        ledger.skip(ADMISSIBLE, f"{GOVERNOR_STATUS} was not recorded")
        return
    told = Told(evidence, steps)
    _audit_law(told, ledger)
    _audit_reference(told, ledger)
    with np.errstate(over="ignore", invalid="ignore"):  # a damaged number fails, whatever its size
        audit_formed(told, ledger)
        if kind == "none":
            still = (told.shifts == 0).all(axis=1)
            ledger.require("shifts: none", "0", steps, f"{REFERENCE}.shift", still)
            ledger.skip(ADMISSIBLE, "governor none chooses nothing")
            return
        loop = Loop.of(evidence.scenario)
        ways = Ways(loop)
        audit_shifts(told, loop, ways, ledger, progress)
        audit_deadlocks(told, ways, ledger)
        audit_losses(told, ledger)


def _audit_law(told: Told, ledger: Ledger) -> None:
    """Compare law and status with the scenario."""
    kind = told.evidence.scenario.governor.governor
    same = np.array([law == kind for law in told.text("law")])
    ledger.require(_LAW, "the scenario's", told.steps, f"{GOVERNOR_STATUS}.law", same)
    passed = told.field("status") == Answer.PASSED
    where = f"{GOVERNOR_STATUS}.status"
    ledger.require(_LAW, "the scenario's", told.steps, where, passed == (kind == "none"))


def _audit_reference(told: Told, ledger: Ledger) -> None:
    """Compare each commanded state with that of the natural ellipse at its place."""
    scenario = told.evidence.scenario
    places = told.steps[:, None] + np.asarray(scenario.governor.phase) + told.shifts
    p = samples(scenario.plant, scenario.period)
    made = ellipse(scenario.plant, 2.0 * math.pi / p * (places % p))
    for name, columns, unit in _PARTS:
        off = (told.reference - made)[..., columns]
        limit = _ROUNDING * np.abs(made[..., columns]).max()
        where = f"{REFERENCE}.{name}"
        ledger.bound(f"{_REFERENCE}: {name}", told.steps, where, off, float(limit), unit)
