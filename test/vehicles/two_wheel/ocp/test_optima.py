"""Optima of the SQP against IPOPT, and against conditions computed by another code."""

from __future__ import annotations

import numpy as np
import pytest
from wheel_problems import MODELS, REST, SLEW, YAW, cost, near, report, skew

from spacecraft_gnc import lie
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321
from spacecraft_gnc.vehicles.two_wheel.ocp.ipopt import IpoptSolver
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WarmStart
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver

COMPLEX = 1e-30


@pytest.fixture(scope="module", params=MODELS)
def pair(request):
    """Both solvers of the report's problem."""
    ocp = report(request.param)
    return SqpSolver(ocp), IpoptSolver(ocp)


def same_plan(plan):
    """A start at a plan itself."""
    bounds = np.column_stack([plan.speed_multipliers[1:], plan.acceleration_multipliers])
    terminal = np.append(plan.terminal_multipliers[: 0 if plan.soft else 3], np.zeros(2))
    return WarmStart(plan.speeds, terminal, bounds)


def assert_same(one, other):
    assert one.status == other.status == Status.CONVERGED
    assert one.cost == pytest.approx(other.cost, rel=1e-6)
    assert one.accelerations == pytest.approx(other.accelerations, abs=2e-2)


@pytest.mark.parametrize("seed", range(6))
def test_each_solver_stays_at_the_optimum_of_the_other(pair, seed):
    attitude = near(seed, 0.35)
    speed = np.random.default_rng(seed).uniform(-10.0, 10.0, 2)
    for first, second in (pair, pair[::-1]):
        found = first.solve(attitude, speed)
        again = second.solve(attitude, speed, warm_start=same_plan(found))
        assert_same(found, again)
        assert again.restarts == 0
        assert again.min_curvature == pytest.approx(found.min_curvature, rel=0.1)
        assert again.terminal_multipliers == pytest.approx(
            found.terminal_multipliers, rel=1e-3, abs=1e-3
        )


@pytest.mark.parametrize(
    "seed", [10, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(11, 16))]
)
def test_from_the_same_starts_the_sqp_finds_no_dearer_plan(pair, seed):
    attitude = near(seed, 0.35)
    ours, theirs = (solver.solve(attitude, REST) for solver in pair)
    assert ours.converged
    assert theirs.converged
    assert ours.cost <= theirs.cost * (1.0 + 1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_with_a_soft_end_they_agree_beyond_what_is_feasible(pair, seed):
    attitude = near(seed + 20, 0.9)
    for first, second in (pair, pair[::-1]):
        found = first.solve(attitude, REST, soft=True)
        again = second.solve(attitude, REST, soft=True, warm_start=same_plan(found))
        assert_same(found, again)
        assert again.min_curvature == pytest.approx(found.min_curvature, rel=0.25)
        assert not found.terminal_multipliers.any()


def test_on_any_two_axes_with_a_drift_they_agree():
    ocp = skew()
    drift = np.linspace([0.004, -0.002, 0.003], np.zeros(3), ocp.horizon + 1)
    reference = lie.exp(np.array([0.4, -0.2, 0.1]))
    attitude = reference @ near(4, 0.2)
    ours, theirs = (
        solver(ocp).solve(attitude, [5.0, -3.0], reference, drift=drift)
        for solver in (SqpSolver, IpoptSolver)
    )
    assert ours.cost == pytest.approx(theirs.cost, rel=1e-6)
    value, e, speed = cost(ocp, ours.accelerations, attitude, [5.0, -3.0], reference, drift)
    assert ours.cost == pytest.approx(value, rel=1e-8)
    assert np.abs(e).max() < 1e-8
    assert np.abs(speed).max() < 1e-8


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("start", [SLEW, YAW, [0.2, 0.1, -0.1], [-0.3, 0.4, 0.2]])
def test_the_first_order_conditions_hold_by_another_code(model, start):
    """Gradients by the complex step of another roll-out; multipliers as they came."""
    ocp, attitude = report(model), from_euler_321(np.array(start, dtype=float))
    plan = SqpSolver(ocp).solve(attitude, REST)
    assert plan.converged
    value, e, _ = cost(ocp, plan.accelerations, attitude, REST)
    assert plan.cost == pytest.approx(value, rel=1e-8)
    assert np.abs(e).max() < 1e-8
    slope = np.empty_like(plan.accelerations)
    for i in np.ndindex(slope.shape):
        u = plan.accelerations.astype(complex)
        u[i] += COMPLEX * 1j
        v, e, _ = cost(ocp, u, attitude, REST)
        slope[i] = (v + plan.terminal_multipliers @ e).imag / COMPLEX
    later = np.cumsum(plan.speed_multipliers[:0:-1], axis=0)[::-1]  # of the speeds after each u
    slope += plan.acceleration_multipliers + ocp.time_step * later
    spread = np.ptp(slope, axis=0)  # what is left is the multiplier of nu_N = 0
    assert spread.max() < 1e-6 * (1.0 + np.abs(plan.acceleration_multipliers).max())


@pytest.mark.parametrize("solver", [SqpSolver, IpoptSolver])
def test_multipliers_have_the_sign_of_their_bound_and_act_only_at_it(solver):
    ocp = report()
    plan = solver(ocp).solve(from_euler_321(SLEW), [5.0, 0.0])
    assert plan.converged
    for values, multipliers, most in (
        (plan.speeds[1:], plan.speed_multipliers[1:], 100.0),
        (plan.accelerations, plan.acceleration_multipliers, 5.0),
    ):
        assert np.abs(values).max() <= most * (1.0 + 1e-12)
        assert (np.abs(values) > most * (1.0 - 1e-6)).any()
        acts = np.abs(multipliers) > 1e-6
        assert acts.any()
        assert values[acts] == pytest.approx(np.sign(multipliers[acts]) * most, abs=1e-4)
    assert not plan.speed_multipliers[0].any()
    assert plan.speeds[-1] == pytest.approx(REST, abs=1e-12)


def test_a_solution_is_a_minimum_along_feasible_directions():
    """The curvature that is told is that of the cost on the curve of plans that keep the end."""
    ocp, attitude = report("so3", max_speed=0.0, max_acceleration=0.0), near(2, 0.3)
    plan = SqpSolver(ocp).solve(attitude, REST)
    assert plan.converged
    assert np.abs(plan.acceleration_multipliers).max() < 1e-12
    u = plan.accelerations

    def conditions(x):
        _, e, speed = cost(ocp, x, attitude, REST)
        return np.concatenate([e, speed])

    def slopes(x):
        rows = []
        for i in np.ndindex(x.shape):
            y = x.astype(complex)
            y[i] += COMPLEX * 1j
            rows.append(conditions(y).imag / COMPLEX)
        return np.array(rows).T

    rows = slopes(u)
    free = np.linalg.svd(rows)[2][5:]
    rng = np.random.default_rng(0)
    least = np.inf
    for _ in range(20):
        along = (rng.normal(size=len(free)) @ free).reshape(u.shape)
        along /= np.linalg.norm(along)
        values = []
        for length in (-1e-2, 0.0, 1e-2):
            x = u + length * along
            for _ in range(3):  # back to the conditions, by Newton's method
                x = x - (np.linalg.pinv(rows) @ conditions(x)).reshape(u.shape)
            values.append(cost(ocp, x, attitude, REST)[0])
        least = min(least, (values[0] - 2.0 * values[1] + values[2]) / 1e-4)
    assert 0.0 < plan.min_curvature <= least * (1.0 + 1e-3)


def test_pure_yaw_from_rest_is_solved_although_its_linearization_is_singular(pair):
    for solver in pair:
        still = WarmStart(np.zeros((31, 2)), np.zeros(5), np.zeros((30, 4)))
        plan = solver.solve(from_euler_321(YAW), REST, warm_start=still)
        assert plan.converged
        assert plan.restarts > 0 or plan.iterations > 0
        assert np.abs(plan.accelerations[0]).max() > 1.0


def test_at_the_reference_nothing_moves(pair):
    for solver in pair:
        plan = solver.solve(np.eye(3), REST)
        assert plan.converged
        assert plan.cost < 1e-9
        assert np.abs(plan.accelerations).max() < 1e-4
