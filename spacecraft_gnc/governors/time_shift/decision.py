"""Decision of the time shift governor at one step."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

from spacecraft_gnc.governors.time_shift.margins import Margin
from spacecraft_gnc.governors.time_shift.prediction import Mask
from spacecraft_gnc.governors.time_shift.problem import Integers


class Answer(IntEnum):
    """Where the shifts come from."""

    OPTIMAL = 0
    """The admissible combination of least cost."""
    HELD = 1
    """None is admissible: the last shifts."""
    LONGEST_KEPT = 2
    """None is admissible after the loss of a craft: that which keeps every constraint longest."""
    LEAST_VIOLATING = 3
    """Nor can each craft keep its delta-v, or nothing can be held: that of the least excess."""
    PASSAGE = 4
    """On the way out of a deadlock, by way of other parked formations."""


class TimeShiftDecision(NamedTuple):
    """Shifts of one step, and the reason."""

    step: int
    shifts: Integers
    """(n,) tau [samples], 0 to p - 1; of a lost craft its last one."""
    answer: Answer
    shift_cost: float
    """W of the shifts."""
    state_cost: float
    """Omega of the shifts."""
    n_admissible: int
    """Combinations that keep every constraint."""
    n_candidates: int
    """Combinations there are."""
    margin: Margin | None
    """Constraint with the least room along the prediction under the shifts; negative share: it is
    exceeded, by this much. None with all craft lost."""
    refused: Margin | None
    """Constraint that the cheapest combination of all would exceed the most; None if the shifts
    are that combination."""
    error: float
    """Largest distance of a craft from its commanded position, lost ones left out [m]."""
    formed: bool
    """Whether all shifts are equal and the error is small, lost craft left out."""
    deadlocked: bool
    """Whether the craft are parked in another formation than the desired one."""
    waypoint: Integers
    """(n,) shifts of the formation that the passage leads to next; empty outside a passage."""
    waypoints_left: int
    """Formations of the passage still to reach, the desired one included; -1: there is no
    passage to be found; 0 outside one."""
    lost: Mask
    """(n,) craft that no longer answer."""
    response: tuple[float, ...]
    """Share of the last delta-v that each craft is measured to have given; NaN: too small to
    tell."""

    @property
    def cost(self) -> float:
        """J = W + Omega."""
        return self.shift_cost + self.state_cost

    @property
    def is_admissible(self) -> bool:
        """Whether every constraint is kept along the prediction."""
        return self.margin is None or self.margin.is_kept


NO_RESPONSE = math.nan
"""Response of a craft of which too little was asked to tell."""
