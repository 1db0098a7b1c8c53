"""The shooting solver against the paper's figures, differences and another minimizer."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ocp_cases import independent, problems, references, shoot
from scipy.optimize import minimize
from strategies import rotations, vectors

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    Status,
    Weights,
)


def test_first_problem_of_case_1(case_1):
    ocp, attitude, momentum = case_1
    solution = ShootingSolver(ocp).solve(attitude, momentum)
    assert solution.status is Status.CONVERGED
    assert solution.iterations == 3
    assert solution.cost == pytest.approx(
        0.01587107410188242, abs=1e-12
    )  # PAPER_NOTES, two solvers
    expected = [-2.738291492e-3, -6.797529547e-3, -6.804072727e-3]
    assert solution.torques[0] == pytest.approx(expected, abs=1e-10)
    assert solution.residual < 1e-14
    assert solution.min_curvature > 0.0
    assert abs(solution.torque_margin) < 1e-8


@settings(max_examples=40)
@given(problems(), rotations(), vectors(0.3), references(), vectors(0.2), vectors(0.2))
def test_residual_and_jacobian_equal_the_plain_implementation(
    ocp, attitude, momentum, reference, lam1, lam2
):
    lam = np.concatenate([lam1, lam2])
    residual, jacobian = shoot(ocp, attitude, momentum, reference, lam)
    plain = independent(ocp, reference)
    expected = plain.residual(attitude, momentum, lam)
    size = max(1.0, np.abs(expected).max())
    assert np.abs(residual - expected).max() < 1e-10 * size
    step = 1e-30  # complex step: no cancellation, exact to rounding
    columns = [
        plain.residual(attitude.astype(complex), momentum.astype(complex), lam + 1j * step * e).imag
        for e in np.eye(6)
    ]
    derivative = np.array(columns).T / step
    assert np.abs(jacobian - derivative).max() < 1e-8 * np.abs(derivative).max()


@settings(max_examples=40)
@given(problems(), rotations(), vectors(0.3), references(), st.integers(0, 2**32 - 1))
def test_cost_and_gradient_equal_the_printed_cost(ocp, attitude, momentum, reference, seed):
    torques = np.random.default_rng(seed).normal(size=(ocp.horizon, 3)) * 0.2
    plain = independent(ocp, reference)
    cost = ocp.cost(torques, attitude, momentum, reference)
    assert cost == pytest.approx(plain.cost(attitude, momentum, torques), rel=1e-11, abs=1e-12)
    gradient = ocp.gradient(torques, attitude, momentum, reference)
    step = 1e-30
    expected = np.empty_like(gradient)
    for k, i in np.ndindex(*gradient.shape):
        moved = torques.astype(complex)
        moved[k, i] += 1j * step
        expected[k, i] = plain.cost(attitude, momentum, moved).imag / step
    assert np.abs(gradient - expected).max() < 1e-9 * max(1.0, np.abs(expected).max())


@settings(max_examples=20)
@given(problems(), rotations(), vectors(0.3), references(), st.integers(0, 2**32 - 1))
def test_hessian_equals_differences_of_the_gradient(ocp, attitude, momentum, reference, seed):
    torques = np.random.default_rng(seed).normal(size=(ocp.horizon, 3)) * 0.2
    hessian = ocp.hessian(torques, attitude, momentum, reference)
    step = 1e-6
    direction = np.random.default_rng(seed + 1).normal(size=torques.shape)
    ahead = ocp.gradient(torques + step * direction, attitude, momentum, reference)
    behind = ocp.gradient(torques - step * direction, attitude, momentum, reference)
    difference = ((ahead - behind) / (2.0 * step)).ravel()
    size = max(1.0, np.abs(hessian).max())
    assert np.abs(hessian - hessian.T).max() < 1e-9 * size
    # A kink of the penalty may lie between the two points: then the difference is first order.
    assert (
        np.abs(hessian @ direction.ravel() - difference).max()
        < 2e-4 * size * np.abs(direction).max()
    )


@settings(max_examples=25)
@given(problems(), rotations(), vectors(0.1), references())
def test_a_converged_solve_is_stationary_for_the_printed_cost(ocp, attitude, momentum, reference):
    solution = ShootingSolver(ocp).solve(attitude, momentum, reference)
    if solution.converged:
        gradient = ocp.gradient(solution.torques, attitude, momentum, reference)
        assert np.abs(gradient).max() < 1e-8
        assert ocp.cost(solution.torques, attitude, momentum, reference) == pytest.approx(
            solution.cost, rel=1e-9, abs=1e-12
        )
    else:
        assert solution.warm_start is None


@pytest.mark.parametrize("limit", [0.0, 0.01], ids=["unlimited", "limited"])
def test_the_optimum_equals_an_independent_minimization(case_1, limit):
    base, attitude, momentum = case_1
    ocp = AttitudeOcp(base.inertia, 0.4, 5, Weights(), max_torque=limit, torque_penalty=1e6)
    solution = ShootingSolver(ocp).solve(attitude, momentum)
    plain = independent(ocp)

    def cost(u):
        return plain.cost(attitude, momentum, u.reshape(5, 3))

    def gradient(u):  # complex step on the plain cost: nothing of the package is used
        parts = [cost(u + 1e-30j * e).imag / 1e-30 for e in np.eye(15)]
        return np.array(parts)

    found = minimize(cost, np.zeros(15), jac=gradient, method="BFGS", options={"gtol": 1e-11})
    assert solution.cost == pytest.approx(found.fun, abs=1e-12)
    assert np.abs(solution.torques.ravel() - found.x).max() < 1e-7


def test_zones_change_the_optimum_as_an_independent_minimisation_says():
    zone = PointingZone("exclusion", [1, 0, 0], [math.cos(0.3), math.sin(0.3), 0.0], 0.2, 1.0)
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.9]), 0.4, 6, Weights(), zones=(zone,))
    attitude, momentum = lie.exp(np.array([0.02, 0.01, 0.55])), np.array([0.0, 0.0, -0.15])
    solution = ShootingSolver(ocp).solve(attitude, momentum)
    assert solution.converged
    assert solution.zone_margins[0] < 0.0  # the soft zone is entered: its penalty is at work
    plain = independent(ocp)
    found = minimize(
        lambda u: plain.cost(attitude, momentum, u.reshape(6, 3)), np.zeros(18),
        jac=lambda u: ocp.gradient(u.reshape(6, 3), attitude, momentum).ravel(),
        method="BFGS", options={"gtol": 1e-11},
    )  # fmt: skip
    assert solution.cost == pytest.approx(found.fun, abs=1e-12)
    assert np.abs(solution.torques.ravel() - found.x).max() < 1e-7


@settings(max_examples=25)
@given(rotations(), rotations(), vectors(0.2))
def test_tracking_with_scalar_weights_is_regulation_seen_from_the_reference(reference, R, Pi):
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.9]), 0.4, 4, Weights())
    solver = ShootingSolver(ocp)
    tracked = solver.solve(reference @ R, Pi, reference)
    regulated = solver.solve(R, Pi)
    assert tracked.cost == pytest.approx(regulated.cost, rel=1e-10, abs=1e-13)
    assert np.abs(tracked.torques - regulated.torques).max() < 1e-9


def test_warm_starts_need_fewer_steps_and_give_the_same_answers(case_1):
    ocp, attitude, momentum = case_1
    solver = ShootingSolver(replace(ocp, horizon=20))
    warm_start, warm_steps, cold_steps = None, 0, 0
    for _ in range(50):
        warm = solver.solve(attitude, momentum, warm_start=warm_start)
        cold = solver.solve(attitude, momentum)
        assert np.abs(warm.torques - cold.torques).max() < 1e-11
        warm_steps, cold_steps = warm_steps + warm.iterations, cold_steps + cold.iterations
        warm_start = warm.warm_start
        attitude, momentum = ocp.body.step(attitude, momentum, warm.torques[0])
    assert warm_steps < 0.75 * cold_steps


def test_backtracking_converges_where_full_steps_do_not():
    zone = PointingZone("exclusion", [1, 0, 0], [0.9276, 0.3736, 0.0], math.radians(4.9965), 1e3)
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 5, Weights(), 0.01, 1e10, (zone,))
    solver = ShootingSolver(ocp)
    attitude, momentum = lie.exp(np.array([0.0, 1e-3, 0.5])), np.zeros(3)
    warm = None
    for _ in range(60):
        solution = solver.solve(attitude, momentum, warm_start=warm)
        assert solution.converged
        warm = solution.warm_start
        attitude, momentum = ocp.body.step(attitude, momentum, solution.torques[0])


def test_solutions_are_independent_of_later_solves(case_1):
    ocp, attitude, momentum = case_1
    solver = ShootingSolver(ocp)
    first = solver.solve(attitude, momentum)
    kept = first.torques.copy()
    solver.solve(lie.exp(np.array([1.0, 0.0, 0.0])), momentum)
    assert np.array_equal(first.torques, kept)


def test_failures_are_statuses_not_exceptions(case_1):
    ocp, attitude, momentum = case_1
    capped = ShootingSolver(ocp, options=ShootingOptions(max_iterations=1))
    stopped = capped.solve(attitude, momentum)
    assert (stopped.status, stopped.iterations) == (Status.MAX_ITERATIONS, 1)
    assert stopped.warm_start is None
    fast = ShootingSolver(ocp).solve(attitude, np.array([0.0, 3.0, 0.0]))
    assert fast.status is Status.UNSOLVABLE_STEP
    assert math.isnan(fast.min_curvature)
    assert "Kalabic" in fast.status.advice
    wild = ShootingSolver(ocp).solve(attitude, momentum, warm_start=np.full((5, 6), 1e300))
    assert not wild.converged


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ((1.1 * np.eye(3), np.zeros(3)), ParameterError, "attitude"),
        ((np.full((3, 3), np.nan), np.zeros(3)), ParameterError, "attitude"),
        ((np.eye(3), np.array([0.0, np.inf, 0.0])), ParameterError, "momentum"),
        ((np.eye(3), np.zeros(4)), ShapeError, "momentum"),
        ((np.eye(4), np.zeros(3)), ShapeError, "attitude"),
        ((np.eye(3), np.zeros(3), np.diag([1.0, 1.0, -1.0])), ParameterError, "reference"),
        ((np.eye(3), np.zeros(3), np.eye(2)), ShapeError, "reference"),
        ((np.eye(3), np.zeros(3), None, np.zeros(5)), ShapeError, "warm_start"),
        ((np.eye(3), np.zeros(3), None, np.zeros(6)), ShapeError, r"warm_start.*\(5, 6\)"),
    ],
)
def test_wrong_inputs_raise_and_name_the_argument(case_1, arguments, error, words):
    with pytest.raises(error, match=words):
        ShootingSolver(case_1[0]).solve(*arguments)


def test_a_rollout_that_breaks_off_leaves_no_numbers_of_earlier_uses():
    """Its memory is new: whatever stood there before would be published, and start a solve."""
    solver = ShootingSolver(AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 5, max_torque=0.01))
    fast = np.array([50.0, 0.0, 0.0])  # Kalabic (3) has no step
    found = solver.solve(np.eye(3), fast)
    assert found.status is Status.UNSOLVABLE_STEP
    assert np.array_equal(found.attitudes[0], np.eye(3))
    assert np.array_equal(found.momenta[0], fast)
    for rest in (found.attitudes[1:], found.momenta[1:], found.torques, found.multipliers):
        assert np.isnan(rest).all()
    many = solver.solve_batch(np.eye(3)[None], fast[None])
    assert np.isnan(many.torques).all()
    assert np.isnan(many.costates).all()
