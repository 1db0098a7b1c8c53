"""A governor in trouble is told of once, with the constraint's name."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import GovernorDecision, Reference, State
from spacecraft_gnc.nodes._governor_watch import PATIENCE, GovernorWatch, Trouble

ZERO = np.zeros(3)
TARGET = np.eye(3)


def about_z(degrees: float) -> np.ndarray:
    return lie.exp(np.array([0.0, 0.0, math.radians(degrees)]))


class Flown:
    """A watch, and decisions for a body at rest at the reference unless told otherwise."""

    def __init__(self) -> None:
        self.watch = GovernorWatch(math.radians(0.1), 1e-3)
        self.step = -1

    def look(
        self, degrees: float, *, admissible: bool = True, off: float = 0.0, rate: float = 0.0
    ) -> Trouble | None:
        self.step += 1
        reference = Reference(about_z(degrees), ZERO, ZERO)
        decision = GovernorDecision(reference, 0.0, admissible, 0.01, "star", 20)
        state = State(self.step, about_z(degrees + off), ZERO)
        return self.watch.look(state, np.array([0.0, 0.0, rate]), decision, TARGET)

    def stay(self, steps: int, degrees: float, **how: float) -> list[Trouble]:
        found = [self.look(degrees, **how) for _ in range(steps)]
        return [trouble for trouble in found if trouble is not None]


@pytest.fixture
def flown() -> Flown:
    return Flown()


def test_a_reference_that_rests_away_from_the_target_is_stuck(flown: Flown) -> None:
    assert flown.stay(PATIENCE, 30.0) == []
    (trouble,) = flown.stay(3 * PATIENCE, 30.0)
    assert trouble.text == f"stuck 30 deg from the target: star, margin 0.01 (step {PATIENCE})"
    assert trouble.values["constraint"] == "star"
    assert trouble.values["target_error_deg"] == pytest.approx(30.0)


def test_what_moves_or_has_arrived_is_not(flown: Flown) -> None:
    assert flown.stay(3 * PATIENCE, 0.05) == []
    assert flown.stay(3 * PATIENCE, 30.0, off=0.2) == []
    assert flown.stay(3 * PATIENCE, 30.0, rate=2e-3) == []
    creeping = [flown.look(30.0 - 0.004 * k) for k in range(3 * PATIENCE)]
    assert creeping == [None] * (3 * PATIENCE)


def test_a_reference_that_cannot_be_held_is_told_once_an_episode(flown: Flown) -> None:
    trouble = flown.look(30.0, admissible=False)
    assert trouble is not None
    assert trouble.text.startswith("no reference keeps every constraint, not even the last one")
    assert trouble.text.endswith(": star, margin 0.01 rad (step 0)")
    assert trouble.values["trouble"] == "inadmissible"
    for _ in range(PATIENCE):  # an episode that flickers is one
        assert flown.look(30.0, admissible=False) is None
        assert flown.look(20.0, off=1.0) is None
    assert flown.stay(PATIENCE, 20.0, off=1.0) == []
    assert flown.look(30.0, admissible=False) is not None


def test_a_new_flight_is_told_anew(flown: Flown) -> None:
    assert flown.look(30.0, admissible=False) is not None
    flown.watch.reset()
    flown.step = -1
    assert flown.look(30.0, admissible=False) is not None
