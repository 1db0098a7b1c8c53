"""Audit of deadlocks, and of the passages that lead out of them."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.vehicles.formation.audit.graph import NO_WAY, Ways
from spacecraft_gnc.vehicles.formation.audit.told import Told
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.signals import GOVERNOR_STATUS, REFERENCE

_DEADLOCKED: Final = "deadlocked: parked in another formation"
_HELD: Final = "shifts held = the last ones"
_WAYPOINT: Final = "passage: waypoint = the shifts"
_PASSAGE: Final = "passage: begins at a deadlock, nearer with each formation"
_LEFT: Final = "passage: transitions left = a search of all parked formations"
PATIENCE: Final = 5
"""Steps at rest under unchanged, unequal shifts after which there is a deadlock."""


def audit_deadlocks(told: Told, ways: Ways, ledger: Ledger) -> None:
    """Check deadlocks, passages, and shifts that are said to be held."""
    checks = _Deadlocks(told, ledger)
    checks.audit_held()
    checks.audit_conclusion()
    checks.audit_passages()
    checks.audit_left(ways)


class _Deadlocks:
    """What the governor told of deadlocks."""

    def __init__(self, told: Told, ledger: Ledger) -> None:
        self.told, self.ledger, self.steps = told, ledger, told.steps
        self.status, self.left = told.field("status"), told.field("passages_left")
        self.deadlocked = told.field("deadlocked") == 1.0
        self.resolves = told.evidence.scenario.governor.resolves_deadlocks
        self.same = self._kept(told.shifts)
        self.same_craft = self._kept(told.lost)

    def _kept(self, rows: NDArray[Any]) -> NDArray[np.bool_]:
        """Return at which steps a row is that of the step right before."""
        kept = np.append(False, (rows[1:] == rows[:-1]).all(axis=1))
        return np.asarray(kept & self.told.follows)

    @cached_property
    def at_rest(self) -> NDArray[np.bool_]:
        """At which steps all craft are where they are to be."""
        found = self.told.field("error") < self.told.evidence.scenario.governor.formed_error
        return np.asarray(found)

    def audit_held(self) -> None:
        """Check that shifts said to be held are the last ones."""
        held = self.status == Answer.HELD
        if held.any():
            where = f"{REFERENCE}.shift"
            self.ledger.require(_HELD, "the same", self.steps[held], where, self.same[held])
        else:
            self.ledger.skip(_HELD, "at no step")

    def audit_conclusion(self) -> None:
        """Conclude from errors and shifts whether there is a deadlock, and until when.

        With a way out it lasts until the desired formation is attained; it is told of while the
        shifts differ.
        """
        equal = self.told.equal
        parked, stuck, made = 0, False, np.zeros(len(self.steps), dtype=bool)
        for i in range(len(self.steps)):
            if not self.same_craft[i]:  # the first step, after a gap, or after a loss
                parked = 0
                stuck = bool(self.deadlocked[i - 1]) and i > 0 and not self.told.follows[i]
            if stuck and self._has_way(i):
                stuck = not (equal[i] and self.at_rest[i])
            else:
                parked = parked + 1 if self.same[i] and self.at_rest[i] and not equal[i] else 0
                stuck = parked >= PATIENCE
            made[i] = stuck and not equal[i]
        where = f"{GOVERNOR_STATUS}.deadlocked"
        kept = self.deadlocked == made
        self.ledger.require(_DEADLOCKED, f"{PATIENCE} steps at rest", self.steps, where, kept)

    def _has_way(self, i: int) -> bool:
        return bool(self.resolves and self.left[i] != NO_WAY and self.left[i - 1] != NO_WAY)

    def audit_passages(self) -> None:
        """Check waypoints, that passages begin at a deadlock, and that they come nearer."""
        passes = self.status == Answer.PASSAGE
        waypoints = self.told.by_craft("waypoint")
        same = (waypoints == self.told.shifts).all(axis=1)
        kept = np.where(passes, same, np.isnan(waypoints).all(axis=1))
        where = f"{GOVERNOR_STATUS}.waypoint"
        self.ledger.require(_WAYPOINT, "the same", self.steps, where, kept)
        where = f"{GOVERNOR_STATUS}.passages_left"
        kept = self.deadlocked | (self.left == 0.0)
        self.ledger.require(f"{_WAYPOINT}: left", "none without", self.steps, where, kept)
        if not passes.any():
            self.ledger.skip(_PASSAGE, "there was none")
            return
        before = np.roll(np.arange(len(self.steps)), 1)
        left, last = self.left, self.left[before]
        begun = (self.deadlocked & (left != NO_WAY))[before] | passes[before]
        begun &= self.told.field("formed")[before] == 0.0
        nearer = np.where(self.same, left == last, left < np.maximum(last, 1.0))
        kept = ((begun & nearer & self.same_craft) | ~self.told.follows)[passes]
        kept[0] &= self.told.follows[passes][0]
        self.ledger.require(_PASSAGE, "as defined", self.steps[passes], where, kept)

    def audit_left(self, ways: Ways) -> None:
        """Compare the transitions left of a deadlock with a search of the audit's own."""
        at = np.flatnonzero(self.deadlocked)
        if not at.size:
            self.ledger.skip(_LEFT, "there was no deadlock")
            return
        where = f"{GOVERNOR_STATUS}.passages_left"
        kept = np.array([self._is_left(ways, i) for i in at.tolist()])
        self.ledger.require(_LEFT, "up to rounding", self.steps[at], where, kept)

    def _is_left(self, ways: Ways, i: int) -> bool:
        if not self.resolves:
            return bool(self.left[i] == NO_WAY)
        lost, told = self.told.lost[i], float(self.left[i])
        return ways.of(lost).holds(ways.number(self.told.shifts[i], lost), told)
