"""Solutions: fields that are made when they are asked for, what may be changed, copies."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, ShootingSolver, Solution
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Reference

OCP = AttitudeOcp(
    np.diag([1.0, 0.8, 0.9]),
    0.4,
    5,
    max_torque=0.01,
    zones=(PointingZone("exclusion", np.eye(3)[2], np.eye(3)[0], 0.3, 1.0),),
)
TURNED, MOMENTUM = lie.exp(np.array([0.2, -0.1, 0.3])), np.array([0.01, 0.0, -0.02])
FIELDS = (*Solution.__annotations__,)


@pytest.fixture
def solver():
    return ShootingSolver(OCP)


def test_a_field_is_made_once(solver):
    found = solver.solve(TURNED, MOMENTUM)
    for name in FIELDS:
        assert getattr(found, name) is getattr(found, name)


def test_all_fields_belong_to_the_plan_that_was_found(solver):
    found = solver.solve(TURNED, MOMENTUM, lie.exp(np.array([0.0, 0.0, 0.1])))
    n = OCP.horizon
    assert found.torques.shape == (n, 3)
    assert found.attitudes.shape == (n + 1, 3, 3)
    assert found.momenta.shape == (n + 1, 3)
    assert found.multipliers.shape == (n + 1, 6)
    assert found.zone_margins.shape == (1,)
    np.testing.assert_array_equal(found.attitudes[0], TURNED)
    np.testing.assert_array_equal(found.momenta[0], MOMENTUM)
    assert found.status is Status.CONVERGED
    assert found.cost == pytest.approx(
        OCP.cost(found.torques, TURNED, MOMENTUM, found.reference), rel=1e-12
    )
    margin = OCP.max_torque - np.linalg.norm(found.torques, axis=1).max()
    assert found.torque_margin == pytest.approx(margin, abs=1e-15)
    assert found.attitude_error == pytest.approx(lie.angle_between(found.reference, TURNED))
    ends = found.attitudes[0], found.attitudes[-1]
    assert found.travel == pytest.approx(lie.angle_between(*ends))


def test_later_solves_leave_a_solution_as_it_was(solver):
    target = np.eye(3)
    first = solver.solve(TURNED, MOMENTUM, target)
    target[:] = lie.exp(np.array([0.5, 0.0, 0.0]))
    second = solver.solve(TURNED.T, -MOMENTUM, target)
    np.testing.assert_array_equal(first.reference, np.eye(3))
    np.testing.assert_array_equal(first.attitudes[0], TURNED)
    assert not np.array_equal(first.torques, second.torques)


def test_a_solution_cannot_be_changed_but_replaced(solver):
    found = solver.solve(TURNED, MOMENTUM)
    with pytest.raises(AttributeError, match=r"use replace\(cost=...\)"):
        found.cost = 0.0
    with pytest.raises(AttributeError, match="no attribute 'price'"):
        found.price  # noqa: B018
    other = found.replace(cost=0.0)
    assert other.cost == 0.0
    assert other.torques is found.torques
    assert found.cost > 0.0


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_a_copy_has_the_same_fields(solver, copied):
    found = solver.solve(TURNED, MOMENTUM)
    other = copied(found)
    for name in FIELDS:
        if name != "ocp":
            np.testing.assert_array_equal(getattr(other, name), getattr(found, name))
    back = Solution.of_plain(found.plain(), OCP)
    np.testing.assert_array_equal(back.torques, found.torques)
    assert back.status is Status.CONVERGED


def test_arrays_of_any_layout_and_lists_give_the_same_bits(solver):
    expected = solver.solve(TURNED, MOMENTUM)
    apart = np.zeros((3, 6))
    apart[:, ::2] = TURNED
    frozen = MOMENTUM.copy()
    frozen.setflags(write=False)
    warm = np.zeros((5, 12))[:, ::2]
    for attitude, momentum, guess in [
        (np.asfortranarray(TURNED), MOMENTUM, None),
        (apart[:, ::2], np.repeat(MOMENTUM, 2)[::2], warm),
        (TURNED.tolist(), MOMENTUM.tolist(), warm.tolist()),
        (TURNED, frozen, None),
    ]:
        found = solver.solve(attitude, momentum, np.eye(3), guess)
        np.testing.assert_array_equal(found.torques, expected.torques)


def test_a_reference_that_moved_rests_again(solver):
    still = solver.solve(TURNED, MOMENTUM)
    moving = Reference(np.eye(3), np.array([0.0, 0.0, 0.01]), np.zeros(3))
    moved = solver.solve(TURNED, MOMENTUM, moving)
    np.testing.assert_array_equal(moved.feedforward[0], moving.angular_velocity)
    assert not np.array_equal(moved.torques, still.torques)
    again = solver.solve(TURNED, MOMENTUM)
    np.testing.assert_array_equal(again.torques, still.torques)
    batch = solver.solve_batch(TURNED[None], MOMENTUM[None], moving)
    np.testing.assert_array_equal(batch.torques[0], moved.torques)
    np.testing.assert_array_equal(solver.solve(TURNED, MOMENTUM).torques, still.torques)
