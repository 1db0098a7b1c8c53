"""Room that the constraints leave along a prediction, and the words in which it is told."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.audit.candidates import Candidates
from spacecraft_gnc.vehicles.formation.audit.loop import Loop

_WORDS: Final = re.compile(
    r"(?P<name>delta-v|separation|angle between actual and commanded direction) of "
    r"(?P<craft>.+?): (?P<value>\S+) (?P<unit>\S+), limit (?P<limit>\S+) (?P=unit), "
    r"(?:now|in (?P<ahead>\S+) steps)$"
)
_UNITS: Final = {"delta-v": "m/s", "separation": "m", "angle": "deg"}
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


def rooms_of(made: Candidates, shifts: NDArray[np.int64]) -> tuple[Room, ...]:
    """Return every constraint along the prediction of one candidate (n,)."""
    checks = made.limits.loop.checks
    return tuple(
        Room(name, which, shares, checks if len(which) > 1 else 1)
        for name, which, shares in made.limits.along(shifts)
    )


def worst_of(rooms: Sequence[Room]) -> float:
    """Return the largest share by which one of them is exceeded; -inf: there is none."""
    return max((room.share for room in rooms), default=-math.inf)


def names_the_least(words: str, rooms: Sequence[Room], loop: Loop, craft: Sequence[str]) -> bool:
    """Tell whether words name the constraint with the least room, when, and its numbers."""
    said, worst = _WORDS.match(words), worst_of(rooms)
    if said is None:
        return not words and not rooms
    told = said["craft"].split(" and ")
    which = tuple(i for i, name in enumerate(craft) if name in told)
    for room in rooms:
        if said["name"].startswith(room.name) and which == room.craft:
            then = room.at(float(said["ahead"] or 0.0))
            least = worst - loop.slack * (1.0 + abs(worst))
            return _in_numbers(said, room, loop) and then >= least
    return False


def _in_numbers(said: re.Match[str], room: Room, loop: Loop) -> bool:
    """Tell whether unit, limit and value are as told, to four digits."""
    limit = loop.limit(room.name)
    sense = -1.0 if room.name == "separation" else 1.0
    value = limit * (1.0 + sense * room.share)
    pairs = (float(said["limit"]), limit), (float(said["value"]), value)
    near = all(abs(one - other) <= _DIGITS * max(limit, abs(other)) for one, other in pairs)
    return near and said["unit"] == _UNITS[room.name]


def when(ahead: float) -> str:
    """Return the end of words about something in so many steps; none: -1."""
    return {0.0: "now", -1.0: ""}.get(ahead, f"in {ahead:g} steps")
