"""Plan as a moving reference, and the bounds that its flight keeps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import inertias, rotations, vectors
from transfer_cases import BODY, figure_4

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.planned.guard import BoundGuard
from spacecraft_gnc.governors.planned.motion import PlannedMotion, reference_of
from spacecraft_gnc.ocp import AttitudeOcp, ShootingSolver, Weights
from spacecraft_gnc.ocp._track_kernels import start_of_motion
from spacecraft_gnc.ocp.transfer import TransferSolver

WEIGHTS = Weights(1.0, 0.01, 1.0, 1.0, 0.01)


@pytest.fixture(scope="module")
def plan():
    found = TransferSolver().solve(figure_4())
    assert found.converged
    return found


@given(inertias(), rotations(), vectors(0.3), vectors(1.0), st.floats(0.01, 1.0))
def test_the_solver_makes_momentum_and_torque_of_the_reference(J, R, rate, push, h):
    body = RigidBody(J, h)
    momentum, torque = J @ rate, 0.1 * J @ push
    reference = reference_of(body, R, momentum, torque)
    motion = (tuple(part.tolist()) for part in reference[1:])
    made = np.array(start_of_motion(body.packed, h, *motion))
    size = np.linalg.norm(J) * (1.0 + h)
    assert np.allclose(made, [momentum, torque], rtol=0.0, atol=1e-14 * size)


def test_a_body_at_rest_rests():
    _, rate, torque = reference_of(BODY, np.eye(3), np.zeros(3), np.zeros(3))
    assert not rate.any()
    assert not torque.any()


def test_a_body_on_the_plan_gets_the_torque_of_the_plan(plan):
    solver = ShootingSolver(AttitudeOcp(BODY.inertia, 0.1, 10, WEIGHTS, max_torque=0.0))
    motion = PlannedMotion(plan, 0, 0.1)
    for k in (0, 3, 60, 100, 150, 189):
        here = motion.at(k)
        found = solver.solve(here.attitude, here.momentum, here.reference)
        assert found.converged
        assert np.allclose(found.torques[0], plan.torque[k], rtol=0.0, atol=1e-11)


def test_a_plan_begins_late_and_ends_at_its_goal(plan):
    motion = PlannedMotion(plan, 7, 0.1)
    assert motion.at(0).plan_step == 0
    here = motion.at(10)
    assert here.plan_step == 3
    assert (here.torque == plan.torque[3]).all()
    assert not here.torque.flags.writeable
    for step in (197, 500):
        end = motion.at(step)
        assert end.plan_step == 190
        assert (end.attitude == plan.problem.goal).all()
        assert not np.any([end.momentum, end.torque, *end.reference[1:]])
    assert (motion.torques(195, 4) == [*plan.torque[188:], np.zeros(3), np.zeros(3)]).all()


def limits(torque, momentum):
    return np.array([np.full(3, sign * size) for size in (torque, momentum) for sign in (-1, 1)])


@given(inertias(), vectors(1.0), vectors(20.0))
def test_what_is_clipped_keeps_the_bounds(J, share, torque):
    body, bounds = RigidBody(J, 0.05), limits(3.0, 0.4 * np.linalg.norm(J))
    momentum = 0.4 * np.linalg.norm(J) * share
    if not body.is_solvable(momentum):
        return
    guard = BoundGuard(body, bounds)
    kept = guard.clip(momentum, torque)
    assert (np.abs(kept) <= 3.0).all()
    _, free = body.step(np.eye(3), momentum, np.zeros(3))
    _, following = body.step(np.eye(3), momentum, kept)
    over = np.maximum(np.abs(following) - bounds[3], 0.0)
    # Where the momentum is out of reach of its bounds, the torque brings it back at full size.
    assert ((over <= 1e-9) | (np.abs(kept) == 3.0)).all()
    # A component is changed only where a bound asks for it, and to the nearest value.
    inside = (np.abs(torque) <= 3.0) & (np.abs(free + 0.05 * torque) <= bounds[3])
    assert (kept[inside] == torque[inside]).all()


def test_without_bounds_nothing_is_clipped():
    guard = BoundGuard(BODY, limits(np.inf, np.inf))
    torque = np.array([1e6, -1e6, 3.0])
    assert (guard.clip(np.array([1.0, 2.0, 3.0]), torque) == torque).all()
    assert np.isnan(guard.clip(np.full(3, np.nan), torque)).sum() == 0


def test_a_momentum_without_a_step_leaves_the_torque_bounded():
    guard = BoundGuard(BODY, limits(20.0, 70.0))
    kept = guard.clip(np.array([1e9, 0.0, 0.0]), np.array([30.0, 1.0, -30.0]))
    assert kept.tolist() == [-20.0, 1.0, -20.0]


def test_bounds_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"limits: .*shape"):
        BoundGuard(BODY, np.zeros((2, 3)))
    with pytest.raises((ParameterError, TypeError), match="body"):
        BoundGuard(np.eye(3), limits(1.0, 1.0))
