"""The proof that a transfer is too short: sound for every motion there is, and near the truth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from transfer_cases import paper_transfer

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ocp.transfer import AttitudeTransfer, TransferSolver, shortest_possible_steps
from spacecraft_gnc.ocp.transfer.certificate import _gyroscopic, is_too_short
from spacecraft_gnc.status import Status

_SLACK = 1.0 + 1e-12  # of the bounds, for rounding


def random_body(numbers, time_step):
    moments = np.sort(numbers.uniform(1.0, 2.0, 3))
    moments[2] = min(moments[2], moments[0] + moments[1] - 0.05)
    turn = lie.exp(numbers.standard_normal(3)) if numbers.random() < 0.5 else np.eye(3)
    return RigidBody(turn @ np.diag(moments) @ turn.T, time_step)


def bang_bang(numbers, body, n_steps):
    """Return the transfer that full torques with a few switches make, within their bounds."""
    torque, momentum = numbers.uniform(0.2, 2.0, 3), numbers.choice([0.8, 1e3]) * np.ones(3)
    h, Pi = body.time_step, numbers.uniform(-0.5, 0.5, 3) * numbers.integers(0, 2)
    first, R, signs = Pi, np.eye(3), numbers.choice([-1.0, 1.0], 3)
    for k in range(n_steps):
        R, drifted = body.step(R, Pi, np.zeros(3))
        signs = numbers.choice([-1.0, 1.0], 3) if numbers.random() < 0.1 else signs
        u = np.clip(signs * torque, (-momentum - drifted) / h, (momentum - drifted) / h)
        assume((np.abs(u) <= torque * _SLACK).all() or k == n_steps - 1)
        Pi = drifted + h * np.clip(u, -torque, torque)
    return AttitudeTransfer(
        body=body, n_steps=n_steps, goal=R, start_momentum=first, goal_momentum=Pi,
        torque=torque * _SLACK, momentum=momentum * _SLACK,
    )  # fmt: skip


@settings(max_examples=150)
@given(st.integers(0, 2**32), st.sampled_from([0.02, 0.1, 0.3]), st.integers(2, 40))
def test_no_motion_is_ruled_out(seed, time_step, n_steps):
    numbers = np.random.default_rng(seed)
    try:
        transfer = bang_bang(numbers, random_body(numbers, time_step), n_steps)
    except GncError:  # a step that does not exist
        assume(False)
    assert not is_too_short(transfer, n_steps)


@settings(max_examples=50)
@given(st.integers(0, 2**32))
def test_what_is_too_short_stays_so_with_fewer_steps(seed):
    """Else `shortest_possible_steps` would be no lower bound: it bisects."""
    numbers = np.random.default_rng(seed)
    transfer = AttitudeTransfer(
        body=random_body(numbers, 0.1), n_steps=2, goal=lie.exp(numbers.uniform(-1.5, 1.5, 3)),
        start_momentum=numbers.uniform(-0.7, 0.7, 3), goal_momentum=numbers.uniform(-0.7, 0.7, 3),
        torque=numbers.uniform(0.5, 2.0, 3), momentum=0.8,
    )  # fmt: skip
    verdicts = [is_too_short(transfer, n) for n in range(2, 60)]
    assert verdicts == sorted(verdicts, reverse=True)
    assert verdicts.index(False) + 2 == shortest_possible_steps(transfer)


@pytest.mark.parametrize("seed", range(20))
def test_gyroscopic_coupling_is_bounded(seed):
    numbers = np.random.default_rng(seed)
    inverse = np.linalg.inv(random_body(numbers, 0.1).inertia)
    size, most = numbers.uniform(0.0, 2.0, 3), np.zeros(3)
    for _ in range(200):
        p = numbers.uniform(-1.0, 1.0, 3) * size
        most = np.maximum(most, np.abs(np.cross(inverse @ p, p)))
    bound = np.einsum("ijk,j,k->i", _gyroscopic(inverse), size, size)
    assert (most <= bound * _SLACK).all()
    assert (bound <= 5.0 * most).all()


@pytest.mark.parametrize(
    ("axis", "degrees", "feasible"),
    [((1, 0, 0), 10, 53), ((0, 1, 0), 90, 250), ((0, 0, 1), 60, 172), ((1, 1, 1), 90, 177)],
)
def test_bound_is_near_the_shortest_plan(axis, degrees, feasible):
    least = shortest_possible_steps(paper_transfer(degrees, axis, 30.0))
    assert 0.89 * feasible < least <= feasible


def test_bound_grows_with_the_angle():
    least = [
        shortest_possible_steps(paper_transfer(degrees, (1.0, 2.0, 3.0), 30.0))
        for degrees in (0.0, 1.0, 10.0, 45.0, 90.0, 179.0)
    ]
    assert least == sorted(least)
    assert least[0] == 2


def test_one_unlimited_axis_proves_nothing_that_is_not_so():
    torque = (-20.0, [20.0, math.inf, 20.0])
    unlimited = paper_transfer(90.0, (0.0, 1.0, 0.0), 30.0, torque=torque)
    limited = paper_transfer(90.0, (0.0, 1.0, 0.0), 30.0)
    assert 2 < shortest_possible_steps(unlimited) < shortest_possible_steps(limited)
    no_bounds = paper_transfer(90.0, (0.0, 1.0, 0.0), 30.0, torque=None, momentum=None)
    assert shortest_possible_steps(no_bounds) == 2


def test_swing_of_an_axis_rules_out_what_the_transfer_s_own_does_not():
    """Near the y axis, the torque about y limits: x and z cannot help and return."""
    transfer = paper_transfer(26.0, (-0.17, 0.98, -0.03), 9.3)
    assert not is_too_short(transfer, transfer.n_steps, thorough=False)
    assert is_too_short(transfer, transfer.n_steps)
    plan = TransferSolver().solve(transfer)
    assert plan.status == Status.INFEASIBLE
    assert "no torque makes it in less than 10" in plan.reason
    assert all(one.status != Status.INFEASIBLE for one in plan.tried)


def test_what_is_neither_found_nor_ruled_out_is_told():
    plan = TransferSolver().solve(paper_transfer(90.0, (1.0, 0.0, 0.0), 20.0))
    assert plan.status not in (Status.INFEASIBLE, Status.CONVERGED)
    assert "no plan was found (eigenaxis: singular, " in plan.reason
    assert "nor a proof" in plan.reason
