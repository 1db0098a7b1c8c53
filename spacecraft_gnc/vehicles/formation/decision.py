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
    LEAST_VIOLATION = 2
    """No shifts are admissible: those that miss the constraints least."""
    PASSAGE = 3
    """Those of the next parked formation on the way out of a deadlock."""
    PASSED = 4
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
    """Candidates that keep every constraint."""
    n_candidates: int = 0
    constraint: str = ""
    """The one with the least room along the prediction; empty: there is none."""
    margin: float = math.inf
    """Its room as a share of its limit; negative: violated; infinite: there is none."""
    constraint_ahead: int = -1
    """In how many steps it is met; -1: there is none."""
    deadlocked: bool = False
    """Whether the craft are parked in a formation that is not the desired one."""
    waypoint: NDArray[np.int64] = np.empty(0, dtype=np.int64)
    """(n,) shifts of the parked formation that is passed next; empty: none."""
    passages_left: int = 0
    """Parked formations still to be passed, the desired one included."""
    lost: NDArray[np.bool_] = np.empty(0, dtype=bool)
    """(n,) craft concluded lost."""
    response_error: Array = np.empty(0)
    """(n,) change of velocity over the last step less the one foretold [m/s]."""
    formed: bool = False
    """Whether the desired formation is attained: equal shifts, and small position errors."""
    decision_time: float = math.nan
    """Wall time [s]."""

    @property
    def largest_response_error(self) -> float:
        """Largest `response_error` of a craft [m/s]; NaN: none is known."""
        return (
            float(np.max(self.response_error, initial=-math.inf))
            if self.response_error.size
            else math.nan
        )
