"""Deadlocked formations: noticed, published, and left by a passage with every limit kept."""

from __future__ import annotations

import json
from pathlib import Path

import formations
import numpy as np
import pytest

from spacecraft_gnc.governors.time_shift import Answer, Constraint, TimeShiftGovernor, fly
from spacecraft_gnc.plant.random_numbers import uniforms

pytestmark = pytest.mark.long

DATA = Path(__file__).parents[2] / "data" / "formation_deadlocks.json"
STARTS = json.loads(DATA.read_text(encoding="utf-8"))["starts"]


def case_of(start):
    return f"run {start['run']}"


@pytest.fixture(scope="module")
def problem():
    return formations.problem()


@pytest.fixture(scope="module")
def governor(problem):
    governor = TimeShiftGovernor(problem)
    governor.warm_up()
    return governor


def states_of(problem, start):
    return formations.start(problem.natural, start["phases"], start["offsets"], start["amplitudes"])


@pytest.mark.parametrize("start", STARTS, ids=case_of)
def test_starts_are_those_of_the_campaign(start):
    drawn = uniforms(2016, start["run"], "formation.start", 0, 9)
    assert start["phases"] == np.floor(50.0 * drawn[:3]).tolist()
    np.testing.assert_allclose(start["offsets"], 3000.0 + 6000.0 * drawn[3:6], rtol=1e-12)
    np.testing.assert_allclose(start["amplitudes"], 0.8 + drawn[6:], rtol=1e-12)


@pytest.mark.parametrize("start", STARTS, ids=case_of)
def test_without_passages_the_deadlock_is_published_and_stays(problem, start):
    governor = TimeShiftGovernor(problem, resolves_deadlocks=False)
    flight = fly(governor, states_of(problem, start), 160)
    last = flight.decisions[-1]
    assert last.deadlocked
    assert not last.formed
    assert last.shift_cost > 0.0
    assert last.error < 0.1  # [m]: at rest, in the wrong order
    assert last.waypoints_left == -1
    assert last.refused is not None
    assert last.refused.constraint == Constraint.ANGLE
    since = [decision.deadlocked for decision in flight.decisions].index(True)
    assert all(decision.deadlocked for decision in flight.decisions[since:])
    assert (flight.shifts[since - 5 :] == last.shifts).all()


@pytest.mark.parametrize("start", STARTS, ids=case_of)
def test_a_passage_leads_to_the_desired_formation_within_the_limits(problem, governor, start):
    flight = fly(governor, states_of(problem, start), 400)
    assert 0 < flight.formed_at < 260
    fast, near, wide = formations.flown_limits(problem, flight)
    assert fast <= problem.max_delta_v
    assert near >= problem.min_separation
    assert wide <= problem.max_angle
    stuck = [decision for decision in flight.decisions if decision.deadlocked]
    assert stuck
    assert all(decision.is_admissible for decision in flight.decisions)
    left = [decision.waypoints_left for decision in stuck]
    assert left[0] == 3
    assert (np.diff(left) <= 0).all()
    passage = [d for d in flight.decisions if d.answer == Answer.PASSAGE]
    assert all((decision.waypoint == decision.shifts).all() for decision in passage)
    assert passage[-1] is flight.decisions[-1]
    assert all(decision.n_admissible > 0 for decision in flight.decisions)
    told = [decision.refused for decision in stuck]
    assert all(refused is not None and refused.constraint == Constraint.ANGLE for refused in told)


def test_after_the_passage_the_governor_chooses_again(problem, governor):
    flight = fly(governor, states_of(problem, STARTS[0]), 400)
    after = governor.decide(len(flight.states), problem.step(flight.states[-1], flight.delta_v[-1]))
    assert after.answer == Answer.OPTIMAL
    assert not after.deadlocked


def test_a_formation_that_is_flown_to_at_once_is_no_deadlock(problem, governor):
    flight = fly(governor, formations.start(problem.natural), 120, stops=False)
    assert not any(decision.deadlocked for decision in flight.decisions)
    assert flight.formed_at == 73
