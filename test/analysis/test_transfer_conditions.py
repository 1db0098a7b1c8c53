"""The audit's own conditions of a transfer: against differences of the Lagrangian, and on plans."""

from __future__ import annotations

import numpy as np
import pytest
from transfer_cases import BODY, figure_4, paper_transfer, random_transfer
from transfer_plans import least_curvature, second_variation, transfer_of

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.transfer import TransferSolver
from spacecraft_gnc.ocp.transfer.starts import STRAIGHT, make_start
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.rigid_body.audit.transfer_conditions import (
    Transfer,
    first_order,
    linearization,
)
from spacecraft_gnc.vehicles.rigid_body.audit.transfer_curvature import is_curved

FULL = RigidBody([[900.0, 50.0, -80.0], [50.0, 1300.0, 30.0], [-80.0, 30.0, 1000.0]], 0.2)
N = 14
NO_BOUNDS = np.repeat([[-np.inf], [np.inf]] * 2, 3, axis=1)


def stationary(seed):
    """Return a plan without bounds whose multipliers make any motion stationary."""
    numbers = np.random.default_rng(seed)
    torques = 30.0 * numbers.standard_normal((N, 3))
    start = lie.exp(numbers.standard_normal(3))
    attitudes, momenta = FULL.simulate(start, 60.0 * numbers.standard_normal(3), torques)
    beta, gamma = 40.0 * numbers.standard_normal((N + 1, 3)), np.zeros((N, 3))
    beta[[0, -1]] = 0.0
    c, h = 3e3 * numbers.standard_normal(3), FULL.time_step
    zeta = h**2 * attitudes[1].T @ attitudes[-1] @ c
    plan = Transfer(
        FULL.inertia, h, NO_BOUNDS, attitudes[-1], attitudes, momenta, torques, gamma, zeta,
        np.zeros((N, 3)), beta,
    )  # fmt: skip
    A, _, C = linearization(plan)
    gamma[-1] = 30.0 * numbers.standard_normal(3)
    for k in range(N - 1, 0, -1):
        gamma[k - 1] = h * beta[k] + A[k].T @ gamma[k] + h * C[k].T @ c
    return plan._replace(torque_multipliers=-torques - gamma)


def lagrangian(plan, change):
    """Return the Lagrangian of torques that differ by ``change``, by a roll-out."""
    torques = plan.torques + change.reshape(-1, 3)
    attitudes, momenta = FULL.simulate(plan.attitudes[0], plan.momenta[0], torques)
    value = 0.5 * np.sum(torques**2) + np.sum(plan.torque_multipliers * torques)
    value += np.sum(plan.momentum_multipliers * momenta)
    value += plan.co_momenta[-1] / plan.time_step @ momenta[-1]
    return value + plan.end_price @ lie.log(plan.goal.T @ attitudes[-1])


@pytest.mark.parametrize("seed", range(3))
def test_gradient_and_hessian_are_those_of_the_lagrangian(seed):
    plan = stationary(seed)
    found = first_order(plan)
    assert max(found.rotations, found.turns, found.momenta, found.end_attitude) < 1e-12
    assert max(found.torques, found.co_momenta) < 1e-12
    assert found.branch == 0.0
    numbers = np.random.default_rng([seed, 1])
    hessian = second_variation(plan).hessian
    for _ in range(6):
        along = numbers.standard_normal(3 * N)
        sides = [lagrangian(plan, size * along) for size in (-2e-2, -1e-2, 0.0, 1e-2, 2e-2)]
        slope = (sides[0] - 8.0 * sides[1] + 8.0 * sides[3] - sides[4]) / 12e-2
        bend = (-sides[0] + 16.0 * sides[1] - 30.0 * sides[2] + 16.0 * sides[3] - sides[4]) / 12e-4
        assert abs(slope) < 1e-7 * abs(plan.torques @ along.reshape(-1, 3).T).sum()
        assert bend == pytest.approx(along @ hessian @ along, rel=1e-5)


def test_derivatives_of_momenta_and_of_the_end():
    plan = stationary(7)
    found = second_variation(plan)
    along = np.random.default_rng(8).standard_normal(3 * N)
    ends = []
    for size in (-1e-3, 1e-3):
        torques = plan.torques + size * along.reshape(-1, 3)
        ends.append(FULL.simulate(plan.attitudes[0], plan.momenta[0], torques))
    moved = (ends[1][1] - ends[0][1]) / 2e-3
    np.testing.assert_allclose(found.momenta @ along, moved, atol=1e-7)
    turned = lie.log(ends[0][0][-1].T @ ends[1][0][-1]) / 2e-3
    np.testing.assert_allclose(found.end @ along, turned, atol=1e-8)


CASES = {
    "figure 4": figure_4(),
    "y90": paper_transfer(90.0, (0.0, 1.0, 0.0), 30.0),
    "one-sided, with products of inertia": figure_4(
        body=RigidBody(FULL.inertia, 0.25), n_steps=120,
        torque=(np.array([-25.0, -20.0, -np.inf]), np.array([20.0, np.inf, 15.0])),
        momentum=(np.array([-70.0, -np.inf, -60.0]), np.array([np.inf, 75.0, 60.0])),
    ),
    "no bounds": paper_transfer(40.0, (1.0, 2.0, 3.0), 12.0, torque=None, momentum=None),
    "random": random_transfer(22),
}  # fmt: skip


@pytest.fixture(scope="module", params=CASES)
def solved(request):
    solution = TransferSolver().solve(CASES[request.param])
    assert solution.converged
    return solution


def test_a_solution_keeps_the_conditions(solved):
    plan = transfer_of(solved)
    found = first_order(plan)
    assert found.residual < 1e-8
    assert found.residual == pytest.approx(solved.residuals.largest, abs=1e-9)
    assert found.rotations < 1e-14
    assert found.turns < 1e-12
    assert found.branch == 0.0
    least = least_curvature(plan)
    assert solved.min_curvature <= least * (1.0 + 1e-9)
    assert solved.min_curvature == pytest.approx(least, rel=2e-2)
    assert is_curved(plan, least * (1.0 - 1e-5))
    assert not is_curved(plan, least * (1.0 + 1e-5))


SOLVABLE = [
    0,
    1,
    2,
    3,
    4,
    6,
    10,
    11,
    12,
    13,
    15,
    16,
    17,
    18,
    20,
    21,
    22,
    23,
    24,
    25,
    26,
    27,
    28,
    29,
]


@pytest.mark.parametrize("index", SOLVABLE)
def test_the_sweep_finds_the_least_eigenvalue(index):
    solution = TransferSolver().solve(random_transfer(index, 60))
    assert solution.converged
    plan = transfer_of(solution)
    least = least_curvature(plan)
    assert is_curved(plan, least * (1.0 - 1e-5))
    assert not is_curved(plan, least * (1.0 + 1e-5))


@pytest.mark.long
def test_a_saddle_is_none_to_fly():
    """About the axis of the largest moment the eigenaxis plan may be one."""
    straight = paper_transfer(170.0, (0.0, 1.0, 0.0), 60.0, torque=None)
    start = make_start(straight, STRAIGHT)
    solution = TransferSolver().solve(straight, (start.torque, start.momentum))
    assert solution.status == Status.SADDLE
    plan = transfer_of(solution)
    assert first_order(plan).residual < 1e-8
    assert least_curvature(plan) < -0.1
    assert not is_curved(plan, 0.0)


def forged(plan, name, index, by):
    values = getattr(plan, name).copy()
    values[index] += by
    return plan._replace(**{name: values})


FORGERIES = {
    "attitude": ("attitudes", (40, 0, 1), 1e-6, {"rotations", "turns"}),
    "momentum": ("momenta", (40, 0), 1e-5, {"turns", "momenta"}),
    "torque": ("torques", (40, 0), 1e-4, {"torques", "momenta"}),
    "co-momentum": ("co_momenta", (40, 0), 1e-5, {"torques", "co_momenta"}),
    "zeta": ("zeta", 0, 1e-2, {"co_momenta"}),
    "torque multiplier": ("torque_multipliers", (3, 1), 1e-5, {"torques"}),
    "sign of a torque multiplier": ("torque_multipliers", (3, 1), -50.0, {"torques", "signs"}),
    "momentum multiplier": ("momentum_multipliers", (100, 1), 1e-4, {"co_momenta"}),
    "multiplier of an end": ("momentum_multipliers", (190, 0), 1e-4, {"signs"}),
    "bound of the torque": ("limits", (1, 1), -0.01, {"bounds"}),
    "wider bound": ("limits", (1, 1), 0.01, {"signs"}),
    "bound of the momentum": ("limits", (3, 1), -0.01, {"bounds"}),
    "goal": ("goal", (0, 1), 1e-5, {"end_attitude"}),
    "inertia": ("inertia", (0, 0), 0.1, {"turns", "co_momenta"}),
}


@pytest.fixture(scope="module")
def figure():
    return transfer_of(TransferSolver().solve(figure_4()))


@pytest.mark.parametrize("name", FORGERIES)
def test_a_forgery_violates_a_condition(figure, name):
    field, index, by, violated = FORGERIES[name]
    found = first_order(forged(figure, field, index, by))
    beyond = {part for part, value in found._asdict().items() if not value < 1e-8}
    assert violated <= beyond


def test_a_turn_of_another_branch():
    """Half a turn a step solves the implicit equation at rest, too."""
    still = transfer_of(TransferSolver().solve(paper_transfer(0.0, (1.0, 0.0, 0.0), 0.2)))
    half = np.diag([1.0, -1.0, -1.0])
    found = first_order(still._replace(attitudes=np.array([np.eye(3), half, np.eye(3)])))
    assert found.turns < 1e-12
    assert found.branch == 1.0
    assert BODY.time_step == still.time_step
