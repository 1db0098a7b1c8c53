"""Detours: the same optimum as by the direct way, and others where that way is too long."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from ocp_cases import random_problem

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    AutomaticContinuation,
    EffortContinuation,
    HorizonContinuation,
    PenaltyContinuation,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    StateContinuation,
    Status,
    Weights,
    cheapest,
)

KINDS = [
    PenaltyContinuation, StateContinuation, HorizonContinuation, EffortContinuation,
    AutomaticContinuation,
]  # fmt: skip
ALL = pytest.mark.parametrize("kind", KINDS)
PATIENT = ShootingOptions(max_iterations=200)
# Two solves to a residual of 1e-12 |lambda2|, over a smallest curvature of some 1e-2.
SAME = 1e-9


@ALL
def test_it_leads_to_the_optimum_of_the_direct_solve(case_1, kind):
    ocp, attitude, momentum = case_1
    direct = ShootingSolver(ocp).solve(attitude, momentum)
    found = kind(ocp).solve(attitude, momentum)
    assert found.status is Status.CONVERGED
    assert found.ocp is ocp  # the problem asked for, not a softened one
    assert np.abs(found.torques - direct.torques).max() < 1e-12
    assert found.cost == pytest.approx(direct.cost, rel=1e-13)
    assert found.iterations > direct.iterations  # those of the whole way


@ALL
def test_it_tracks_a_reference(case_1, kind):
    ocp, attitude, _ = case_1
    momentum, reference = np.array([0.02, 0.01, -0.03]), lie.exp(np.array([0.3, -0.2, 0.4]))
    direct = ShootingSolver(ocp).solve(attitude, momentum, reference)
    found = kind(ocp).solve(attitude, momentum, reference)
    assert np.array_equal(found.reference, reference)
    assert np.array_equal(found.attitudes[0], attitude)
    assert np.array_equal(found.momenta[0], momentum)
    assert np.abs(found.torques - direct.torques).max() < 1e-12


@ALL
def test_it_solves_what_a_cold_solve_of_few_steps_does_not(kind):
    few, rng, seen = ShootingOptions(max_iterations=5), np.random.default_rng(4), Counter()
    for _ in range(100):
        ocp, attitude, momentum = random_problem(rng)
        cold = ShootingSolver(ocp, options=few).solve(attitude, momentum)
        found = kind(ocp, few).solve(attitude, momentum)
        if cold.converged or not found.converged:
            continue
        seen["rescued"] += 1
        assert cold.status is Status.MAX_ITERATIONS
        assert found.min_curvature > 0.0
        direct = ShootingSolver(ocp, options=PATIENT).solve(attitude, momentum)
        seen["same"] += bool(np.abs(found.torques - direct.torques).max() < SAME)
    assert seen["rescued"] >= 15
    assert seen["same"] >= 0.7 * seen["rescued"]  # the rest: other local minima


def test_a_state_continuation_halves_its_step_where_a_solve_fails(monkeypatch):
    few, rng = ShootingOptions(max_iterations=4), np.random.default_rng(4)
    shares, outcomes = [], []
    solve = ShootingSolver.solve

    def watched(self, attitude, momentum, reference=None, warm_start=None):
        solution = solve(self, attitude, momentum, reference, warm_start)
        shares.append(np.linalg.norm(momentum))
        outcomes.append(solution.converged)
        return solution

    solved = halved = 0
    for _ in range(60):
        ocp, attitude, momentum = random_problem(rng)
        continuation = StateContinuation(ocp, few)
        with monkeypatch.context() as patch:
            patch.setattr(ShootingSolver, "solve", watched)
            found = continuation.solve(attitude, momentum)
        way = np.array(shares) / np.linalg.norm(momentum)
        if found.converged:
            solved += 1
            assert np.array_equal(found.momenta[0], momentum)  # at the state asked for
            assert way[-1] == pytest.approx(1.0)
            for before, after, good in zip(way, way[1:], outcomes, strict=False):
                assert (after > before) == good  # on from what is solved, back from what is not
            halved += not all(outcomes)
        shares.clear()
        outcomes.clear()
    assert solved >= 50
    assert halved >= 10


@ALL
def test_hard_penalties_of_zones_come_back_in_full(kind):
    zone = PointingZone("exclusion", [1, 0, 0], [math.cos(0.3), math.sin(0.3), 0.0], 0.2, 50.0)
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.9]), 0.4, 6, Weights(), 0.05, 1e8, (zone,))
    state = lie.exp(np.array([0.02, 0.01, 0.55])), np.array([0.0, 0.0, -0.15])
    direct, found = ShootingSolver(ocp).solve(*state), kind(ocp).solve(*state)
    assert found.ocp.zones[0].penalty == 50.0
    assert found.zone_margins[0] < 0.0
    assert np.abs(found.torques - direct.torques).max() < SAME
    assert np.abs(ocp.gradient(found.torques, *state)).max() < 1e-9


@ALL
def test_where_no_way_leads_the_last_failure_is_returned(case_1, kind):
    ocp, attitude, _ = case_1
    found = kind(ocp).solve(attitude, np.array([0.0, 3.0, 0.0]))
    assert not found.converged
    assert found.status is Status.UNSOLVABLE_STEP
    assert found.warm_start is None


def test_without_penalties_there_is_nothing_to_soften(case_1):
    """It used to solve the same problem five times."""
    ocp, attitude, momentum = case_1
    free = replace(ocp, max_torque=0.0)
    direct = ShootingSolver(free).solve(attitude, momentum)
    assert PenaltyContinuation(free).solve(attitude, momentum).iterations == direct.iterations


def jumps(count):
    rng = np.random.default_rng(3)
    for _ in range(count):
        yield lie.exp(1.2 * rng.normal(size=3)), 0.05 * rng.normal(size=3)


def test_long_horizons_are_solved_by_way_of_short_ones(case_1):
    ocp = replace(case_1[0], horizon=300)
    direct, way = ShootingSolver(ocp), HorizonContinuation(ocp)
    cold = [direct.solve(*state).converged for state in jumps(20)]
    found = [way.solve(*state) for state in jumps(20)]
    assert sum(cold) <= 8  # of its fifty Newton steps most are spent far away
    assert sum(solution.converged for solution in found) >= 19
    for solution in found:
        gradient = ocp.gradient(solution.torques, solution.attitudes[0], solution.momenta[0])
        largest = np.abs(solution.costates[:, 3:]).max()
        if solution.converged:
            assert np.abs(gradient).max() < 1e-7 * largest  # of torques rolled out once more
    way = AutomaticContinuation(ocp)
    assert all(way.solve(*state).converged for state in jumps(20))


def test_the_cheapest_of_several_starts_is_no_dearer_than_any(case_1):
    ocp = replace(case_1[0], horizon=100)
    direct, way, cheaper = ShootingSolver(ocp), AutomaticContinuation(ocp), 0
    for state in jumps(30):
        cold, found = direct.solve(*state), way.solve(*state)
        best = cheapest((cold, found))
        assert best.cost <= min(cold.cost, found.cost) * (1.0 + 1e-12)
        assert best.iterations == cold.iterations + found.iterations
        cheaper += found.cost < cold.cost * (1.0 - 1e-6)
        assert found.cost < cold.cost * (1.0 + 1e-6)
    assert cheaper >= 5


def test_a_failure_never_wins_however_cheap(case_1):
    ocp, attitude, momentum = case_1
    good = ShootingSolver(ocp).solve(attitude, momentum)
    bad = good.replace(status=Status.MAX_ITERATIONS, cost=0.0)
    assert cheapest((bad, good)).status is Status.CONVERGED
    assert cheapest((good, bad)).status is Status.CONVERGED
    assert cheapest((bad, bad.replace(status=Status.SADDLE))).status is Status.MAX_ITERATIONS
    equal = good.replace(cost=good.cost * (1.0 - 1e-14), torques=good.torques.copy())
    assert cheapest((good, equal)).torques is good.torques
