"""Detours: the same optimum as by the direct way, and others where that way is too long."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from ocp_cases import random_problem

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    PenaltyContinuation,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    StateContinuation,
    Status,
    Weights,
)

BOTH = pytest.mark.parametrize("kind", [PenaltyContinuation, StateContinuation])
PATIENT = ShootingOptions(max_iterations=200)
# Two solves to a residual of 1e-12 (1 + |lambda2|), over a smallest curvature of some 1e-2.
SAME = 1e-9


@BOTH
def test_it_leads_to_the_optimum_of_the_direct_solve(case_1, kind):
    ocp, attitude, momentum = case_1
    direct = ShootingSolver(ocp).solve(attitude, momentum)
    found = kind(ocp).solve(attitude, momentum)
    assert found.status is Status.CONVERGED
    assert found.ocp is ocp  # the problem asked for, not a softened one
    assert np.abs(found.torques - direct.torques).max() < 1e-12
    assert found.cost == pytest.approx(direct.cost, rel=1e-13)
    assert found.iterations > direct.iterations  # those of the whole way


@BOTH
def test_it_tracks_a_reference(case_1, kind):
    ocp, attitude, _ = case_1
    momentum, reference = np.array([0.02, 0.01, -0.03]), lie.exp(np.array([0.3, -0.2, 0.4]))
    direct = ShootingSolver(ocp).solve(attitude, momentum, reference)
    found = kind(ocp).solve(attitude, momentum, reference)
    assert np.array_equal(found.reference, reference)
    assert np.array_equal(found.attitudes[0], attitude)
    assert np.array_equal(found.momenta[0], momentum)
    assert np.abs(found.torques - direct.torques).max() < 1e-12


@BOTH
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
    assert seen["rescued"] >= 20
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


@BOTH
def test_hard_penalties_of_zones_come_back_in_full(kind):
    zone = PointingZone("exclusion", [1, 0, 0], [math.cos(0.3), math.sin(0.3), 0.0], 0.2, 50.0)
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.9]), 0.4, 6, Weights(), 0.05, 1e8, (zone,))
    state = lie.exp(np.array([0.02, 0.01, 0.55])), np.array([0.0, 0.0, -0.15])
    direct, found = ShootingSolver(ocp).solve(*state), kind(ocp).solve(*state)
    assert found.ocp.zones[0].penalty == 50.0
    assert found.zone_margins[0] < 0.0
    assert np.abs(found.torques - direct.torques).max() < SAME
    assert np.abs(ocp.gradient(found.torques, *state)).max() < 1e-9


@BOTH
def test_where_no_way_leads_the_last_failure_is_returned(case_1, kind):
    ocp, attitude, _ = case_1
    found = kind(ocp).solve(attitude, np.array([0.0, 3.0, 0.0]))
    assert not found.converged
    assert found.status is Status.UNSOLVABLE_STEP
    assert found.warm_start is None
