"""Periodic regulator: residual of its equation, scipy, a long horizon, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import block_diag, solve_discrete_are

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.ocp.periodic_lqr import periodic_lqr


@st.composite
def systems(draw):
    """A system of period 1 to 6, often unstable, with weights; controllable almost surely."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    p, n, m = draw(st.integers(1, 6)), draw(st.integers(1, 6)), draw(st.integers(1, 3))
    A = np.eye(n) + 0.5 * rng.normal(size=(p, n, n))
    half_q, half_r = rng.normal(size=(n, n)), rng.normal(size=(m, m))
    Q, R = half_q @ half_q.T + 1e-3 * np.eye(n), half_r @ half_r.T + 0.1 * np.eye(m)
    return A, rng.normal(size=(p, n, m)), Q, R


def residual(A, B, Q, R, law):
    """Largest defect of the periodic Riccati equation as it is printed, relative."""
    p, worst = len(A), 0.0
    for k in range(p):
        S = law.costs[(k + 1) % p]
        gain = np.linalg.solve(R + B[k].T @ S @ B[k], B[k].T @ S @ A[k])
        cost = Q + A[k].T @ S @ (A[k] - B[k] @ gain)
        worst = max(worst, np.abs(cost - law.costs[k]).max() / np.abs(law.costs).max())
        worst = max(worst, np.abs(gain - law.gains[k]).max() / max(1.0, np.abs(gain).max()))
    return worst


def lifted(A, B, Q, R):
    """Return the time-invariant cyclic system of Flamm, whose regulator is the periodic one."""
    p, n, m = B.shape
    cyclic_a, cyclic_b = np.zeros((p * n, p * n)), np.zeros((p * n, p * m))
    for k in range(p):
        to = (k + 1) % p
        cyclic_a[to * n : (to + 1) * n, k * n : (k + 1) * n] = A[k]
        cyclic_b[to * n : (to + 1) * n, k * m : (k + 1) * m] = B[k]
    return cyclic_a, cyclic_b, block_diag(*[Q] * p), block_diag(*[R] * p)


@given(systems())
def test_costs_solve_the_periodic_riccati_equation(system):
    law = periodic_lqr(*system)
    assert residual(*system, law) < 1e-8
    over = np.eye(system[0].shape[1])
    for A, B, K in zip(*system[:2], law.gains, strict=True):
        over = (A - B @ K) @ over
    assert np.abs(np.linalg.eigvals(over)).max() < 1.0
    assert np.isclose(np.abs(np.linalg.eigvals(over)).max(), law.spectral_radius, atol=1e-9)
    assert np.array_equal(law.costs, law.costs.transpose(0, 2, 1))


@given(systems())
def test_costs_are_those_of_the_lifted_system(system):
    law = periodic_lqr(*system)
    n = system[0].shape[1]
    expected = solve_discrete_are(*lifted(*system))
    for k, cost in enumerate(law.costs):
        block = expected[k * n : (k + 1) * n, k * n : (k + 1) * n]
        assert np.abs(block - cost).max() < 1e-6 * np.abs(expected).max()


def test_cost_is_that_of_the_flight():
    rng = np.random.default_rng(1)
    A, B = np.eye(4) + 0.3 * rng.normal(size=(5, 4, 4)), rng.normal(size=(5, 4, 2))
    Q, R = np.diag([1.0, 0.0, 2.0, 0.5]), np.diag([1.0, 3.0])
    law = periodic_lqr(A, B, Q, R)
    for start in range(5):
        x, spent = np.array([1.0, -2.0, 0.5, 3.0]), 0.0
        expected = x @ law.costs[start] @ x
        for k in range(start, start + 2000):
            u = -law.gains[k % 5] @ x
            spent += x @ Q @ x + u @ R @ u
            x = A[k % 5] @ x + B[k % 5] @ u
        assert np.isclose(spent, expected, rtol=1e-10)


def test_a_period_of_equal_steps_is_the_ordinary_regulator():
    A, B = np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[0.005], [0.1]])
    Q, R = np.diag([1e-6, 0.0]), np.array([[100.0]])  # slow: 1e4 steps of the recursion
    expected = solve_discrete_are(A, B, Q, R)
    for p in (1, 3):
        law = periodic_lqr(np.tile(A, (p, 1, 1)), np.tile(B, (p, 1, 1)), Q, R)
        assert np.allclose(law.costs, expected, rtol=1e-8)


def test_a_double_integrator_without_period_in_the_controls():
    """Controlled only at the first of three steps: each K_1, K_2 is zero."""
    A = np.tile([[1.0, 1.0], [0.0, 1.0]], (3, 1, 1))
    B = np.array([[[0.5], [1.0]], [[0.0], [0.0]], [[0.0], [0.0]]])
    law = periodic_lqr(A, B, np.eye(2), np.eye(1))
    assert np.array_equal(law.gains[1:], np.zeros((2, 1, 2)))
    assert law.spectral_radius < 1.0


A, B = np.array([[[1.0, 0.0], [0.0, 1.2]]]), np.array([[[1.0], [1.0]]])
NAN = np.array([[[np.nan, 0.0], [0.0, 1.0]]])


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((A, np.array([[[1.0], [0.0]]]), np.eye(2), np.eye(1)), ParameterError,
         r"A, B: received a mode with multiplier 1\.2.*no control reaches"),
        ((A, np.array([[[0.0], [1.0]]]), np.eye(2), np.eye(1)), ParameterError,
         "A, B: received a mode with multiplier 1.*no control reaches"),
        ((A, B, np.diag([0.0, 1.0]), np.eye(1)), ParameterError,
         "Q: received a weight with which a closed-loop multiplier has size 1"),
        ((A, B, np.diag([-1.0, 1.0]), np.eye(1)), ParameterError, "Q: .*positive semi-definite"),
        ((A, B, np.array([[1.0, 0.5], [0.0, 1.0]]), np.eye(1)), ParameterError, "Q: .*symmetric"),
        ((A, B, np.eye(2), np.zeros((1, 1))), ParameterError, "R: .*positive definite"),
        ((NAN, B, np.eye(2), np.eye(1)), ParameterError, "A: .*finite"),
        ((A[0], B, np.eye(2), np.eye(1)), ShapeError, r"A: .*required \(p, n, n\)"),
        ((A, B[0], np.eye(2), np.eye(1)), ShapeError, r"B: .*required \(1, 2, m\)"),
        ((A, B, np.eye(3), np.eye(1)), ShapeError, "Q: received"),
        ((A, B, np.eye(2), np.eye(2)), ShapeError, "R: received"),
        ((np.empty((0, 2, 2)), np.empty((0, 2, 1)), np.eye(2), np.eye(1)), ShapeError, "A: "),
    ],
)  # fmt: skip
def test_what_has_no_regulator_is_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        periodic_lqr(*arguments)
