"""Problems with an actuator matrix B: torque = B u, and the controls u are weighed and limited."""

from __future__ import annotations

import math

import numpy as np
import pytest
from ocp_cases import independent, random_weight
from scipy.optimize import minimize

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, ShootingOptions, ShootingSolver, Weights

INERTIA = np.diag([1.0, 0.8, 0.9])
START = lie.exp(np.array([0.25, 0.5, 0.5]))
MOMENTUM = np.array([0.02, -0.01, 0.03])
STEP = 1e-30  # complex step
C = math.sqrt(1.0 / 3.0)
PYRAMID = C * np.array([[1.0, -1.0, -1.0, 1.0], [1.0, 1.0, -1.0, -1.0], [1.0, 1.0, 1.0, 1.0]])
FLAT = np.array([[1.0, 0.2], [0.0, 0.7], [0.3, -0.5]])  # two actuators
SKEW = np.array([[0.9, 0.3, -0.2], [0.1, 1.2, 0.4], [-0.3, 0.2, 0.7]])
SHAPES = {"pyramid": PYRAMID, "two": FLAT, "skew": SKEW, "one": np.array([[0.0], [0.6], [0.8]])}


def problem(actuators, limit=0.0, penalty=1e4, weights=None, zones=(), horizon=5):
    weights = weights or Weights(stage_torque=0.7)
    return AttitudeOcp(INERTIA, 0.4, horizon, weights, limit, penalty, zones, actuators)


def plain_cost(ocp, attitude, momentum, reference=None):
    """The printed cost of controls (N, m): torque terms in u, dynamics with B u."""
    plain = independent(ocp, reference)
    rolled = independent(ocp, reference)
    rolled.Q3, rolled.alpha = np.zeros((3, 3)), 0.0
    S3 = 0.5 * (np.trace(plain.Q3) * np.eye(3) - plain.Q3)
    if ocp.n_controls != 3:
        S3 = plain.Q3[0, 0] * np.eye(ocp.n_controls)

    def cost(u):
        total = rolled.cost(attitude, momentum, u @ np.asarray(ocp.actuators).T)
        for row in u:
            H0 = row @ row - plain.alpha
            total = total + plain.h * (row @ S3 @ row)
            if plain.alpha > 0.0 and H0.real > 0.0:
                total = total + plain.h * plain.mu0 * H0**2
        return total

    return cost


def complex_gradient(cost, u):
    gradient = np.empty(u.shape)
    for k, i in np.ndindex(*u.shape):
        moved = u.astype(complex)
        moved[k, i] += 1j * STEP
        gradient[k, i] = cost(moved).imag / STEP
    return gradient


def minimum(cost, shape):
    """Independent optimum: BFGS on the plain cost with its complex-step gradient."""
    found = minimize(
        lambda x: cost(x.reshape(shape)), np.zeros(math.prod(shape)),
        jac=lambda x: complex_gradient(cost, x.reshape(shape)).ravel(),
        method="BFGS", options={"gtol": 1e-10},
    )  # fmt: skip
    return found.fun, found.x.reshape(shape)


@pytest.mark.parametrize("limit", [0.0, 0.01], ids=["unlimited", "limited"])
@pytest.mark.parametrize("actuators", SHAPES.values(), ids=SHAPES)
def test_the_optimum_equals_an_independent_minimization(actuators, limit):
    ocp = problem(actuators, limit)
    solution = ShootingSolver(ocp).solve(START, MOMENTUM)
    assert solution.converged
    assert solution.min_curvature > 0.0
    controls = solution.controls
    assert controls.shape == (5, actuators.shape[1])
    # Torques come from the last guess, controls from the costates swept over them.
    apart = np.abs(controls @ actuators.T - solution.torques).max()
    assert apart < 1e-15 + 2.0 * np.linalg.norm(actuators @ actuators.T, 2) * solution.residual
    best, at = minimum(plain_cost(ocp, START, MOMENTUM), controls.shape)
    assert solution.cost == pytest.approx(best, abs=1e-12)
    assert np.abs(controls - at).max() < 1e-7  # what BFGS resolves: its gradient ends at 1e-10
    if limit:  # the limit binds, and the penalty of 1e4 is soft
        assert solution.torque_margin < -0.01 * limit
        largest = np.linalg.norm(controls, axis=1).max()
        assert solution.torque_margin == pytest.approx(limit - largest, abs=1e-12)


def test_a_full_weight_and_a_random_matrix():
    rng = np.random.default_rng(8)
    for _ in range(3):
        B = rng.normal(size=(3, 3))
        ocp = problem(B, 0.05, 1e3, Weights(stage_torque=random_weight(rng, -0.5, 0.5)))
        solution = ShootingSolver(ocp).solve(START, MOMENTUM)
        best, at = minimum(plain_cost(ocp, START, MOMENTUM), (5, 3))
        assert solution.cost == pytest.approx(best, abs=1e-12)
        assert np.abs(solution.controls - at).max() < 1e-7
        # Torques come from the last guess, controls from the costates swept over them.
        apart = np.abs(solution.controls @ B.T - solution.torques).max()
        assert apart < 1e-15 + 2.0 * np.linalg.norm(B @ B.T, 2) * solution.residual


@pytest.mark.parametrize("formulation", ["backward_sweep", "single_shooting"])
def test_the_identity_changes_no_bit(case_1, formulation):
    ocp, attitude, momentum = case_1
    given = AttitudeOcp(ocp.inertia, 0.4, 5, Weights(), 0.01, 1e10, actuators=np.eye(3))
    options = ShootingOptions(formulation=formulation)
    one = ShootingSolver(ocp, options=options).solve(attitude, momentum)
    other = ShootingSolver(given, options=options).solve(attitude, momentum)
    assert np.array_equal(one.torques, other.torques)
    assert np.array_equal(one.costates, other.costates)
    for name in ("cost", "iterations", "residual", "min_curvature"):
        assert getattr(one, name) == getattr(other, name)
    # The controls are read off the final costates, the torques off the last guess: one residual.
    assert np.abs(one.controls - one.torques).max() <= one.residual


@pytest.mark.parametrize("actuators", SHAPES.values(), ids=SHAPES)
def test_a_hard_limit_holds_for_the_controls_not_for_the_torque(actuators):
    ocp = problem(actuators, 0.01, 1e10)
    solution = ShootingSolver(ocp).solve(START, MOMENTUM)
    norms = np.linalg.norm(solution.controls, axis=1)
    # The penalty lets through H0 = |lambda| / (2 mu0 |u|), 1e-10 |u|/lambda: 1e-8 here is ample.
    assert norms.max() == pytest.approx(0.01, abs=1e-8)


@pytest.mark.parametrize("actuators", SHAPES.values(), ids=SHAPES)
def test_single_shooting_finds_the_same(actuators):
    ocp = problem(actuators, 0.01, 1e10)
    swept = ShootingSolver(ocp).solve(START, MOMENTUM)
    options = ShootingOptions(formulation="single_shooting")
    shot = ShootingSolver(ocp, options=options).solve(START, MOMENTUM)
    assert shot.converged
    assert np.abs(shot.controls - swept.controls).max() < 1e-11
    assert shot.min_curvature == pytest.approx(swept.min_curvature, rel=1e-3)


@pytest.mark.parametrize("actuators", SHAPES.values(), ids=SHAPES)
def test_derivatives_equal_complex_steps_and_differences(actuators):
    rng = np.random.default_rng(2)
    zone = PointingZone("inclusion", [1, 0, 0], [0.0, 1.0, 0.0], 0.5, 2.0)  # always violated
    ocp = problem(actuators, 0.1, 100.0, zones=(zone,), horizon=4)
    reference = lie.exp(np.array([0.1, 0.0, 0.2]))
    u = rng.normal(size=(4, actuators.shape[1])) * 0.2
    state = (START, MOMENTUM, reference)
    cost = plain_cost(ocp, *state)
    assert ocp.cost(u, *state) == pytest.approx(cost(u), rel=1e-12)
    gradient = ocp.gradient(u, *state)
    assert np.abs(gradient - complex_gradient(cost, u)).max() < 1e-11 * np.abs(gradient).max()
    hessian, step = ocp.hessian(u, *state), 1e-5
    assert np.abs(hessian - hessian.T).max() < 1e-12 * np.abs(hessian).max()
    for column, direction in enumerate(np.eye(u.size).reshape(-1, *u.shape)):
        ahead = ocp.gradient(u + step * direction, *state)
        behind = ocp.gradient(u - step * direction, *state)
        difference = ((ahead - behind) / (2.0 * step)).ravel()
        # Central differences: truncation step^2 times a third derivative of the penalty, 2400.
        assert np.abs(hessian[:, column] - difference).max() < 1e-6 * np.abs(hessian).max()


def test_two_actuators_cannot_reach_the_third_axis():
    ocp = problem(FLAT, 0.01, 1e10)
    blind = np.cross(FLAT[:, 0], FLAT[:, 1])
    solution = ShootingSolver(ocp).solve(START, MOMENTUM)
    assert np.abs(solution.torques @ blind).max() < 1e-16
    wanted = np.array([0.002, -0.001, 0.003])
    given = ocp.realizable(wanted)
    assert np.abs(FLAT.T @ (wanted - given)).max() < 1e-17  # the rest is out of reach
    large = ocp.realizable(100.0 * wanted)
    assert np.linalg.norm(ocp.allocation @ large) == pytest.approx(0.01, rel=1e-12)
    assert np.abs(np.cross(large, given)).max() < 1e-16


@pytest.mark.parametrize(
    ("actuators", "error", "words"),
    [
        (np.eye(4), ShapeError, r"actuators.*\(3, m\)"),
        (np.ones(9), ShapeError, "actuators.*row order"),
        (np.ones((3, 0)), ShapeError, "actuators"),
        (np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 0.0]]), ParameterError, "column 1 of zeros"),
        (np.array([[1.0, np.nan], [0.0, 1.0], [0.0, 0.0]]), ParameterError, "actuators.*finite"),
        (np.array([[1.0, np.inf], [0.0, 1.0], [0.0, 0.0]]), ParameterError, "actuators.*finite"),
    ],
)
def test_matrices_that_are_none_are_refused(actuators, error, words):
    with pytest.raises(error, match=words):
        problem(actuators)


def test_a_full_torque_weight_is_refused_unless_three_controls_have_it():
    weights = Weights(stage_torque=np.diag([1.0, 2.0, 3.0]))
    assert problem(SKEW, weights=weights).n_controls == 3
    with pytest.raises(ParameterError, match=r"weights\.stage_torque.*4 actuators.*scalar"):
        problem(PYRAMID, weights=weights)


def test_controls_of_a_wrong_shape_are_refused():
    with pytest.raises(ShapeError, match=r"controls.*\(5, 4\)"):
        problem(PYRAMID).cost(np.zeros((5, 3)), START, MOMENTUM)
