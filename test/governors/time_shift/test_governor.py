"""The time shift governor: the report's figures, the choice against all combinations, holding."""

from __future__ import annotations

import math

import formations
import numpy as np
import pytest
from enumerated_shifts import enumerate_all

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.governors.time_shift import (
    Answer,
    Constraint,
    CraftMonitor,
    TimeShiftGovernor,
    fly,
    fly_unshifted,
    require_admissible,
    start_violation,
)


def test_without_the_governor_the_figures_start_breaks_every_limit():
    problem = formations.problem()
    flight = fly_unshifted(problem, formations.start(problem.natural), 150)
    fast, near, wide = formations.flown_limits(problem, flight)
    assert fast == pytest.approx(1.2185, abs=5e-5)
    assert near == pytest.approx(578.8, abs=0.05)
    assert wide > math.radians(170.0)


def test_with_the_governor_the_figures_start_forms_within_the_limits():
    problem = formations.problem()
    flight = fly(TimeShiftGovernor(problem), formations.start(problem.natural), 100)
    fast, near, wide = formations.flown_limits(problem, flight)
    assert flight.formed_at == 73
    assert fast == pytest.approx(0.8872, abs=5e-5)
    assert near == pytest.approx(1664.8, abs=0.05)
    assert wide < problem.max_angle
    assert flight.largest_delta_v == pytest.approx(fast)
    assert flight.separation.min() == pytest.approx(near)
    assert flight.angle.max() == pytest.approx(wide)
    assert {decision.answer for decision in flight.decisions} == {Answer.OPTIMAL}
    assert all(decision.is_admissible for decision in flight.decisions)
    # The last shifts are admissible again, and cost less a step later.
    costs = np.array([decision.cost for decision in flight.decisions])
    assert (np.diff(costs) < 0.0).all()


@pytest.mark.parametrize("step", [0, 3, 30])
def test_the_choice_is_the_best_of_all_combinations(step):
    problem = formations.problem()
    governor = TimeShiftGovernor(problem)
    states = formations.start(problem.natural)
    for k in range(step):
        states = problem.step(states, problem.delta_v(k, states, governor.decide(k, states).shifts))
    decision, every = governor.decide(step, states), enumerate_all(problem, step, states)
    chosen = tuple(decision.shifts)
    np.testing.assert_array_equal(decision.shifts, every.best())
    assert decision.n_admissible == np.count_nonzero(every.admissible)
    assert decision.n_candidates == every.admissible.size
    cheapest_of_all = every._replace(admissible=np.ones_like(every.admissible)).best()
    assert (decision.refused is None) == bool((cheapest_of_all == decision.shifts).all())
    assert decision.shift_cost == every.shift_cost[chosen]
    assert decision.state_cost == pytest.approx(every.state_cost[chosen], rel=1e-10)


@pytest.mark.parametrize("seed", range(6))
def test_starts_at_random_agree_with_the_enumeration(seed):
    generator = np.random.default_rng(seed)
    problem = formations.problem(p=12, phases=(4, 0, 8), horizon=30)
    phases = generator.integers(12, size=3)
    amplitudes, offsets = generator.uniform(0.8, 1.8, 3), generator.uniform(3e3, 9e3, 3)
    states = formations.start(problem.natural, phases, offsets, amplitudes)
    states[:, 2:6:3] = generator.normal(0.0, (300.0, 0.3), (3, 2))  # out of the plane as well
    every = enumerate_all(problem, 7, states)
    decision = TimeShiftGovernor(problem).decide(7, states)
    assert max(decision.n_admissible, 0) == np.count_nonzero(every.admissible)
    if every.admissible.any():
        np.testing.assert_array_equal(decision.shifts, every.best())
    else:
        assert decision.answer == Answer.LEAST_VIOLATING
        assert decision.margin.share < 0.0


def test_a_start_too_far_away_is_refused_with_what_is_missed():
    problem = formations.problem()
    start = formations.start(problem.natural, offsets=(6103.0, 25000.0, 5036.0))
    missed = start_violation(problem, start)
    assert missed is not None
    assert missed.constraint == Constraint.DELTA_V
    assert missed.craft == (1,)
    assert missed.share < 0.0
    with pytest.raises(ParameterError, match=r"delta-v of craft 2: .* limit 1 m/s, now"):
        require_admissible(problem, start)
    require_admissible(problem, formations.start(problem.natural))


def test_the_least_violating_combination_violates_least():
    problem = formations.problem(p=12, phases=(4, 0, 8), horizon=30, max_delta_v=0.4)
    start = formations.start(problem.natural, (3, 9, 6))
    missed = start_violation(problem, start)
    assert not enumerate_all(problem, 0, start).admissible.any()
    # With every limit wider by what is missed there is an admissible one; by a bit less, none.
    for factor, is_any in ((1.0 + 1e-9, True), (1.0 - 1e-6, False)):
        excess = -missed.share * factor
        wider = formations.problem(
            p=12, phases=(4, 0, 8), horizon=30,
            max_delta_v=0.4 * (1.0 + excess),
            min_separation=1000.0 * (1.0 - excess),
            max_angle=min(math.pi, problem.max_angle * (1.0 + excess)),
        )  # fmt: skip
        assert enumerate_all(wider, 0, start).admissible.any() == is_any


def test_without_an_admissible_combination_the_last_shifts_are_held():
    problem = formations.problem()
    governor = TimeShiftGovernor(problem)
    start = formations.start(problem.natural)
    first = governor.decide(0, start)
    pushed = problem.step(start, problem.delta_v(0, start, first.shifts))
    pushed[1, 1] += 3e4
    governor._monitor.reset()
    governor._last = None  # a push that is no missing response
    held = governor.decide(1, pushed)
    assert held.answer == Answer.HELD
    np.testing.assert_array_equal(held.shifts, first.shifts)
    assert not held.is_admissible
    assert held.margin.constraint == Constraint.DELTA_V
    assert held.margin.craft == (1,)


def test_two_craft_form():
    problem = formations.problem(phases=(0, 25))
    start = formations.start(problem.natural, (45, 21), (6000.0, 4000.0), (1.2, 0.9))
    flight = fly(TimeShiftGovernor(problem), start, 150)
    fast, near, wide = formations.flown_limits(problem, flight)
    assert flight.formed_at > 0
    assert fast <= 1.0
    assert near >= 1000.0
    assert wide <= problem.max_angle


def test_four_craft_form():
    problem = formations.problem(p=10, phases=(0, 2, 5, 7), horizon=20, min_separation=500.0)
    start = formations.start(
        problem.natural, (0, 2, 5, 7), (3000.0, 3100.0, 2900.0, 3000.0), (1.0, 1.1, 0.9, 1.0)
    )
    flight = fly(TimeShiftGovernor(problem), start, 120)
    fast, near, wide = formations.flown_limits(problem, flight)
    assert flight.decisions[0].n_candidates == 10**4
    # A shift of a tenth of the period costs more than W: the best is not yet the desired one.
    stuck = next(decision for decision in flight.decisions if decision.deadlocked)
    assert stuck.refused is None
    assert flight.formed_at > 0
    assert fast <= 1.0
    assert near >= 500.0
    assert wide <= problem.max_angle


def test_noise_of_half_a_meter_is_neither_a_loss_nor_a_deadlock():
    problem, generator = formations.problem(), np.random.default_rng(1)
    noise = np.repeat([0.5, 5e-4], 3)  # [m], [m/s]
    of_delta_v = math.hypot(math.sqrt(1.5) * 0.5 / (formations.PERIOD / 50), 5e-4)
    governor = TimeShiftGovernor(problem, monitor=CraftMonitor(problem, 13.0 * of_delta_v))
    states, decided = formations.start(problem.natural), []
    for k in range(110):
        measured = states + noise * generator.normal(size=(3, 6))
        decided.append(governor.decide(k, measured))
        states = problem.step(states, problem.delta_v(k, measured, decided[-1].shifts))
    assert {decision.answer for decision in decided} == {Answer.OPTIMAL}
    assert all(decision.formed for decision in decided[90:])
    assert not decided[-1].lost.any()


def test_states_of_another_shape_are_refused():
    governor = TimeShiftGovernor(formations.problem())
    with pytest.raises(ShapeError, match="states"):
        governor.decide(0, np.zeros((2, 6)))
    with pytest.raises(ParameterError, match="finite"):
        governor.decide(0, np.full((3, 6), np.nan))
