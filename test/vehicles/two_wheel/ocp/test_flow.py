"""Prediction models: derivatives, and the flow against high-order integration and the plant."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from wheel_problems import EXACT, MODELS, near, report, skew
from wheeled import FULL_INERTIA

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.ocp import _flow_kernels as kernels
from spacecraft_gnc.vehicles.two_wheel.ocp.search import first_attitude, inertial_attitudes
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver

STEP = 1e-6  # of central differences


def buffers():
    return np.empty((2, 3)), np.empty(3), np.empty(4)


def case(model, seed):
    """A step of the skew body, fast enough that every term matters: problem, attitude, speeds."""
    ocp, rng = skew(model), np.random.default_rng(seed)
    return ocp, first_attitude(ocp, near(seed, 0.9), np.eye(3)), rng.uniform(-60, 60, (2, 2))


def step(ocp, first, nu, drift=None):
    """Attitude after one step from the kernel."""
    drift = np.zeros((2, 3)) if drift is None else drift
    a = np.vstack([first, np.zeros_like(first)])
    kernels.advance(MODELS.index(ocp.model), ocp.time_step, ocp.rates, drift, 0, nu, a, *buffers())
    return a[1]


def differences(function, x):
    """Central differences of a function of an array: (..., x.size)."""
    columns = []
    for i in range(x.size):
        move = np.zeros(x.size)
        move[i] = STEP * max(1.0, abs(x.flat[i]))
        ahead, behind = (function(x + s * move.reshape(x.shape)) for s in (1.0, -1.0))
        columns.append((ahead - behind) / (2.0 * move[i]))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("seed", range(3))
def test_the_derivatives_of_a_step_are_those_of_central_differences(model, seed):
    ocp, first, nu = case(model, seed)
    drift = np.random.default_rng(seed).normal(scale=0.05, size=(2, 3))
    na = first.size
    number, V = MODELS.index(model), np.empty((3, 4))
    a = np.vstack([first, first])
    A, D = np.empty((na, na)), np.empty((na, 4))
    arguments = (number, ocp.time_step, ocp.rates, drift, 0, nu, a)
    kernels.linearize(*arguments, A, D, *buffers(), V)
    by_attitude = differences(lambda x: step(ocp, x, nu, drift), first)
    by_speeds = differences(lambda x: step(ocp, first, x, drift), nu)
    assert np.abs(A - by_attitude).max() < 1e-8
    assert np.abs(D - by_speeds).max() < 1e-8


@pytest.mark.parametrize("model", MODELS)
def test_the_second_derivatives_are_differences_of_the_first(model):
    ocp, first, nu = case(model, 5)
    drift, na = np.full((2, 3), 0.01), first.size
    number, lam = MODELS.index(model), np.arange(1.0, na + 1.0)
    V = np.empty((3, 4))

    def slopes(x, speeds):
        A, D = np.empty((na, na)), np.empty((na, 4))
        kernels.linearize(
            number, ocp.time_step, ocp.rates, drift, 0, speeds, np.vstack([x, x]), A, D,
            *buffers(), V,
        )  # fmt: skip
        return lam @ D

    X, H = np.empty((na, 4)), np.empty((4, 4))
    arguments = (number, ocp.time_step, ocp.rates, drift, 0, nu, np.vstack([first, first]))
    kernels.curvature(*arguments, lam, X, H, *buffers(), V)
    assert np.abs(X - differences(lambda x: slopes(x, nu), first).T).max() < 1e-8
    assert np.abs(H - differences(lambda x: slopes(first, x), nu)).max() < 1e-8
    assert np.abs(H - H.T).max() < 1e-14


@pytest.mark.parametrize("model", MODELS)
def test_the_derivatives_of_the_coordinates_are_those_of_central_differences(model):
    _, a, _ = case(model, 7)
    number, na, weights = MODELS.index(model), a.size, np.array([0.7, -1.1, 1.9])

    def chart(x):
        e, E = np.empty(3), np.empty((3, x.size))
        kernels.chart(number, x, e, E)
        return e, E

    M = np.zeros((na, na))
    kernels.add_chart_curvature(number, a, weights, M)
    assert np.abs(chart(a)[1] - differences(lambda x: chart(x)[0], a)).max() < 1e-9
    assert np.abs(M - differences(lambda x: weights @ chart(x)[1], a)).max() < 1e-8


def turned(first, w, duration):
    """Attitude after a rate that is linear in time, by DOP853 on R' = R hat(w)."""

    def slope(t, r):
        x, y, z = w[0] + (w[1] - w[0]) * t / duration
        return (r.reshape(3, 3) @ np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])).ravel()

    found = solve_ivp(slope, (0.0, duration), first.ravel(), "DOP853", rtol=1e-13, atol=1e-13)
    return found.y[:, -1].reshape(3, 3)


@pytest.mark.parametrize("model", EXACT)
def test_a_step_of_the_report_at_its_limits_is_exact_to_a_hundred_nanoradians(model):
    ocp = report(model)
    nu = np.array([[100.0, -100.0], [50.0, -50.0]])  # fastest, and braked by 5 rad/s^2 over 10 s
    rotation = near(3)
    ours = inertial_attitudes(
        ocp, step(ocp, first_attitude(ocp, rotation, np.eye(3)), nu)[None], np.eye(3)
    )[0]
    truth = turned(rotation, nu @ (ocp.frame @ ocp.rates).T, ocp.time_step)
    assert lie.angle_between(ours, truth) < 1e-7


def test_halving_a_step_divides_its_error_by_thirty_two():
    """The flow is of fourth order: the error of a step goes with the fifth power of its length."""
    rotation = near(3)
    w = np.array([[0.9, -0.4, 0.3], [-0.2, 0.8, 0.5]])  # turns by up to a radian in a second
    errors = []
    for duration in (0.8, 0.4):
        turn, d = np.empty(3), np.empty(4)
        ends = np.array([w[0], w[0] + duration * (w[1] - w[0])])
        kernels.turn(duration, ends, turn, d)
        errors.append(lie.angle_between(rotation @ lie.exp(turn), turned(rotation, ends, duration)))
    assert errors[0] > 1e-6
    assert errors[0] / errors[1] == pytest.approx(32.0, rel=0.2)


def test_the_simplified_model_is_the_report_s_differential_equation():
    ocp, first, nu = case("simplified", 11)
    rates = ocp.rates @ nu.T

    def slope(t, x):
        w = rates[:, 0] + (rates[:, 1] - rates[:, 0]) * t / ocp.time_step
        return np.array([w[0], w[1], w[2] + w[1] * x[0]])

    truth = solve_ivp(slope, (0.0, ocp.time_step), first, "DOP853", rtol=1e-13, atol=1e-13)
    assert np.abs(step(ocp, first, nu) - truth.y[:, -1]).max() < 1e-12


def test_the_frame_makes_the_report_s_coefficients_on_principal_axes():
    ocp = report("simplified")
    assert np.array_equal(ocp.frame, np.eye(3))
    assert ocp.rates[0, 0] == pytest.approx(-1.0e-4)  # alpha_1
    assert ocp.rates[1, 1] == pytest.approx(-3.5537e-5, rel=1e-4)  # beta_2
    assert np.count_nonzero(ocp.rates) == 2


@pytest.mark.parametrize("model", EXACT)
def test_the_plant_follows_a_plan_on_any_two_axes(model):
    ocp = skew(model)
    start = near(1)
    plan = SqpSolver(ocp).solve(start, np.zeros(2))
    assert plan.converged
    inertias = np.linalg.norm(ocp.wheels, axis=0)
    plant = Gyrostat(FULL_INERTIA, ocp.wheels / inertias, inertias, ocp.time_step / 50, 60.0, 30.0)
    state = plant.state_from_momentum(start, np.zeros(3), np.zeros(2))
    angles = []
    for k, command in enumerate(plan.accelerations):
        state = plant.step(state, command, 50)
        angles.append(lie.angle_between(state.attitude, plan.attitudes[k + 1]))
        assert state.wheel_speed == pytest.approx(plan.speeds[k + 1], abs=1e-9)
    assert max(angles) < 1e-5
    assert lie.angle_between(state.attitude, np.eye(3)) < 1e-5
    assert np.linalg.norm(state.angular_velocity) < 1e-9


def test_the_plant_follows_a_plan_with_the_drift_of_a_third_wheel():
    ocp = report()
    third = 0.043 * np.array([0.0, 1.0, 0.0])  # spins on, on the axis of wheel 2
    plant = Gyrostat(
        ocp.inertia, np.array([[1, 0, 0], [0, 1, 0], [0, 1, 0]]).T, [0.043] * 3, 1.0, 100.0, 5.0
    )
    start = near(2, 0.2)
    state = plant.state_from_momentum(start, np.zeros(3), [0.0, 0.0, 20.0])
    rate = -np.linalg.solve(ocp.inertia, third) * np.linspace(20.0, 0.0, 31)[:, None]  # braked
    plan = SqpSolver(ocp).solve(start, np.zeros(2), drift=rate)
    assert plan.converged
    for k, command in enumerate(plan.accelerations):
        state = plant.step(state, np.append(command, -20.0 / 300.0), 10)
        assert lie.angle_between(state.attitude, plan.attitudes[k + 1]) < 1e-6
    assert np.linalg.norm(state.angular_velocity) < 1e-12
