"""Tracking a reference that moves: against the continuous body, scipy, full solves and itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from ocp_cases import independent, random_problem, random_rotation
from scipy.linalg import expm
from scipy.optimize import minimize

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    AutomaticContinuation,
    EffortContinuation,
    FsolveSolver,
    HorizonContinuation,
    NeighboringExtremal,
    NeighboringOptions,
    PenaltyContinuation,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    SlsqpSolver,
    StateContinuation,
    TerminalSetOcp,
    TerminalSetSolver,
    Weights,
    fly_nominal,
    linearize,
)
from spacecraft_gnc.ocp import _track_kernels as kernels
from spacecraft_gnc.ocp.rollout import track_of
from spacecraft_gnc.types import Reference

J = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])
OMEGA = np.array([0.05, 0.1, -0.07])  # [rad/s], about no principal axis
TAU = np.cross(OMEGA, J @ OMEGA)
START = lie.exp(np.array([0.3, -0.2, 0.5]))
STEP = 0.4
ZONE = PointingZone("exclusion", [1.0, 0.0, 0.0], [0.6, 0.8, 0.0], 0.3, 10.0)
WEIGHTS = Weights(np.diag([1.0, 2.0, 0.5]), 0.01, 1.0, 1.0, 0.01)
OCP = AttitudeOcp(J, STEP, 10, WEIGHTS, max_torque=0.05, torque_penalty=1e6, zones=(ZONE,))
TURN = Reference(START, OMEGA, TAU)
OFF = START @ lie.exp(np.array([0.05, -0.1, 0.02])), np.array([0.01, 0.05, -0.03])


def turned(steps):
    return Reference(START @ expm(lie.hat(steps * STEP * OMEGA)), OMEGA, TAU)


def test_a_turn_at_constant_rate_is_an_equilibrium_of_the_integrator():
    """Also about no principal axis, where neither J omega nor omega x J omega is enough."""
    Pi, u = map(np.array, kernels.start_of_motion(OCP.body.packed, STEP, OMEGA, TAU))
    attitudes, momenta = OCP.body.simulate(START, Pi, u, 200)
    assert np.abs(momenta - Pi).max() < 1e-14
    for k in (1, 50, 200):
        assert lie.angle_between(attitudes[k], turned(k).attitude) < 1e-13
    assert np.abs(Pi - J @ OMEGA).max() > 1e-4
    half = 0.5 * STEP * np.linalg.norm(OMEGA)
    assert np.allclose(u, (math.sin(half) / half) ** 2 * TAU, rtol=1e-12)


def test_a_continuous_body_has_the_plain_momentum_and_torque():
    Pi, u = map(np.array, kernels.start_of_motion(OCP.body.packed, 0.0, OMEGA, 2.0 * TAU))
    assert np.allclose(Pi, J @ OMEGA, rtol=1e-14)
    assert np.allclose(u, 2.0 * TAU, rtol=1e-14)


def test_the_track_turns_at_the_rate_fed_forward():
    track = track_of(OCP, TURN)
    for k in range(OCP.horizon):
        found = np.array(kernels.stage_reference(track, k)).reshape(3, 3)
        assert lie.angle_between(found, turned(k).attitude) < 1e-14
    end = track[kernels.END_AT : kernels.END_AT + 9].reshape(3, 3)
    assert lie.angle_between(end, turned(OCP.horizon).attitude) < 1e-14


def test_a_torque_beyond_that_of_the_turn_accelerates_the_reference():
    acceleration = np.array([1e-3, -2e-3, 1.5e-3])
    track = track_of(OCP, Reference(np.eye(3), np.zeros(3), J @ acceleration))
    end = track[kernels.END_AT : kernels.END_AT + 9].reshape(3, 3)
    time = STEP * OCP.horizon
    assert np.allclose(lie.log(end), 0.5 * acceleration * time**2, rtol=1e-2)


def test_on_its_way_a_body_gets_the_torque_fed_forward_and_costs_nothing():
    Pi, u = map(np.array, kernels.start_of_motion(OCP.body.packed, STEP, OMEGA, TAU))
    solution = ShootingSolver(OCP).solve(START, Pi, TURN)
    assert solution.converged
    assert solution.cost < 1e-28
    assert np.abs(solution.torques - u).max() < 1e-15
    assert np.abs(solution.costates).max() < 1e-14


def test_a_reference_without_motion_is_the_attitude_bit_for_bit():
    solver, zero = ShootingSolver(OCP), np.zeros(3)
    expected = solver.solve(*OFF, START)
    solver.solve(*OFF, TURN)  # leaves nothing behind
    for reference in (START, Reference(START, zero, zero), Reference(START, -zero, zero)):
        found = solver.solve(*OFF, reference)
        for name in ("torques", "multipliers", "attitudes", "momenta", "feedforward"):
            assert getattr(found, name).tobytes() == getattr(expected, name).tobytes(), name
        assert (found.cost, found.residual) == (expected.cost, expected.residual)


@pytest.mark.parametrize("seed", range(6))
def test_the_optimum_is_that_of_scipy_on_the_printed_cost(seed):
    """Penalties included; by BFGS on the independent cost with complex-step gradients."""
    rng = np.random.default_rng(seed)
    ocp, attitude, momentum = random_problem(rng, 6, (1.0, 3.0))
    rate = 0.2 * rng.normal(size=3)
    reference = Reference(
        attitude @ lie.exp(0.3 * rng.normal(size=3)), rate, 0.05 * rng.normal(size=3)
    )
    solution = ShootingSolver(ocp).solve(attitude, momentum, reference)
    assert solution.converged
    plain, shape = independent(ocp, reference), (ocp.horizon, 3)
    assert plain.cost(attitude, momentum, solution.torques) == pytest.approx(
        solution.cost, rel=1e-11
    )

    def value(x):
        return plain.cost(attitude, momentum, x.reshape(shape))

    def slope(x):
        steps = 1e-30j * np.eye(x.size)
        return np.array([value(x.astype(complex) + step).imag for step in steps]) / 1e-30

    found = minimize(value, np.zeros(3 * ocp.horizon), jac=slope, method="BFGS",
                     options={"gtol": 1e-9, "maxiter": 2000})  # fmt: skip
    assert solution.cost <= found.fun * (1.0 + 1e-9)
    if found.fun <= solution.cost * (1.0 + 1e-9):  # the same minimum
        assert np.abs(found.x.reshape(shape) - solution.torques).max() < 1e-5
    assert np.abs(slope(solution.torques.ravel())).max() < 1e-9 * max(1.0, solution.cost)


@pytest.mark.parametrize("formulation", ["backward_sweep", "single_shooting"])
@pytest.mark.parametrize("rule", ["backtracking", "full", "damped", "chord"])
@pytest.mark.parametrize("variant", ["exact", "estimated_du", "estimated_u"])
def test_every_way_to_solve_finds_the_same(formulation, rule, variant):
    ocp = AttitudeOcp(J, STEP, 5, max_torque=0.006, torque_penalty=1e5, zones=(ZONE,))
    expected = ShootingSolver(ocp).solve(*OFF, TURN)
    assert expected.converged
    assert expected.torque_margin < 0.0
    options = ShootingOptions(formulation=formulation, step_rule=rule, max_iterations=200)
    found = ShootingSolver(ocp, variant, options).solve(*OFF, TURN)
    assert found.converged
    assert np.abs(found.torques - expected.torques).max() < 1e-9


def test_the_papers_baselines_find_the_same():
    free = AttitudeOcp(J, STEP, 4, WEIGHTS)
    expected = ShootingSolver(free).solve(*OFF, TURN)
    root = FsolveSolver(free).solve(*OFF, TURN)
    assert root.converged
    assert np.abs(root.torques - expected.torques).max() < 1e-6
    minimum = SlsqpSolver(free).solve(*OFF, TURN, expected.warm_start)
    assert minimum.converged
    assert minimum.cost == pytest.approx(expected.cost, rel=1e-9)
    for found in (root, minimum):
        assert all(map(np.array_equal, found.tracked, TURN))


@pytest.mark.parametrize(
    "kind",
    [
        AutomaticContinuation, EffortContinuation, HorizonContinuation, PenaltyContinuation,
        StateContinuation,
    ],
)  # fmt: skip
def test_every_continuation_leads_to_the_moving_reference(kind):
    expected = ShootingSolver(OCP).solve(*OFF, TURN)
    found = kind(OCP).solve(*OFF, TURN)
    assert found.converged
    assert found.cost == pytest.approx(expected.cost, rel=1e-9)
    assert all(map(np.array_equal, found.tracked, TURN))


def test_a_batch_solves_each_state_as_a_solve_does():
    solver = ShootingSolver(OCP)
    states = [OFF, (START, np.zeros(3)), (np.eye(3), J @ OMEGA)]
    batch = solver.solve_batch(*map(np.array, zip(*states, strict=True)), TURN)
    for i, state in enumerate(states):
        single = solver.solve(*state, TURN)
        assert batch.torques[i].tobytes() == single.torques.tobytes()
        assert batch.cost[i] == single.cost


@pytest.mark.parametrize(
    "actuators",
    [
        np.array([[1.0, -1.0, 0.0, 0.2], [0.0, 1.0, -1.0, 0.1], [0.3, 0.2, 0.1, 1.0]]),
        np.array([[2.0, 0.0, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.5]]),
    ],
)
def test_actuators_make_the_torque_fed_forward(actuators):
    ocp = AttitudeOcp(J, STEP, 5, max_torque=1.0, actuators=actuators)
    Pi, u = map(np.array, kernels.start_of_motion(ocp.body.packed, STEP, OMEGA, TAU))
    solution = ShootingSolver(ocp).solve(START, Pi, TURN)
    assert solution.converged
    assert np.abs(solution.torques - u).max() < 1e-15
    assert np.abs(ocp.gradient(solution.controls, START, Pi, TURN)).max() < 1e-14


def test_gains_are_the_derivative_of_the_torque():
    solver = ShootingSolver(OCP)
    gain = linearize(solver.solve(*OFF, TURN)).gains[0]
    size = 1e-6
    for i in range(6):
        step = size * np.eye(6)[i]
        ends = [
            solver.solve(OFF[0] @ lie.exp(s * step[:3]), OFF[1] + s * step[3:], TURN).torques[0]
            for s in (1.0, -1.0)
        ]
        assert np.allclose((ends[0] - ends[1]) / (2.0 * size), gain[:, i], atol=1e-6)


@pytest.mark.parametrize("zones", [(), (ZONE,)])
@pytest.mark.parametrize("accelerates", [False, True])
def test_neighboring_extremals_follow_a_moving_reference(zones, accelerates):
    """Against a full solve of every step: within the bound claimed, and mostly corrected."""
    ocp = AttitudeOcp(J, STEP, 10, WEIGHTS, max_torque=0.05, zones=zones)
    sequence = NeighboringExtremal(ocp, NeighboringOptions(1e-3, 10))
    exact, (R, Pi) = ShootingSolver(ocp), OFF
    rate, attitude = OMEGA.copy(), START
    for _ in range(120):
        acceleration = 1e-4 * np.array([1.0, -2.0, 1.0]) if accelerates else np.zeros(3)
        reference = Reference(attitude, rate, np.cross(rate, J @ rate) + J @ acceleration)
        found, expected = (solver.solve(R, Pi, reference) for solver in (sequence, exact))
        assert expected.converged
        off = np.linalg.norm(found.torques - expected.torques)
        assert off <= sequence.error_bound + 1e-12
        assert all(map(np.array_equal, found.tracked, reference))
        R, Pi = ocp.body.step(R, Pi, found.torques[0])
        attitude = attitude @ lie.exp(STEP * (rate + 0.5 * STEP * acceleration))
        rate = rate + STEP * acceleration
    assert sequence.hit_rate > 0.6


def test_neighboring_extremals_come_back_to_rest():
    """A reference that stops is followed; one at rest that jumps is solved exactly, as ever."""
    sequence, exact, (R, Pi) = NeighboringExtremal(OCP), ShootingSolver(OCP), OFF
    for reference in (TURN, TURN, START, START, Reference(START, *np.zeros((2, 3))), np.eye(3)):
        found = sequence.solve(R, Pi, reference)
        expected = exact.solve(R, Pi, reference)
        expected.torques[0] = OCP.realizable(expected.torques[0])  # cut to the limit, too
        found.torques[0] = OCP.realizable(found.torques[0])
        assert np.linalg.norm(found.torques - expected.torques) <= sequence.error_bound + 1e-12
        assert all(map(np.array_equal, found.tracked, expected.tracked))
    assert found.iterations > 0


def test_without_a_reference_the_sequence_tracks_the_identity_whatever_it_tracked_before():
    for before in (START, TURN):
        sequence = NeighboringExtremal(OCP)
        sequence.solve(*OFF, before)
        found = sequence.solve(*OFF)
        assert np.array_equal(found.reference, np.eye(3))
        assert not found.feedforward.any()


def test_a_reference_that_turns_too_far_in_a_step_is_refused():
    fast = Reference(np.eye(3), np.array([0.0, 0.0, 9.0]), np.zeros(3))
    words = r"reference: received angular velocity \[0, 0, 9\].*Kalabic et al. 2014, \(3\)"
    for refused in (
        lambda: ShootingSolver(OCP).solve(*OFF, fast),
        lambda: ShootingSolver(OCP).solve_batch(OFF[0][None], OFF[1][None], fast),
        lambda: NeighboringExtremal(OCP).solve(*OFF, fast),
        lambda: FsolveSolver(OCP).solve(*OFF, fast),
        lambda: OCP.cost(np.zeros((10, 3)), *OFF, fast),
    ):
        with pytest.raises(ParameterError, match=words):
            refused()


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"angular_velocity": [0.1, 0.2]}, ShapeError, "reference.angular_velocity"),
        ({"angular_velocity": [0.1, math.nan, 0.0]}, ParameterError, "reference.angular_velocity"),
        ({"torque": [math.inf, 0.0, 0.0]}, ParameterError, "reference.torque"),
        ({"attitude": 2.0 * np.eye(3)}, ParameterError, "reference"),
    ],
)
def test_a_reference_that_is_none_is_refused(change, error, words):
    sequence = NeighboringExtremal(OCP)
    sequence.solve(*OFF, TURN)
    for solver in (ShootingSolver(OCP), sequence, FsolveSolver(OCP), SlsqpSolver(OCP)):
        with pytest.raises(error, match=words):
            solver.solve(*OFF, TURN._replace(**change))


def test_a_warm_start_that_is_none_is_named_whatever_the_reference_does():
    solver, guess = ShootingSolver(OCP), np.full((OCP.horizon, 6), math.nan)
    for reference in (START, TURN):
        with pytest.raises(ParameterError, match="warm_start: received NaN"):
            solver.solve(*OFF, reference, guess)


def test_a_terminal_set_and_a_stored_run_are_for_references_at_rest():
    ocp = TerminalSetOcp(np.diag([10.0, 8.0, 8.0]), 0.1, 5, max_torque=0.02, terminal_set="false")
    solver = TerminalSetSolver(ocp)
    at_rest = Reference(START, np.zeros(3), np.zeros(3))
    assert (
        solver.solve(*OFF, at_rest).torques.tobytes() == solver.solve(*OFF, START).torques.tobytes()
    )
    with pytest.raises(ParameterError, match=r"required a reference at rest.*method shooting"):
        solver.solve(*OFF, TURN)
    with pytest.raises(ParameterError, match="required one at rest"):
        fly_nominal(ShootingSolver(OCP), *OFF, 3, TURN)


def test_random_rotations_of_everything_change_nothing():
    """With weights c I the problem looks the same from every direction: so does its solution."""
    ocp = AttitudeOcp(J, STEP, 8, Weights(1.0, 0.01, 1.0, 1.0, 0.01), max_torque=0.05)
    expected = ShootingSolver(ocp).solve(*OFF, TURN)
    rng = np.random.default_rng(1)
    for _ in range(5):
        S = random_rotation(rng)
        found = ShootingSolver(ocp).solve(S @ OFF[0], OFF[1], Reference(S @ START, OMEGA, TAU))
        assert np.abs(found.torques - expected.torques).max() < 1e-12
