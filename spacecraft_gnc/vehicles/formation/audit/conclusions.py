"""Audit of what the governor concludes from the states: formed, and which craft are lost."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.audit.equations import hill_map, mean_motion
from spacecraft_gnc.vehicles.formation.audit.motion import healthy
from spacecraft_gnc.vehicles.formation.audit.told import Told, of_craft
from spacecraft_gnc.vehicles.formation.signals import GOVERNOR_STATUS, STATE

_ERROR: Final = "error = largest distance from the commanded positions"
_FORMED: Final = "formed: shifts equal, error small"
_RESPONSE: Final = "response of each craft to its delta-v"
_LOST: Final = "craft concluded lost"
_TRUTH: Final = "no craft concluded lost that answers"
_ASKED, _HALF = 0.005, 0.5
"""Delta-v from which on a response can be told [m/s], and the least of a craft that answers."""
_ROUNDING: Final = 1e-8
"""Of a response: 1e4 m of a position, in rounding, are 1e-14 m/s of a delta-v."""


def audit_formed(told: Told, ledger: Ledger) -> None:
    """Check the error, and whether the formation is attained."""
    steps, lost = told.steps, told.lost
    apart = np.linalg.norm((told.states - told.reference)[..., :3], axis=-1)
    errors = np.where(lost, 0.0, apart).max(axis=1)
    reach = np.abs(told.states[..., :3]).max(axis=(1, 2))
    where = f"{GOVERNOR_STATUS}.error"
    ledger.bound(_ERROR, steps, where, told.field("error") - errors, 1e-12 * (1.0 + reach), "m")
    at_rest = errors < told.evidence.scenario.governor.formed_error
    where = f"{GOVERNOR_STATUS}.formed"
    made = at_rest & told.equal & ~lost.all(axis=1)
    ledger.require(_FORMED, "as defined", steps, where, told.field("formed") == made)


def audit_losses(told: Told, ledger: Ledger) -> None:
    """Measure the response of each craft, and conclude from it which are lost."""
    steps = told.steps
    given, asked = _responses(told)
    tells = asked >= _ASKED**2
    response = np.where(tells, given / np.where(tells, asked, 1.0), np.nan)
    where, found = f"{GOVERNOR_STATUS}.response", told.by_craft("response")
    off = np.where(np.isnan(found) & np.isnan(response), 0.0, found - response)
    ledger.bound(_RESPONSE, steps, where, off, _ROUNDING)
    before = np.roll(told.lost, 1, axis=0) & told.follows[:, None]
    made = before | (response < _HALF)
    unknown = ~told.follows & (steps > 0)  # what was concluded in a gap
    made[unknown] |= told.lost[unknown]
    where = f"{GOVERNOR_STATUS}.lost"
    told_lost = {where: told.by_craft("lost")}
    ledger.compare(_LOST, steps, told_lost, {where: made.astype(float)})
    _audit_truth(told, ledger)


def _responses(told: Told) -> tuple[Array, Array]:
    """Return given . asked and asked . asked (m, n) of the step before each; 0: not known."""
    evidence, scenario = told.evidence, told.evidence.scenario
    A = hill_map(mean_motion(scenario.plant), scenario.period)
    asked = of_craft(evidence.rows(STATE, "applied_delta_v", told.steps), told.n_craft)
    drift = np.roll(told.states, 1, axis=0) @ A.T
    change = (told.states - drift).reshape(-1, 6)
    given = np.linalg.lstsq(A[:, 3:], change.T)[0].T.reshape(asked.shape)
    known = told.follows[:, None]
    return (
        np.where(known, np.sum(given * asked, axis=-1), 0.0),
        np.where(known, np.sum(asked * asked, axis=-1), 0.0),
    )


def _audit_truth(told: Told, ledger: Ledger) -> None:
    """Require that what is concluded lost is lost in truth."""
    if not told.lost.any():
        ledger.skip(_TRUTH, "no craft was concluded lost")
        return
    at = told.lost.any(axis=1)
    answers = healthy(told.evidence.scenario, told.steps[at] - 1)
    kept = np.asarray(~(told.lost[at] & answers).any(axis=1))
    ledger.require(_TRUTH, "the truth", told.steps[at], f"{GOVERNOR_STATUS}.lost", kept)
