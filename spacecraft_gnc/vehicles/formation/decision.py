"""Decision of a governor of the formation: the states to track, and how they were chosen."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.state import FormationReference


class Answer(IntEnum):
    """How the shifts of a step were chosen (equal to TimeShiftStatus.msg)."""

    OPTIMAL = 0
    HELD = 1
    """No shifts are admissible: the last ones are held."""
    LONGEST_KEPT = 2
    """None are after the loss of a craft: those that keep every constraint longest."""
    LEAST_VIOLATING = 3
    """Nor can each craft keep its delta-v, or nothing can be held: those of the least excess."""
    PASSAGE = 4
    """On the way out of a deadlock, by way of other parked formations."""
    PASSED = 5
    """There is no governor: no shifts."""


class FormationDecision(NamedTuple):
    """States to track at one control step, and how they were chosen; n craft, m pairs."""

    reference: FormationReference
    law: str
    answer: Answer
    cost: float = math.nan
    """What the chosen shifts minimise; NaN: nothing was chosen by it."""
    shift_cost: float = math.nan
    """Its part W, which is 0 where all shifts are equal."""
    state_cost: float = math.nan
    """Its part Omega, of state errors and delta-v."""
    n_admissible: int = 0
    """Candidates that keep every constraint; -1: not counted."""
    n_candidates: int = 0
    constraint: str = ""
    """The one with the least room along the prediction, in words; empty: there is none."""
    margin: float = math.inf
    """Its room as a share of its limit; negative: exceeded; infinite: there is no limit."""
    constraint_ahead: float = -1.0
    """In how many steps it is met; -1: there is none."""
    refused: str = ""
    """The one that the cheapest candidate of all would exceed the most, in words; empty: that
    candidate is chosen."""
    refused_margin: float = math.inf
    """Its room as a share of its limit; infinite: there is none."""
    error: float = math.nan
    """Largest distance of a craft from its commanded position, lost ones left out [m]."""
    deadlocked: bool = False
    """Whether the craft are parked in a formation that is not the desired one."""
    waypoint: NDArray[np.int64] = np.empty(0, dtype=np.int64)
    """(n,) shifts of the parked formation that is passed next; empty: none."""
    passages_left: int = 0
    """Parked formations still to be passed, the desired one included; -1: no way was found."""
    lost: NDArray[np.bool_] = np.empty(0, dtype=bool)
    """(n,) craft concluded lost; empty: not watched."""
    response: Array = np.empty(0)
    """(n,) share of the last delta-v that each craft is measured to have given; NaN: too small to
    tell."""
    formed: bool = False
    """Whether the desired formation is attained: equal shifts, and small position errors."""
    decision_time: float = math.nan
    """Wall time [s]."""

    @property
    def watched(self) -> NDArray[np.bool_] | None:
        """`lost`; None: not watched."""
        return self.lost if self.lost.size else None
