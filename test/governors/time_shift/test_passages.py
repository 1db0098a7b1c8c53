"""The graph of parked formations, against an enumeration of every combination with plain NumPy."""

from __future__ import annotations

import dataclasses
import itertools
import math

import formations
import numpy as np
import pytest
from enumerated_shifts import enumerate_all

from spacecraft_gnc.governors.time_shift.choice import is_admissible
from spacecraft_gnc.governors.time_shift.passages import (
    NO_PASSAGE,
    Passages,
    is_searchable,
    passages,
)
from spacecraft_gnc.governors.time_shift.prediction import Predictor

P = 8
NO_LOSS = np.zeros(3, dtype=bool)


@pytest.fixture(scope="module")
def problem():
    return formations.problem(
        p=P, phases=(0, 3, 5), horizon=16, min_separation=700.0, max_angle=math.radians(70.0)
    )


def classes():
    return list(itertools.product(range(P), repeat=2))


def led_to(problem, parked):
    """Return the classes that one transition leads to from shifts (0, a, b), by enumeration."""
    reached, shifts = set(), np.array([0, *parked])
    for k in range(P):
        every = enumerate_all(problem, k, problem.commanded(k, shifts))
        if not every.admissible[tuple(shifts)]:
            return set()  # not a formation to park in
        found = np.argwhere(every.admissible)
        reached |= {((b - a) % P, (c - a) % P) for a, b, c in found.tolist()}
    return reached


def test_transitions_are_those_of_the_enumeration(problem):
    edges = {parked: led_to(problem, parked) for parked in classes()}
    far, border = {(0, 0): 0}, {(0, 0)}
    while border:
        border = {c for c in classes() if c not in far and edges[c] & border}
        far |= {c: max(far.values()) + 1 for c in border}
    searched = Passages(Predictor(problem), NO_LOSS)
    found = {c: searched.distance(np.array([0, *c])) for c in classes()}
    assert found == {c: far.get(c, NO_PASSAGE) for c in classes()}
    assert {0, 1, 2, 3, NO_PASSAGE} <= set(found.values())


def test_a_common_shift_makes_no_difference(problem):
    searched = Passages(Predictor(problem), NO_LOSS)
    for parked in classes():
        shifts = np.array([0, *parked])
        distances = {searched.distance((shifts + common) % P) for common in range(P)}
        assert len(distances) == 1


def test_a_lost_craft_is_left_out(problem):
    lost = np.array([False, True, False])
    searched = Passages(Predictor(problem), lost)
    assert len(searched.distances) == P
    assert searched.distance(np.array([2, 7, 2])) == 0
    assert searched.distance(np.array([0, 0, 1])) != 0


@pytest.mark.parametrize("place", [1, 6])
def test_passages_around_a_lost_craft_keep_away_from_it(problem, place):
    """Craft 2 drifts on the natural motion: shifts next to the desired ones are one step away."""
    lost, step = np.array([False, True, False]), 3
    shifts = np.array([0, (place - problem.phases[1]) % P, 0])
    states = problem.commanded(step, shifts)
    predictor = Predictor(problem)
    around = Passages(predictor, lost, predictor.predict(step, states, shifts, lost))
    found = {c: around.distance(np.array([c[0], shifts[1], c[1]])) for c in classes()}
    for a, b in classes():
        parked, reached, stays = np.array([a, shifts[1], b]), False, True
        for k in range(step, step + P):
            now = predictor.predict(k, problem.commanded(k, parked), parked, lost)
            stays = stays and is_admissible(now, parked)
            for common in range(P):
                reached = reached or is_admissible(now, np.array([common, shifts[1], common]))
        if not stays:
            assert found[a, b] == NO_PASSAGE
        elif a == b:
            assert found[a, b] == 0
        else:
            assert (found[a, b] == 1) == reached
    assert {0, NO_PASSAGE} <= set(found.values())
    assert max(found.values()) >= 1


def test_a_lost_craft_far_away_is_not_in_the_way(problem):
    lost, far = np.array([False, True, False]), np.zeros((3, 6))
    far[1, 1] = 1e7  # [m]
    predictor = Predictor(problem)
    predicted = predictor.predict(0, far, np.zeros(3, dtype=np.int64), lost)
    around, plain = Passages(predictor, lost, predicted), Passages(predictor, lost)
    assert around.is_whole
    assert len(around.distances) == P * P
    for a, b in classes():
        shifts = np.array([a, 0, b])
        assert around.distance(shifts) == plain.distance(shifts)


def test_graphs_too_large_are_not_searched():
    assert is_searchable(50, 3)
    assert not is_searchable(50, 4)
    assert not is_searchable(200, 3)
    problem = formations.problem(p=10, phases=(0, 2, 5, 7), horizon=2)
    assert not is_searchable(500, 2)
    lost = np.array([True, True, True, False])
    assert Passages(Predictor(problem), lost).distance(np.zeros(4, dtype=np.int64)) == NO_PASSAGE


def test_governors_of_one_problem_share_a_search(problem):
    first = passages(Predictor(problem), NO_LOSS)
    assert passages(Predictor(dataclasses.replace(problem)), NO_LOSS.copy()) is first
    assert passages(Predictor(problem), np.array([False, True, False])) is not first
    wide = dataclasses.replace(problem, max_angle=math.pi)
    others = passages(Predictor(wide), NO_LOSS)
    np.testing.assert_array_equal(others.distances, Passages(Predictor(wide), NO_LOSS).distances)
    assert (others.distances != first.distances).any()
