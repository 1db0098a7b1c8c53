"""Audit of the shifts of every step: all candidates are enumerated again."""

from __future__ import annotations

import math
import re
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Progress
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.audit.candidates import Candidates, Loop
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
_LEAST: Final = "shifts: no candidate exceeds a limit by less"
_WORDS: Final = re.compile(
    r"(?P<name>delta-v|separation|angle between actual and commanded direction) of "
    r"(?P<craft>.+?): (?P<value>\S+) (?P<unit>\S+), limit (?P<limit>\S+) \S+, "
    r"(?:now|in (?P<ahead>\S+) steps)$"
)
_DIGITS: Final = 1.1e-3
"""Share by which numbers of four digits may differ."""


class Room(NamedTuple):
    """A constraint along the prediction of one candidate."""

    name: str
    craft: tuple[int, ...]
    shares: Array
    """(r,) by which its limit is exceeded at each instant."""
    checks: int
    """Instants in a control step."""

    @property
    def share(self) -> float:
        """The largest."""
        return float(self.shares.max())

    def at(self, ahead: float) -> float:
        """Return that of an instant [control steps]; NaN where there is none."""
        instant = round(ahead * self.checks)
        return float(self.shares[instant]) if 0 <= instant < len(self.shares) else math.nan


class Found(NamedTuple):
    """What the enumeration of one step found."""

    shift_cost: float
    state_cost: float
    share: float
    """Worst of the chosen shifts."""
    cheapest: float
    """Cost of the cheapest candidate that is admissible beyond rounding; infinite: none."""
    certain: int
    """Candidates that are admissible beyond rounding."""
    possible: int
    """Those that may be."""
    least: float
    """Least worst share of all candidates; NaN: it is positive, or not looked for."""
    rooms: tuple[Room, ...]
    """Of the chosen shifts."""
    wish: tuple[Room, ...]
    """Of the cheapest candidate of all."""
    gain: float
    """By how much that costs less than the chosen shifts."""


def audit_shifts(told: Told, ledger: Ledger, progress: Progress | None) -> None:
    """Check the shifts of steps with a governor that chooses."""
    loop = Loop.of(told.evidence.scenario)
    within = np.asarray((told.shifts < loop.p).all(axis=1))
    where = f"{REFERENCE}.shift"
    ledger.require("shifts: below a period", f"< {loop.p}", told.steps, where, within)
    usable = np.isfinite(told.states).all(axis=(1, 2)) & within
    at = np.flatnonzero(usable)
    found: list[Found] = []
    for count, i in enumerate(at.tolist()):
        found.append(_enumerate(told, loop, i))
        if progress is not None:
            progress(count + 1, len(at))
    if found:
        _Entries(told, loop, ledger, at, found).enter()
    else:
        ledger.skip(ADMISSIBLE, "no step has a state and shifts")


def _enumerate(told: Told, loop: Loop, i: int) -> Found:
    """Return what is true of one step."""
    step, shifts, lost = int(told.steps[i]), told.shifts[i], told.lost[i]
    answer = told.field("status")[i]
    slack = loop.slack
    most = math.inf if answer == Answer.LEAST_VIOLATION else slack
    made = Candidates.at(loop, step, told.states[i], lost, shifts, most)
    certain, possible = made.worst <= -slack, made.worst <= slack
    open_to = np.where(np.isinf(made.worst) & _fixed(lost, shifts, loop.p), np.inf, made.cost)
    wish = np.array(np.unravel_index(open_to.argmin(), open_to.shape))
    rooms = _rooms(made, shifts)
    costs = made.costs(shifts)
    return Found(
        *costs,
        max(room.share for room in rooms) if rooms else -math.inf,
        float(made.cost[certain].min(initial=math.inf)),
        int(certain.sum()),
        int(possible.sum()),
        float(made.worst.min()) if most == math.inf else math.nan,
        rooms,
        _rooms(made, wish),
        sum(costs) - float(open_to.min()),
    )


def _fixed(lost: NDArray[np.bool_], shifts: NDArray[np.int64], p: int) -> NDArray[np.bool_]:
    """Return which of all combinations give a lost craft another shift than it has."""
    n = len(shifts)
    other = np.zeros((p,) * n, dtype=bool)
    for i in np.flatnonzero(lost).tolist():
        shape = [1] * n
        shape[i] = p
        other |= (np.arange(p) != shifts[i]).reshape(shape)
    return other


def _rooms(made: Candidates, shifts: NDArray[np.int64]) -> tuple[Room, ...]:
    checks = made.limits.loop.checks
    return tuple(
        Room(name, which, shares, checks if len(which) > 1 else 1)
        for name, which, shares in made.limits.along(shifts)
    )


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
        passes = (self.status == Answer.PASSAGE) & (counted == -1.0)
        kept = (self._of("certain") <= counted) & (counted <= self._of("possible"))
        where = f"{GOVERNOR_STATUS}.n_admissible"
        self.ledger.require(_COUNT, "up to rounding", self.steps, where, kept | passes)
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
        none = np.isin(status, [Answer.HELD, Answer.LEAST_VIOLATION])
        kept = self._of("certain")[none] == 0.0
        if none.any():
            self.ledger.require(_HELD, "none", steps[none], f"{GOVERNOR_STATUS}.status", kept)
        else:
            self.ledger.skip(_HELD, "at every step some were")
        self._least_violation(share)

    def _least_violation(self, share: Array) -> None:
        at = self.status == Answer.LEAST_VIOLATION
        if not at.any():
            self.ledger.skip(_LEAST, "no step needed it")
            return
        off = np.maximum(share - np.maximum(self._of("least"), 0.0), 0.0)[at]
        self.ledger.bound(_LEAST, self.steps[at], f"{REFERENCE}.shift", off, self.slack)

    def _named(self, name: str, share: str, mine: str) -> None:
        """Compare the constraint that is told, its room and its numbers in words."""
        told, words, ahead = self._told(share), self.told.text(name), self._told("constraint_ahead")
        kept, off = np.ones(len(self.at), dtype=bool), np.zeros(len(self.at))
        for row, (i, found) in enumerate(zip(self.at.tolist(), self.found, strict=True)):
            rooms: tuple[Room, ...] = getattr(found, mine)
            if name == "refused" and not words[i]:
                kept[row] = found.gain <= self.slack * (1.0 + found.state_cost)
                off[row] = 0.0 if told[row] == math.inf else math.inf
                continue
            worst = max((room.share for room in rooms), default=-math.inf)
            off[row] = 0.0 if told[row] == -worst else told[row] + worst
            kept[row] = self._matches(words[i], rooms, worst) and (
                name == "refused" or words[i].endswith(_when(ahead[row]))
            )
        check = _ROOM if name == "constraint" else _REFUSED
        where = f"{GOVERNOR_STATUS}.{share}"
        size = 1.0 + np.abs(np.where(np.isfinite(told), told, 0.0))
        self.ledger.bound(check, self.steps, where, off, self.slack * size)
        where = f"{GOVERNOR_STATUS}.{name}"
        self.ledger.require(f"{check}: in words", "as found", self.steps, where, kept)

    def _matches(self, words: str, rooms: tuple[Room, ...], worst: float) -> bool:
        """Tell whether words name a constraint with the least room, when, and its numbers."""
        said = _WORDS.match(words)
        if said is None:
            return False
        told = said["craft"].split(" and ")
        which = tuple(i for i, name in enumerate(self.names) if name in told)
        for room in rooms:
            if said["name"].startswith(room.name) and which == room.craft:
                then = room.at(float(said["ahead"] or 0.0))
                return self._in_numbers(said, room) and then >= worst - self.slack * (
                    1.0 + abs(worst)
                )
        return False

    def _in_numbers(self, said: re.Match[str], room: Room) -> bool:
        """Tell whether limit and value are as told, to four digits."""
        limit = self.loop.limit(room.name)
        sense = -1.0 if room.name == "separation" else 1.0
        value = limit * (1.0 + sense * room.share)
        pairs = (float(said["limit"]), limit), (float(said["value"]), value)
        return all(abs(one - other) <= _DIGITS * max(limit, abs(other)) for one, other in pairs)


def _when(ahead: float) -> str:
    """Return the end of words about something in so many steps."""
    return "now" if ahead == 0.0 else f"in {ahead:g} steps"
