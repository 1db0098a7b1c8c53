"""The terminal-set NMPC: printed figures, derivatives, other solvers, limits and feasibility."""

from __future__ import annotations

import copy
import math
import pickle
from pathlib import Path

import numpy as np
import pytest
from terminal_cases import (
    INERTIA,
    REST,
    START,
    flip,
    paper,
    random_case,
    stage_cost,
    total_cost,
    with_level,
)

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import (
    ShootingOptions,
    Status,
    TerminalSetOcp,
    TerminalSetSolver,
    _terminal_kernels,
    linearize,
)

REFERENCE = Path(__file__).parents[1] / "data" / "terminal_set_ipopt.npz"


def z_turn(angle):
    return lie.exp(np.array([0.0, 0.0, angle]))


# --- printed figures -----------------------------------------------------------------------


@pytest.mark.parametrize(("angle", "torque"), [(math.pi, -12.83), (-0.99 * math.pi, 12.71)])
def test_the_torque_flips_its_sign_near_half_a_turn(angle, torque):
    solution = TerminalSetSolver(flip()).solve(z_turn(angle), REST)
    assert solution.converged
    assert solution.torques[0] == pytest.approx([0.0, 0.0, torque], rel=5e-3, abs=1e-9)
    assert solution.terminal_multiplier == 0.0  # the terminal set is not active
    assert solution.terminal_level < flip().level.value


def test_as_printed_five_steps_are_too_few():
    solver = TerminalSetSolver(paper())
    solution = solver.solve(START, REST)
    assert solution.status is Status.INFEASIBLE
    assert solution.warm_start is None
    assert solver.ocp.level.value == pytest.approx(37.8, abs=0.05)
    assert solution.terminal_level == pytest.approx(398.0, abs=0.5)
    assert solver.least_level(START, REST).terminal_level == pytest.approx(397.8924, abs=1e-3)


def test_without_the_kappa_part_five_steps_do_and_the_set_is_not_active():
    solution = TerminalSetSolver(paper(terminal_set="without_kappa")).solve(START, REST)
    assert solution.converged
    assert solution.terminal_multiplier == 0.0
    free = TerminalSetSolver(paper(terminal_set="false")).solve(START, REST)
    assert np.array_equal(free.torques, solution.torques)


def test_the_least_horizon_of_the_printed_problem():
    solver = TerminalSetSolver(paper())
    assert solver.sufficient_horizon(START, REST) == 251
    assert solver.sufficient_horizon(START, REST, largest=250) is None
    assert TerminalSetSolver(paper(250)).solve(START, REST).status is Status.INFEASIBLE
    solution = TerminalSetSolver(paper(251)).solve(START, REST)
    assert solution.converged
    assert solution.terminal_level == pytest.approx(solver.ocp.level.value, rel=2e-9)


# --- derivatives ---------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_the_cost_is_the_printed_one_and_its_derivatives_are_exact(seed):
    rng = np.random.default_rng(seed)
    ocp, attitude, momentum, reference = random_case(rng, limits=(0.0,))
    torques = 0.05 * rng.normal(size=(ocp.horizon, 3))
    at = (attitude, momentum, reference)
    angles = lie.angles_between(ocp.rollout(torques, attitude, momentum)[0], reference)
    if np.abs(np.diff(angles)).sum() + angles[0] < math.pi:
        assert ocp.cost(torques, *at) == pytest.approx(total_cost(ocp, torques, *at), rel=1e-12)
    direction, e = rng.normal(size=torques.shape), 1e-5
    ahead, behind = torques + e * direction, torques - e * direction
    slope = (ocp.cost(ahead, *at) - ocp.cost(behind, *at)) / (2.0 * e)
    size = np.linalg.norm(ocp.gradient(torques, *at)) * np.linalg.norm(direction)
    assert abs(np.sum(ocp.gradient(torques, *at) * direction) - slope) < 1e-7 * size
    hessian = ocp.hessian(torques, *at)
    bend = (ocp.gradient(ahead, *at) - ocp.gradient(behind, *at)).ravel() / (2.0 * e)
    assert np.abs(hessian @ direction.ravel() - bend).max() < 1e-7 * np.abs(bend).max()
    assert np.abs(hessian - hessian.T).max() < 1e-12 * np.abs(hessian).max()


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.2, 0.24, 2.0, math.pi, 4.0, 6.0])
def test_the_derivative_of_the_logarithm(angle):
    axis, e = np.array([0.6, -0.64, 0.48]), 1e-6
    Z = angle * axis
    L = np.array(_terminal_kernels.log_derivative(tuple(Z))).reshape(3, 3)
    y = np.array([0.3, -0.2, 0.5])
    bend = np.array(_terminal_kernels._log_curvature(tuple(Z), tuple(y))).reshape(3, 3)

    def pulled(vector):
        at = np.array(_terminal_kernels.log_derivative(tuple(vector))).reshape(3, 3)
        return at.T @ y

    for column in np.eye(3):
        # exp(Z + e L eta) = exp(Z) exp(e eta) to first order
        turned = lie.exp(Z).T @ lie.exp(Z + e * L @ column)
        assert lie.log(turned) / e == pytest.approx(column, abs=1e-4)
        difference = (pulled(Z + e * column) - pulled(Z - e * column)) / (2.0 * e)
        assert bend @ column == pytest.approx(difference, abs=1e-7)


def test_the_angle_is_continuous_along_the_horizon():
    turns = np.linspace(3.0, 5.5, 12)
    attitudes = np.array([z_turn(angle) for angle in turns])
    reference = tuple(np.eye(3).ravel())
    assert _terminal_kernels.continuous_log(reference, attitudes) == pytest.approx((0, 0, 5.5))
    back = np.ascontiguousarray(attitudes[::-1])
    turned_back = (0.0, 0.0, 3.0 - 2.0 * math.pi)  # the first one's principal angle is negative
    assert _terminal_kernels.continuous_log(reference, back) == pytest.approx(turned_back)


@pytest.mark.parametrize("axis", np.vstack([np.eye(3), [[0.6, 0.0, -0.8], [-0.8, 0.6, 0.0]]]))
def test_half_a_turn_has_one_answer(axis):
    """Both rotation vectors are one attitude: the axis with its largest component positive."""
    solver = TerminalSetSolver(flip())
    answers = [solver.solve(lie.exp(s * math.pi * axis), REST).torques[0] for s in (1.0, -1.0)]
    assert answers[0] == pytest.approx(answers[1], abs=1e-9)
    side = axis if axis.max() > -axis.min() else -axis
    assert answers[0] @ side < -1.0


@pytest.mark.parametrize("seed", range(4))
def test_gains_are_those_of_the_solver(seed):
    """The sweep's feedback gain against central differences; a torque limit acts."""
    rng = np.random.default_rng(seed)
    ocp, attitude, momentum, reference = random_case(rng, limits=(0.1,))
    solver = TerminalSetSolver(ocp)
    solution = solver.solve(attitude, momentum, reference)
    assert solution.converged
    assert np.linalg.norm(solution.torques, axis=1).max() > 0.0999
    gain, e = linearize(solution).gains[0], 1e-6
    for i, column in enumerate(np.eye(6)):

        def first(s, column=column):
            near = (attitude @ lie.exp(s * e * column[:3]), momentum + s * e * column[3:])
            return solver.solve(*near, reference, solution.costates).torques[0]

        difference = (first(1.0) - first(-1.0)) / (2.0 * e)
        assert gain[:, i] == pytest.approx(difference, abs=1e-5 * (1.0 + np.abs(gain).max()))


# --- other solvers -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ipopt():
    with np.load(REFERENCE) as stored:
        return dict(stored)


def test_random_problems_against_ipopt(ipopt):
    active = {"torque limit": 0, "terminal set": 0}
    for i in range(len(ipopt["cost"])):
        p = {name: values[i] for name, values in ipopt.items() if not name.startswith("paper")}
        ocp = TerminalSetOcp(
            p["inertia"], float(p["time_step"]), int(p["horizon"]), p["stage_attitude"],
            p["stage_rate"], p["stage_torque"], float(p["stage_cost_scale"]),
            float(p["max_torque"]), "false",
        )  # fmt: skip
        if np.isfinite(p["level"]):
            ocp = with_level(ocp, float(p["level"]))
        found = TerminalSetSolver(ocp).solve(p["attitude"], p["momentum"], p["reference"])
        assert found.converged
        assert found.cost == pytest.approx(p["cost"], rel=1e-8)
        torques = p["torque"][: ocp.horizon]
        assert np.abs(found.torques - torques).max() < 2e-7 * max(1.0, np.abs(torques).max()), i
        active["torque limit"] += found.torque_margin < 1e-9
        active["terminal set"] += found.terminal_multiplier > 0.0
    assert min(active.values()) >= 8


def test_the_least_admissible_horizon_of_the_paper_against_ipopt(ipopt):
    found = TerminalSetSolver(paper(251)).solve(START, REST)
    assert found.cost == pytest.approx(ipopt["paper_cost"], rel=1e-8)
    assert np.abs(found.torques - ipopt["paper_torque"]).max() < 1e-6


# --- limits and feasibility ----------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_limits_hold_exactly_and_conditions_to_the_tolerance(seed):
    rng = np.random.default_rng(100 + seed)
    ocp, *state = random_case(rng, limits=(0.02, 0.1))
    solver = TerminalSetSolver(ocp)
    free = solver.solve(*state)
    assert free.converged
    least = solver.least_level(*state)
    if not least.converged or least.terminal_level > 0.999 * free.terminal_level:
        return  # nothing for a terminal set to do
    level = math.sqrt(least.terminal_level * free.terminal_level)
    ocp = with_level(ocp, level)
    found = TerminalSetSolver(ocp).solve(*state)
    assert found.converged
    assert np.linalg.norm(found.torques, axis=1).max() <= ocp.max_torque
    assert level * (1.0 - 1e-9) <= found.terminal_level <= level
    assert found.terminal_multiplier > 0.0
    assert found.min_curvature > 0.0
    assert found.cost >= free.cost
    short = TerminalSetSolver(with_level(ocp, 0.9 * least.terminal_level)).solve(*state)
    assert short.status is Status.INFEASIBLE


def test_only_the_relative_attitude_matters():
    rng = np.random.default_rng(5)
    ocp, attitude, momentum, reference = random_case(rng)
    solver = TerminalSetSolver(ocp)
    turned = solver.solve(attitude, momentum, reference)
    plain = solver.solve(reference.T @ attitude, momentum)
    assert plain.torques == pytest.approx(turned.torques, abs=1e-10)
    assert plain.cost == pytest.approx(turned.cost, rel=1e-12)


def test_a_warm_start_finds_the_same():
    solver = TerminalSetSolver(paper(251))
    cold = solver.solve(START, REST)
    assert cold.terminal_multiplier > 0.0
    state = cold.attitudes[1], cold.momenta[1]
    warm, again = solver.solve(*state, None, cold.warm_start), solver.solve(*state)
    assert warm.torques == pytest.approx(again.torques, abs=1e-9)
    assert warm.iterations < again.iterations


def test_the_cost_falls_by_the_stage_cost_and_feasibility_is_kept():
    """Proposition 2: J*(X_1) - J*(X_0) <= -lambda L(X_0, T_0), at every step of a flight."""
    ocp = paper(251)
    solver, state, guess, last = TerminalSetSolver(ocp), (START, REST), None, math.inf
    active = 0
    for _ in range(120):
        found = solver.solve(*state, None, guess)
        assert found.converged
        assert found.cost <= last + 1e-9 * found.cost
        active += found.terminal_multiplier > 0.0
        last = found.cost - stage_cost(ocp, *state, found.torques[0], np.eye(3))
        state, guess = ocp.body.step(*state, found.torques[0]), found.warm_start
    assert active >= 1


def test_a_copy_is_the_same_problem():
    ocp = paper()
    for other in (copy.deepcopy(ocp), pickle.loads(pickle.dumps(ocp))):
        assert np.array_equal(other.data, ocp.data)
        assert other.level == ocp.level
    longer = ocp.with_horizon(7)
    assert (longer.horizon, ocp.horizon) == (7, 5)
    assert len(TerminalSetSolver(longer).solve(START, REST).torques) == 7


def test_a_momentum_that_no_step_exists_for_is_said():
    solver = TerminalSetSolver(paper(terminal_set="false"))
    assert solver.solve(np.eye(3), [0.0, 0.0, 100.0]).status is Status.UNSOLVABLE_STEP


def test_an_iteration_limit_is_said_and_infeasible_is_not():
    options = ShootingOptions(max_iterations=1)
    solver = TerminalSetSolver(paper(terminal_set="false"), options)
    assert solver.solve(lie.exp([1.0, 1.5, -2.0]), [3.0, -2.0, 1.0]).status is not Status.CONVERGED


def test_zones_are_reported_and_change_nothing():
    from spacecraft_gnc.ocp import PointingZone

    zone = PointingZone("exclusion", [1, 0, 0], [1, 0, 0], 0.3, 1e6)
    watched = TerminalSetOcp(INERTIA, 0.1, 5, max_torque=0.02, terminal_set="false", zones=(zone,))
    plain = TerminalSetOcp(INERTIA, 0.1, 5, max_torque=0.02, terminal_set="false")
    seen, unseen = (TerminalSetSolver(ocp).solve(z_turn(0.2), REST) for ocp in (watched, plain))
    assert seen.zone_margins[0] < 0.0
    assert np.array_equal(seen.torques, unseen.torques)
