"""Audit of the shifts of every step: all candidates are enumerated again."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.audit.enumerated import Found, enumerate_step
from spacecraft_gnc.vehicles.formation.audit.graph import Ways
from spacecraft_gnc.vehicles.formation.audit.loop import Loop
from spacecraft_gnc.vehicles.formation.audit.rooms import Room, names_the_least, when, worst_of
from spacecraft_gnc.vehicles.formation.audit.told import Told
from spacecraft_gnc.vehicles.formation.craft import craft
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.signals import GOVERNOR_STATUS, REFERENCE

ADMISSIBLE: Final = "shifts: admissible, all constraints predicted"
_OPTIMAL: Final = "shifts: no admissible candidate costs less"
_COST: Final = "cost of the shifts = W + Omega"
_COUNT: Final = "candidates: admissible ones counted"
_ROOM: Final = "constraint with the least room"
_REFUSED: Final = "constraint that the cheapest candidate would exceed"
_HELD: Final = "shifts held: no candidate is admissible"
_LONGEST: Final = "shifts: no candidate keeps the limits longer"
_LEAST: Final = "shifts: no candidate exceeds a limit by less"
_ANSWER: Final = "answer where no candidate is admissible"
_NEAREST: Final = "passage: no admissible candidate is nearer, or costs less"
_GOES_ON: Final = "passage: goes on until the formation is attained"
_NONE_ADMISSIBLE: Final = (Answer.HELD, Answer.LONGEST_KEPT, Answer.LEAST_VIOLATING)


def audit_shifts(
    told: Told, loop: Loop, ways: Ways, ledger: Ledger, progress: Progress | None
) -> None:
    """Check the shifts of steps with a governor that chooses."""
    within = np.asarray((told.shifts < loop.p).all(axis=1))
    where = f"{REFERENCE}.shift"
    ledger.require("shifts: below a period", f"< {loop.p}", told.steps, where, within)
    usable = np.isfinite(told.states).all(axis=(1, 2)) & within
    at = np.flatnonzero(usable)
    found: list[Found] = []
    for count, i in enumerate(at.tolist()):
        found.append(enumerate_step(told, loop, ways, i))
        if progress is not None:
            progress(count + 1, len(at))
    if found:
        _Entries(told, loop, ledger, at, found).enter()
    else:
        ledger.skip(ADMISSIBLE, "no step has a state and shifts")


class _Entries:
    """Comparison of what was told with what was found, at rows ``at`` of the steps."""

    def __init__(
        self, told: Told, loop: Loop, ledger: Ledger, at: NDArray[np.int64], found: list[Found]
    ) -> None:
        self.told, self.ledger, self.at, self.found = told, ledger, at, found
        self.steps = told.steps[at]
        self.status = told.field("status")[at]
        self.names = craft(told.evidence.scenario)
        self.loop, self.slack = loop, loop.slack

    def _of(self, name: str) -> Array:
        return np.array([getattr(each, name) for each in self.found], dtype=np.float64)

    def _told(self, name: str) -> Array:
        return self.told.field(name)[self.at]

    def enter(self) -> None:
        """Enter every check."""
        self._costs()
        self._counts()
        self._chosen()
        self._goes_on()
        self._named("constraint", "margin", "rooms")
        self._named("refused", "refused_margin", "wish")

    def _costs(self) -> None:
        W, Omega = self._of("shift_cost"), self._of("state_cost")
        for name, cost in (("shift_cost", W), ("state_cost", Omega), ("cost", W + Omega)):
            off = self._told(name) - cost
            where = f"{GOVERNOR_STATUS}.{name}"
            self.ledger.bound(_COST, self.steps, where, off, self.slack * (1.0 + W + Omega))

    def _counts(self) -> None:
        counted, lost = self._told("n_admissible"), self.told.lost[self.at]
        kept = (self._of("certain") <= counted) & (counted <= self._of("possible"))
        where = f"{GOVERNOR_STATUS}.n_admissible"
        self.ledger.require(_COUNT, "up to rounding", self.steps, where, kept)
        where = f"{GOVERNOR_STATUS}.n_candidates"
        kept = self._told("n_candidates") == float(self.loop.p) ** (~lost).sum(axis=1)
        self.ledger.require(_COUNT, "up to rounding", self.steps, where, kept)

    def _chosen(self) -> None:
        """Check the choice against its definition."""
        steps, status, share, where = self.steps, self.status, self._of("share"), REFERENCE.name
        chosen = np.isin(status, [Answer.OPTIMAL, Answer.PASSAGE])
        exceeded = np.maximum(share, 0.0)
        self.ledger.bound(ADMISSIBLE, steps[chosen], where, exceeded[chosen], self.slack)
        best = status == Answer.OPTIMAL
        saved = self._of("shift_cost") + self._of("state_cost") - self._of("cheapest")
        limit = self.slack * (1.0 + self._of("state_cost"))
        more = np.maximum(saved, 0.0)[best]
        self.ledger.bound(_OPTIMAL, steps[best], f"{where}.shift", more, limit[best])
        none = np.isin(status, _NONE_ADMISSIBLE)
        kept = self._of("certain")[none] == 0.0
        if none.any():
            self.ledger.require(_HELD, "none", steps[none], f"{GOVERNOR_STATUS}.status", kept)
        else:
            self.ledger.skip(_HELD, "at every step some were")
        self._nearest()
        self._least_violating(share)
        self._longest_kept()
        self._after_loss()

    def _nearest(self) -> None:
        passes = self.status == Answer.PASSAGE
        if not passes.any():
            self.ledger.skip(_NEAREST, "there was none")
            return
        where, kept = f"{REFERENCE}.shift", self._of("nearest")[passes] == 1.0
        self.ledger.require(_NEAREST, "up to rounding", self.steps[passes], where, kept)

    def _goes_on(self) -> None:
        """Check that a passage goes on where the last shifts of a known way are admissible."""
        told, before = self.told, self.at - 1
        answer, way = told.field("status")[before], told.field("passages_left")[before] > 0.0
        formed, same = told.field("formed")[before] == 1.0, told.lost[self.at] == told.lost[before]
        begun = way | ((answer == Answer.PASSAGE) & ~formed)
        goes_on = begun & same.all(axis=1) & (self._of("last") <= -self.slack)
        if not goes_on.any():
            self.ledger.skip(_GOES_ON, "there was none")
            return
        where, kept = f"{GOVERNOR_STATUS}.status", self.status[goes_on] == Answer.PASSAGE
        self.ledger.require(_GOES_ON, "as defined", self.steps[goes_on], where, kept)

    def _least_violating(self, share: Array) -> None:
        at = self.status == Answer.LEAST_VIOLATING
        if not at.any():
            self.ledger.skip(_LEAST, "no step needed it")
            return
        off = np.maximum(share - np.maximum(self._of("least"), 0.0), 0.0)[at]
        self.ledger.bound(_LEAST, self.steps[at], f"{REFERENCE}.shift", off, self.slack)

    def _longest_kept(self) -> None:
        at = np.flatnonzero(self.status == Answer.LONGEST_KEPT)
        if not at.size:
            self.ledger.skip(_LONGEST, "no step needed it")
            return
        cost = self._of("shift_cost") + self._of("state_cost")
        kept = []
        for row in at.tolist():
            lasting = self.found[row].lasting
            cheapest = cost[row] <= lasting.cheapest + self.slack * (1.0 + cost[row])
            longer = lasting.chosen > lasting.certain
            kept.append(lasting.chosen >= lasting.certain and (longer or cheapest))
        where = f"{REFERENCE}.shift"
        self.ledger.require(_LONGEST, "up to rounding", self.steps[at], where, np.array(kept))

    def _after_loss(self) -> None:
        """Check the answer where none is admissible: held, or after a loss by how long they last.

        Shifts that keep the limits for half a period at least leave the next steps a way round.
        """
        at = np.flatnonzero(np.isin(self.status, _NONE_ADMISSIBLE))
        if not at.size:
            self.ledger.skip(_ANSWER, "at every step some were")
            return
        lost = np.asarray(self.told.lost[self.at].any(axis=1))
        half = self.loop.p // 2 * self.loop.checks
        kept = []
        for row in at.tolist():
            lasting, answer = self.found[row].lasting, self.status[row]
            expected = [Answer.HELD if self.steps[row] else Answer.LEAST_VIOLATING]
            if lost[row]:
                expected = [Answer.LONGEST_KEPT] if lasting.possible >= half else []
                expected += [Answer.LEAST_VIOLATING] if lasting.certain < half else []
            kept.append(answer in expected)
        where = f"{GOVERNOR_STATUS}.status"
        self.ledger.require(_ANSWER, "as defined", self.steps[at], where, np.array(kept))

    def _named(self, name: str, share: str, mine: str) -> None:
        """Compare the constraint that is told, its room and its numbers in words."""
        told, words, ahead = self._told(share), self.told.text(name), self._told("constraint_ahead")
        kept, off = np.ones(len(self.at), dtype=bool), np.zeros(len(self.at))
        for row, (i, found) in enumerate(zip(self.at.tolist(), self.found, strict=True)):
            rooms: tuple[Room, ...] = getattr(found, mine)
            if name == "refused" and not words[i]:
                kept[row] = found.saved <= self.slack * (1.0 + found.state_cost)
                off[row] = 0.0 if told[row] == math.inf else math.inf
                continue
            worst = worst_of(rooms)
            off[row] = 0.0 if told[row] == -worst else told[row] + worst
            kept[row] = names_the_least(words[i], rooms, self.loop, self.names)
            kept[row] &= (
                found.saved > 0.0 if name == "refused" else words[i].endswith(when(ahead[row]))
            )
        check = _ROOM if name == "constraint" else _REFUSED
        where = f"{GOVERNOR_STATUS}.{share}"
        size = 1.0 + np.abs(np.where(np.isfinite(told), told, 0.0))
        self.ledger.bound(check, self.steps, where, off, self.slack * size)
        where = f"{GOVERNOR_STATUS}.{name}"
        self.ledger.require(f"{check}: in words", "as found", self.steps, where, kept)
