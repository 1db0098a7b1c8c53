"""Certificates at the scales at which absolute tolerances used to issue false ones."""

from __future__ import annotations

import copy
import math
import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    NeighboringExtremal,
    NeighboringOptions,
    PenaltyContinuation,
    ShootingOptions,
    ShootingSolver,
    Status,
    TerminalSetOcp,
    TerminalSetSolver,
    Weights,
)

START = lie.exp(np.array([0.25, 0.5, 0.5]))
REST = np.zeros(3)
HEAVY = AttitudeOcp(
    inertia=1e4 * np.diag([1.0, 0.8, 0.8]), time_step=0.4, horizon=5, max_torque=100.0,
    torque_penalty=1e-6,
    weights=Weights(0.01, 1e-10, 1e-10 * np.diag([1.0, 4.0, 9.0]), 0.01, 1e-10),
)  # fmt: skip


def lighter(ocp, mass):
    """The same problem in another unit of mass, in which every number of it is 1 / mass."""
    w = ocp.weights
    return replace(
        ocp, inertia=ocp.inertia / mass, max_torque=ocp.max_torque / mass,
        torque_penalty=ocp.torque_penalty * mass**4,
        weights=Weights(
            w.stage_attitude, mass**2 * w.stage_momentum, mass**2 * w.stage_torque,
            w.terminal_attitude, mass**2 * w.terminal_momentum,
        ),
    )  # fmt: skip


@pytest.mark.parametrize("solver", [ShootingSolver, PenaltyContinuation])
def test_a_small_torque_weight_is_solved_to_its_true_optimum(solver):
    solution = solver(HEAVY).solve(START, REST)
    assert solution.status is Status.CONVERGED
    # Independent: CasADi in units in which all numbers are near 1, IPOPT to 1e-12.
    assert solution.cost == pytest.approx(0.01573856159144, rel=1e-12)
    assert HEAVY.cost(solution.torques, START, REST) == pytest.approx(solution.cost, rel=1e-14)
    excess = -solution.torque_margin
    assert excess == pytest.approx(5.0786e-05, rel=1e-4)
    gradient = HEAVY.gradient(solution.torques, START, REST)
    largest = 2.0 * HEAVY.time_step * np.abs(solution.costates[:, 3:]).max()
    assert np.abs(gradient).max() < 1e-9 * largest  # |u|^2 - max_torque^2 is taken by difference
    light = solver(lighter(HEAVY, 1e4)).solve(START, REST)
    assert np.abs(1e4 * light.torques - solution.torques).max() < 1e-12 * HEAVY.max_torque
    assert light.iterations == solution.iterations


def scaled(ocp, cost):
    """The same problem with its cost counted in another unit."""
    w = ocp.weights
    weights = [cost * np.asarray(getattr(w, name)) for name in Weights.__slots__]
    return replace(ocp, weights=Weights(*weights), torque_penalty=cost * ocp.torque_penalty)


@pytest.mark.parametrize("formulation", ["backward_sweep", "single_shooting"])
@pytest.mark.parametrize("cost", [1e-11, 1e-9, 1e11])
def test_the_unit_of_the_cost_changes_nothing(case_1, cost, formulation):
    ocp, attitude, momentum = case_1
    options = ShootingOptions(formulation=formulation)
    ours, theirs = (ShootingSolver(p, options=options) for p in (ocp, scaled(ocp, cost)))
    warm = other_warm = None
    for _ in range(60):
        solution = ours.solve(attitude, momentum, warm_start=warm)
        other = theirs.solve(attitude, momentum, warm_start=other_warm)
        assert other.status is solution.status is Status.CONVERGED
        assert other.iterations == solution.iterations > 0
        assert np.abs(other.torques - solution.torques).max() < 1e-12 * ocp.max_torque
        warm, other_warm = solution.warm_start, other.warm_start
        attitude, momentum = ocp.body.step(attitude, momentum, solution.torques[0])


def test_at_rest_on_the_target_zero_torque_is_the_solution_in_any_unit(case_1):
    ocp = case_1[0]
    target = lie.exp(np.array([0.3, -2.0, 0.9]))
    for cost in (1e-12, 1.0, 1e12):
        solution = ShootingSolver(scaled(ocp, cost)).solve(target, REST, target)
        assert solution.status is Status.CONVERGED
        assert np.abs(solution.torques).max() < 1e-15


def terminal():
    return TerminalSetSolver(
        TerminalSetOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 10, terminal_set="without_kappa")
    )


@pytest.mark.parametrize("make", [lambda: ShootingSolver(HEAVY), terminal])
def test_one_solver_in_many_threads_gives_the_solutions_of_one_thread(make):
    rng = np.random.default_rng(5)
    starts = [lie.exp(rng.uniform(-0.4, 0.4, 3)) for _ in range(40)]
    solver = make()
    alone = [solver.solve(start, REST).torques for start in starts]
    with ThreadPoolExecutor(8) as pool:
        for _ in range(5):
            together = pool.map(lambda start: solver.solve(start, REST).torques, starts)
            for ours, theirs in zip(alone, together, strict=True):
                assert np.array_equal(ours, theirs)


def test_neighboring_extremals_in_many_threads_are_within_their_tolerance():
    rng = np.random.default_rng(6)
    starts = [START @ lie.exp(rng.uniform(-1e-3, 1e-3, 3)) for _ in range(60)]
    exact = [ShootingSolver(HEAVY).solve(start, REST).torques[0] for start in starts]
    sequence = NeighboringExtremal(HEAVY, NeighboringOptions(1e-3, 50))
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda start: sequence.solve(start, REST), starts))
    assert sequence.corrected + sequence.solved == len(starts)
    for ours, theirs in zip(exact, together, strict=True):
        assert np.linalg.norm(ours - theirs.torques[0]) <= 2e-3 * HEAVY.max_torque


@pytest.mark.parametrize("make", [lambda: ShootingSolver(HEAVY), terminal])
def test_a_copy_of_a_solver_has_work_space_of_its_own(make):
    solver = make()
    here = solver.solve(START, REST)
    for other in (copy.deepcopy(solver), pickle.loads(pickle.dumps(solver))):
        assert np.array_equal(other.solve(START, REST).torques, here.torques)
        other.solve(lie.exp(np.array([0.1, 0.0, 0.0])), REST)  # and not in that of the other
        assert np.array_equal(solver.solve(START, REST).torques, here.torques)


def test_a_copy_of_a_sequence_begins_anew():
    sequence = NeighboringExtremal(HEAVY, NeighboringOptions(1e-3, 7))
    here = sequence.solve(START, REST)
    for other in (copy.deepcopy(sequence), pickle.loads(pickle.dumps(sequence))):
        assert np.array_equal(other.solve(START, REST).torques, here.torques)
        assert (other.solved, other.neighboring.max_age) == (1, 7)
    sequence.solve(START, REST)
    assert (sequence.solved, sequence.corrected) == (1, 1)  # the copies moved nothing here


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_a_warm_start_that_is_not_finite_is_refused(bad):
    guess = np.zeros((5, 6))
    guess[3, 1] = bad
    solver = ShootingSolver(HEAVY)
    with pytest.raises(ParameterError, match="warm_start: received NaN or infinity; required"):
        solver.solve(START, REST, None, guess)
    with pytest.raises(ParameterError, match=r"warm_starts: .*required finite"):
        solver.solve_batch(START[None], REST[None], None, guess[None])
    assert solver.solve(START, REST).converged  # and nothing is left behind


def test_a_complex_warm_start_is_refused():
    with pytest.raises(ShapeError, match="warm_start"):
        ShootingSolver(HEAVY).solve(START, REST, None, np.zeros((5, 6), complex))


@pytest.mark.parametrize(("weight", "horizon"), [(1e6, 60), (1e8, 20), (1e10, 60)])
def test_weights_that_an_axis_does_not_see_loosen_none_of_its_torques(case_1, weight, horizon):
    """A turn about x does not see Q_x; it used to widen what counted as rounding."""
    start = lie.exp(np.array([2.0, 0.0, 0.0]))
    plain = replace(case_1[0], horizon=horizon)
    attitude = np.diag([weight, 0.01, 0.01])
    seen = replace(plain.weights, stage_attitude=attitude, terminal_attitude=attitude)
    expected = ShootingSolver(plain).solve(start, REST)
    found = ShootingSolver(replace(plain, weights=seen)).solve(start, REST)
    assert found.status is expected.status is Status.CONVERGED
    largest = np.abs(expected.torques).max()
    assert np.abs(found.torques - expected.torques)[:, 0].max() < 1e-11 * largest


@pytest.mark.parametrize("angle", [1e-4, 1e-6])
def test_a_long_horizon_near_the_target_is_solved_to_its_optimum(case_1, angle):
    ocp, start = replace(case_1[0], horizon=120), lie.exp(angle * np.array([0.6, -0.64, 0.48]))
    found = ShootingSolver(ocp).solve(start, REST)
    gradient = ocp.gradient(found.controls, start, REST)
    step = np.linalg.solve(ocp.hessian(found.controls, start, REST), gradient.ravel())
    assert found.status is Status.CONVERGED
    assert np.abs(step).max() < 1e-9 * np.abs(found.controls).max()


@pytest.mark.parametrize("penalty", [1e-8, 1e-6, 1e-4, 1.0, 1e8])
def test_a_soft_torque_limit_is_solved_like_a_hard_one(penalty):
    ocp = AttitudeOcp(np.eye(3), 0.4, 5, Weights(), 0.005, penalty)
    found = ShootingSolver(ocp).solve(START, REST)
    assert found.status is Status.CONVERGED
    assert found.cost == pytest.approx(ocp.cost(found.torques, START, REST), rel=1e-14)


def test_the_controls_make_the_torques_that_were_planned():
    rng = np.random.default_rng(8)
    for m in (2, 3, 4):
        ocp = replace(HEAVY, actuators=rng.normal(size=(3, m)), weights=Weights(0.01, 1e-10, 1e-10))
        sequence = NeighboringExtremal(ocp, NeighboringOptions(1e-2, 50))
        for angle in (0.0, 1e-3):  # an exact solve, and a correction
            found = sequence.solve(START @ lie.exp(np.array([angle, 0.0, 0.0])), REST)
            made = found.controls @ np.asarray(ocp.torque_map).T
            assert np.abs(made - found.torques).max() < 1e-12 * np.abs(found.torques).max()
        assert found.controls.shape == (5, m)


def test_a_momentum_beyond_all_measure_ends_as_unsolvable_not_as_leftovers():
    solver = ShootingSolver(HEAVY)
    far = np.array([1e200, 0.0, 0.0])
    assert solver.solve(START, far).status is Status.UNSOLVABLE_STEP
    batch = solver.solve_batch([START, START], [REST, far])
    assert batch.status.tolist() == [Status.CONVERGED, Status.UNSOLVABLE_STEP]
    with pytest.raises(ParameterError, match=r"momenta\[1\]"):
        solver.solve_batch([START, START], [REST, np.array([0.0, math.nan, 0.0])])


def test_what_is_written_into_a_solution_of_a_sequence_is_not_in_the_next():
    again = []
    for written in (False, True):
        sequence = NeighboringExtremal(HEAVY)
        sequence.solve(START, REST)
        corrected = sequence.solve(START, REST)
        if written:
            corrected.reference[...] = corrected.multipliers[...] = 2.0
        again.append(sequence.solve(START, REST))
    assert [found.formulation for found in again] == ["neighboring_extremal"] * 2
    np.testing.assert_array_equal(again[1].reference, np.eye(3))
    np.testing.assert_array_equal(again[1].torques, again[0].torques)
