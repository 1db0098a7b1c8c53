"""Formulations, step rules and variants: one optimum, by different ways."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    Status,
    Weights,
)

REST = np.zeros(3)
FORMULATIONS = ("backward_sweep", "single_shooting")
STEP_RULES = ("backtracking", "full", "damped", "chord")
VARIANTS = ("exact", "estimated_du", "estimated_u")
# The residual is solved to 1e-12 (1 + |lambda2|), and |U| <= 1, |S^-1| is about 1 here.
SAME = 1e-11


def solver(ocp, formulation="auto", step_rule="backtracking", variant="exact", iterations=200):
    options = ShootingOptions(
        formulation=formulation, step_rule=step_rule, max_iterations=iterations
    )
    return ShootingSolver(ocp, variant, options)


def flight(solve, ocp, attitude, n_steps, warm=True):
    """Solutions along a closed loop from rest."""
    momentum, start = REST, None
    for _ in range(n_steps):
        solution = solve(attitude, momentum, None, start)
        yield attitude, momentum, solution
        start = solution.warm_start if warm else None
        attitude, momentum = ocp.body.step(attitude, momentum, solution.torques[0])


@pytest.mark.parametrize(
    ("formulation", "step_rule", "variant"),
    list(itertools.product(FORMULATIONS, STEP_RULES, VARIANTS)),
)
def test_every_way_leads_to_the_same_optimum(case_1, formulation, step_rule, variant):
    ocp, attitude, _ = case_1
    tried = solver(ocp, formulation, step_rule, variant)
    warm = None
    for R, Pi, exact in flight(ShootingSolver(ocp).solve, ocp, attitude, 20):
        solution = tried.solve(R, Pi, None, warm)
        assert solution.status is Status.CONVERGED
        assert solution.formulation == formulation
        assert np.abs(solution.torques - exact.torques).max() < SAME
        assert solution.cost == pytest.approx(exact.cost, rel=1e-12)
        # The pivot belongs to the last linearization, one step (of half length: damped) away.
        assert solution.min_curvature == pytest.approx(exact.min_curvature, rel=1e-3)
        warm = solution.warm_start


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_newton_needs_fewer_steps_than_its_simplifications(case_1, formulation):
    ocp, attitude, momentum = case_1
    steps = {}
    for rule, variant in itertools.product(STEP_RULES, VARIANTS):
        solution = solver(ocp, formulation, rule, variant).solve(attitude, momentum)
        steps[rule, variant] = solution.iterations
    assert steps["backtracking", "exact"] == steps["full", "exact"] == 3  # PAPER_NOTES
    assert steps["chord", "exact"] > 3
    assert steps["full", "estimated_du"] > 3  # the start is saturated: (40) is linear there
    assert steps["full", "estimated_u"] == steps["full", "estimated_du"]
    # Half a step leaves half the residual: about log2(1e12) steps, 40.
    assert 30 <= steps["damped", "exact"] <= 45


def test_the_estimated_sensitivity_is_exact_where_no_limit_acts(case_1):
    ocp, _, momentum = case_1
    near = lie.exp(np.array([0.02, 0.04, 0.04]))
    exact = ShootingSolver(ocp).solve(near, momentum)
    estimated = solver(ocp, variant="estimated_du").solve(near, momentum)
    assert exact.torque_margin > 1e-3
    assert estimated.iterations == exact.iterations
    assert np.array_equal(estimated.torques, exact.torques)


@pytest.fixture
def past_a_zone():
    """Case II from off its plane."""
    zone = PointingZone("exclusion", [1, 0, 0], [0.9276, 0.3736, 0.0], math.radians(4.9965), 1e3)
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 5, Weights(), 0.01, 1e10, (zone,))
    return ocp, lie.exp(np.array([0.0, 1e-3, 0.5]))


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_full_steps_cycle_at_the_first_contact_with_a_zone(past_a_zone, formulation):
    """PAPER_NOTES: from unshifted multipliers full steps alternate, shortened ones converge."""
    ocp, start = past_a_zone
    full = solver(ocp, formulation, "full")
    unshifted, cycles = None, []
    steps = flight(ShootingSolver(ocp).solve, ocp, start, 8)
    for k, (R, Pi, exact) in enumerate(steps):
        tried = full.solve(R, Pi, None, unshifted)
        cured = solver(ocp, formulation).solve(R, Pi, None, unshifted)
        assert cured.converged
        assert cured.iterations < 20
        assert np.abs(cured.torques - exact.torques).max() < SAME
        if not tried.converged:
            assert tried.status is Status.MAX_ITERATIONS
            # A 2-cycle: two further steps lead back to the same point.
            later = solver(ocp, formulation, "full", iterations=202).solve(R, Pi, None, unshifted)
            assert later.residual == pytest.approx(tried.residual, rel=1e-6)
            cycles.append(k)
        unshifted = exact.costates
    assert cycles == [3]


def test_a_kept_factorisation_is_dropped_after_a_failure(case_1):
    ocp, attitude, momentum = case_1
    chord, fresh = (solver(ocp, step_rule="chord") for _ in range(2))
    chord.solve(attitude, momentum)
    assert chord.kept[0] == 1
    assert chord.solve(attitude, np.array([0.0, 3.0, 0.0])).status is Status.UNSOLVABLE_STEP
    assert chord.kept[0] == 0
    after, expected = chord.solve(attitude, momentum), fresh.solve(attitude, momentum)
    assert after.iterations == expected.iterations
    assert np.array_equal(after.torques, expected.torques)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_chord_survives_a_jump_of_the_problem(case_1, formulation):
    ocp, attitude, momentum = case_1
    chord = solver(ocp, formulation, "chord")
    rng = np.random.default_rng(5)
    for _ in range(20):
        R = attitude @ lie.exp(rng.normal(size=3))
        found, exact = chord.solve(R, momentum), ShootingSolver(ocp).solve(R, momentum)
        assert found.converged
        assert np.abs(found.torques - exact.torques).max() < SAME


def test_a_chord_does_not_certify_with_what_another_solve_left():
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 50)
    chord = solver(ocp, step_rule="chord")
    assert chord.solve(np.eye(3), REST).status is Status.CONVERGED
    assert chord.solve(lie.exp(np.array([math.pi, 0.0, 0.0])), REST).status is Status.SADDLE


@pytest.mark.parametrize("horizon", [60, 80, 100])
def test_single_shooting_loses_long_horizons_and_the_sweep_does_not(case_1, horizon):
    base, attitude, momentum = case_1
    ocp = AttitudeOcp(base.inertia, 0.4, horizon, Weights(), 0.01, 1e10)
    swept = solver(ocp, "backward_sweep").solve(attitude, momentum)
    assert swept.status is Status.CONVERGED
    assert swept.min_curvature > 0.0
    assert swept.iterations <= 20
    assert np.abs(ocp.gradient(swept.torques, attitude, momentum)).max() < 1e-8
    shot = solver(ocp, "single_shooting").solve(attitude, momentum)
    assert not shot.converged or shot.cost > 2.0 * swept.cost


@pytest.mark.parametrize("limit", [0.0, 0.01], ids=["unlimited", "limited"])
@pytest.mark.parametrize("axis", range(3))
def test_half_a_turn_over_a_long_horizon_is_a_saddle_that_the_sweep_leaves(axis, limit):
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 50, Weights(), limit, 1e10)
    start = lie.exp(math.pi * np.eye(3)[axis])
    idle = np.zeros((50, 3))
    # Stationary, but for the rounding of pi, carried over 50 steps.
    assert np.abs(ocp.gradient(idle, start, REST)).max() < 1e-13
    assert np.linalg.eigvalsh(ocp.hessian(idle, start, REST))[0] < -1e-3
    stuck = solver(ocp, "single_shooting").solve(start, REST)
    assert stuck.status is Status.SADDLE
    assert not stuck.converged
    assert stuck.min_curvature < 0.0
    assert "saddle" in stuck.status.advice
    left = solver(ocp, "backward_sweep").solve(start, REST)
    assert left.status is Status.CONVERGED
    assert left.min_curvature > 0.0
    assert left.cost < ocp.cost(idle, start, REST) - 0.05
    np.linalg.cholesky(ocp.hessian(left.torques, start, REST))


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_half_a_turn_over_five_steps_is_a_strict_minimum(case_1, formulation):
    ocp, _, _ = case_1
    start = lie.exp(np.array([math.pi, 0.0, 0.0]))
    solution = solver(ocp, formulation).solve(start, REST)
    assert solution.status is Status.CONVERGED
    assert np.abs(solution.torques).max() < 1e-16
    smallest = np.linalg.eigvalsh(ocp.hessian(solution.torques, start, REST))[0]
    assert 0.5 < smallest <= solution.min_curvature


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"formulation": "collocation"}, "formulation.*backward_sweep"),
        ({"step_rule": "hybrid"}, "step_rule.*backtracking"),
        ({"damping": 0.0}, "damping"),
        ({"damping": math.nan}, "damping"),
        ({"damping": 1.5}, "damping"),
        ({"max_iterations": 0}, "max_iterations"),
        ({"residual_tolerance": 0.0}, "residual_tolerance"),
    ],
)
def test_options_are_checked(options, words):
    with pytest.raises(ParameterError, match=words):
        ShootingOptions(**options)
