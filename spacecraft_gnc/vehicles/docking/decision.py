"""Decision of a governor of the docking vehicle: the reference, and how it was chosen."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.state import RelativeReference


class Answer(IntEnum):
    """How the program of a step ended (equal to PeriodicGovernorStatus.msg)."""

    OPTIMAL = 0
    INFEASIBLE = 1
    """No reference is admissible: the last admissible one is held."""
    NOT_SOLVED = 2
    LEAST_VIOLATION = 3
    """No reference is admissible: the one that misses the constraints least."""
    PASSED = 4
    """There is no governor: the wish is the reference."""


class Phase(IntEnum):
    """What the governor is after (equal to PeriodicGovernorStatus.msg)."""

    DOCKING = 0
    ABORTING = 1
    """A thruster is lost: on the way to the hold point."""
    HOLDING = 2
    """At the hold point for good."""


class Active(NamedTuple):
    """A constraint that keeps the reference from the wish."""

    name: str
    row: int
    """In the set of the step."""
    ahead: int
    """In how many steps it would be met; -1: in steady state."""
    multiplier: float


class DockingDecision(NamedTuple):
    """Reference of one control step, and how it was chosen."""

    reference: RelativeReference
    law: str
    answer: Answer
    phase: Phase
    wish: Array
    """(6,) that the reference is to come near."""
    slack: float = math.inf
    """Smallest slack of a row of the admissible set, as a share of the row's room where the port is
    docked; negative: outside; infinite: there is no set."""
    constraint: str = ""
    constraint_ahead: int = -1
    active: tuple[Active, ...] = ()
    iterations: int = 0
    residual: float = math.nan
    """Largest violation of the optimality conditions, scaled; NaN: nothing was solved."""
    lost_thruster: int = -1
    """Index of `state.DIRECTIONS` concluded lost; -1: none."""
    response_error: float = math.nan
    """Change of velocity over the last step less the one foretold, largest component [m/s]."""
    decision_time: float = math.nan
    """Wall time [s]."""


def passed(wish: Array) -> DockingDecision:
    """Return the decision of the law ``none``."""
    return DockingDecision(
        RelativeReference.of(wish), "none", Answer.PASSED, Phase.DOCKING, np.asarray(wish)
    )
