"""Craft that no longer answer: noticed from their states, kept away from, and done without."""

from __future__ import annotations

import json
from pathlib import Path

import formations
import numpy as np
import pytest

from spacecraft_gnc.governors.time_shift import (
    NEVER,
    Answer,
    CraftMonitor,
    TimeShiftGovernor,
    fly,
)
from spacecraft_gnc.plant.random_numbers import uniforms

DATA = Path(__file__).parents[2] / "data" / "formation_deadlocks.json"
HORIZON_MISSES = (13, 22, 30, 35)
"""Runs after whose loss there is for a while no combination that keeps all limits for 100 steps."""


@pytest.fixture(scope="module")
def problem():
    return formations.problem()


@pytest.fixture(scope="module")
def governor(problem):
    return TimeShiftGovernor(problem)


def campaign_start(problem, run):
    drawn = uniforms(2016, run, "formation.start", 0, 9)
    phases = np.floor(50.0 * drawn[:3]).astype(int)
    return formations.start(problem.natural, phases, 3e3 + 6e3 * drawn[3:6], 0.8 + drawn[6:])


@pytest.mark.parametrize("craft", [0, 1, 2])
@pytest.mark.parametrize("at", [3, 20])
def test_the_others_form_without_a_lost_craft(problem, governor, craft, at):
    failures = np.full(3, NEVER)
    failures[craft] = at
    flight = fly(governor, formations.start(problem.natural), 400, failures=failures)
    lost = np.array([decision.lost for decision in flight.decisions])
    assert not lost[: at + 1].any()
    assert lost[at + 1, craft]  # one sample after the first delta-v that was not given
    others = np.delete(np.arange(3), craft)
    assert not lost[:, others].any()
    assert flight.formed_at > at
    assert len({int(shift) for shift in flight.shifts[-1, others]}) == 1
    assert (flight.delta_v[at:, craft] == 0.0).all()
    fast, near, wide = formations.flown_limits(problem, flight, lost=(craft,))
    assert fast <= problem.max_delta_v
    assert near >= problem.min_separation
    assert wide <= problem.max_angle
    assert not flight.decisions[-1].deadlocked
    assert flight.decisions[-1].n_candidates == 2500


@pytest.mark.parametrize("run", HORIZON_MISSES)
def test_where_none_is_admissible_the_limits_are_kept_as_long_as_can_be(problem, governor, run):
    drawn = uniforms(2016, run, "formation.loss", 0, 2)
    craft, failures = int(3.0 * drawn[0]), np.full(3, NEVER)
    failures[craft] = int(5.0 + 55.0 * drawn[1])
    flight = fly(governor, campaign_start(problem, run), 600, failures=failures)
    answers = [decision.answer for decision in flight.decisions]
    assert Answer.LONGEST_KEPT in answers
    told = [d for d in flight.decisions if d.answer == Answer.LONGEST_KEPT]
    assert all(not decision.is_admissible for decision in told)
    assert all(decision.n_admissible == 0 for decision in told)
    assert flight.formed_at > 0
    fast, near, wide = formations.flown_limits(problem, flight, lost=(craft,))
    assert fast <= problem.max_delta_v
    assert near >= problem.min_separation
    assert wide <= problem.max_angle


@pytest.mark.parametrize(("case", "at"), [(6, 90), (7, 110)])
def test_a_passage_leads_around_a_craft_that_was_lost_at_rest(problem, governor, case, at):
    """Parked in a deadlock when it fails, it stays on the natural motion, in the others' way."""
    start = json.loads(DATA.read_text(encoding="utf-8"))["starts"][case]
    states = formations.start(
        problem.natural, start["phases"], start["offsets"], start["amplitudes"]
    )
    flight = fly(governor, states, 400, failures=np.array([NEVER, NEVER, at]))
    assert flight.formed_at > at
    fast, near, wide = formations.flown_limits(problem, flight, lost=(2,))
    assert fast <= problem.max_delta_v
    assert near >= problem.min_separation
    assert wide <= problem.max_angle
    after = [d for d in flight.decisions if d.lost[2]]
    assert any(decision.deadlocked for decision in after)
    assert any(decision.answer == Answer.PASSAGE for decision in after)


def test_with_all_craft_but_one_lost_it_forms_alone(problem, governor):
    start = formations.start(problem.natural)
    flight = fly(governor, start, 300, failures=np.array([4, NEVER, 4]))
    assert flight.decisions[-1].lost.tolist() == [True, False, True]
    assert flight.formed_at > 0
    assert flight.decisions[-1].n_candidates == 50


def test_responses_are_those_given(problem):
    monitor = CraftMonitor(problem)
    before = formations.start(problem.natural)
    asked = np.array([[0.3, 0.1, 0.0], [0.0, -0.2, 0.1], [1e-3, 0.0, 0.0]])
    given = asked * [[1.0], [0.4], [0.0]]
    response = monitor.observe(before, asked, problem.step(before, given))
    assert response[:2] == pytest.approx([1.0, 0.4], abs=1e-9)
    assert np.isnan(response[2])  # too little was asked to tell
    assert monitor.lost.tolist() == [False, True, False]
    monitor.observe(before, asked, problem.step(before, asked))
    assert monitor.lost.tolist() == [False, True, False]  # it stays lost
    monitor.reset()
    assert not monitor.lost.any()


def test_the_delta_v_asked_for_can_be_told(problem):
    """A delta-v that was not asked for is no missing response."""
    start = formations.start(problem.natural)
    governor = TimeShiftGovernor(problem)
    governor.decide(0, start)
    idle = problem.step(start, np.zeros((3, 3)))
    assert not governor.decide(1, idle, np.zeros((3, 3))).lost.any()
    governor.reset()
    governor.decide(0, start)
    assert governor.decide(1, idle).lost.all()


def test_after_a_gap_nothing_is_concluded(problem):
    start = formations.start(problem.natural)
    governor = TimeShiftGovernor(problem)
    governor.decide(0, start)
    late = governor.decide(2, start)
    assert not late.lost.any()
    assert np.isnan(late.response).all()
