"""What the audit works out of a plan, against formulas that share nothing with the package."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from independent import Problem

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, ShootingSolver
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier, Plans
from spacecraft_gnc.vehicles.rigid_body.audit.problem import Problem as Numbers

TINY = 1e-30  # imaginary step: a complex derivative has no cancellation
STAR = PointingZone("exclusion", [1.0, 0.0, 0.0], [0.9276, 0.3736, 0.0], 0.7, 0.5)
OCP = AttitudeOcp(
    np.diag([1.0, 0.8, 0.8]), 0.4, 4, max_torque=0.01, torque_penalty=1.0e4, zones=(STAR,)
)
CERTIFIER = Certifier(Numbers.of(OCP), ())


def independent(ocp, reference, omega, tau):
    """Return the same problem, written a second time."""
    w, (zone,) = ocp.weights, ocp.zones
    star = (zone.body_axis, zone.inertial_axis, np.cos(zone.half_angle), zone.penalty)
    # exclusion: H = v . R^T d - cos, which that problem writes as beta' - v' . R^T d
    star = (-np.asarray(star[0]), star[1], -star[2], star[3])
    return Problem(
        ocp.body.inertia, ocp.time_step, ocp.horizon, w.stage_attitude, w.stage_momentum,
        w.stage_torque, w.terminal_attitude, w.terminal_momentum, ocp.max_torque**2,
        ocp.torque_penalty, [star], reference, omega, tau,
    )  # fmt: skip


NOTHING = np.zeros((1, 6)), np.zeros((1, 2, 3))  # no costates claimed, a reference at rest


def plan_of(attitude, momentum, torques, reference, feedforward):
    attitudes, momenta = np.empty((1, 5, 3, 3)), np.empty((1, 5, 3))
    attitudes[0], momenta[0] = OCP.rollout(torques, attitude, momentum)
    claimed = np.zeros((1, 6))
    return Plans(
        reference[None], attitudes, momenta, torques[None].copy(), claimed, feedforward[None]
    )


vectors = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).map(np.array)


@settings(max_examples=25)
@given(
    turn=vectors, rate=vectors, target=vectors, seed=st.integers(0, 10_000),
    feedforward=st.one_of(st.just(np.zeros((2, 3))), st.tuples(vectors, vectors).map(np.array)),
)  # fmt: skip
def test_cost_and_residual_are_those_of_the_second_problem(turn, rate, target, seed, feedforward):
    """Of a reference that rests, and of one that moves."""
    feedforward = feedforward * np.array([[0.05], [0.004]])  # [rad/s], [N m]
    ocp, reference = OCP, lie.exp(target)
    attitude, momentum = lie.exp(turn), 0.05 * rate
    torques = np.random.default_rng(seed).uniform(-0.005, 0.005, (4, 3))  # within the limit
    found = CERTIFIER.certify(plan_of(attitude, momentum, torques, reference, feedforward))
    other = independent(ocp, reference, *feedforward)
    cost = other.cost(attitude, momentum, torques)
    assert found.cost[0] == pytest.approx(cost, rel=1e-12)
    gradient = np.empty((4, 3))
    for k in range(4):
        for i in range(3):
            stepped = torques.astype(complex)
            stepped[k, i] += 1j * TINY
            gradient[k, i] = other.cost(attitude, momentum, stepped).imag / TINY
    # dJ/du = 2 h (S u - lambda2), and the residual is its norm over the horizon without the 2 h
    expected = np.linalg.norm(gradient) / (2.0 * ocp.time_step)
    assert found.residual[0] == pytest.approx(expected, rel=1e-9, abs=1e-14)
    assert found.exists[0]
    assert found.momentum_defect[0] < 1e-16


def test_where_the_limit_acts_its_multiplier_is_found_and_the_rest_is_the_residual():
    """At a solution on the limit nothing is left; along the torque, the norm tells."""
    solution = ShootingSolver(OCP).solve(lie.exp([0.9, -0.4, 0.6]), np.zeros(3))
    assert solution.converged
    assert solution.torque_margin < 0.0  # by what the penalty lets through
    plan = Plans(
        np.eye(3)[None], solution.attitudes[None], solution.momenta[None],
        solution.torques[None], *NOTHING,
    )  # fmt: skip
    found = CERTIFIER.certify(plan)
    assert found.residual[0] < 1e-12
    assert found.radius_defect[0] < 1e-15
    np.testing.assert_allclose(found.costates[0], solution.costates[0], rtol=1e-12, atol=1e-15)
    longer = plan._replace(torques=plan.torques * np.array([1.001, 1.0, 1.0, 1.0])[:, None])
    found = CERTIFIER.certify(longer)
    assert found.radius_defect[0] > 0.0005 * OCP.max_torque
    assert found.first_defect[0] > 1e-7


def test_the_curvature_has_the_sign_and_the_bound_of_the_hessian():
    """The last stage's pivot is a block of the Hessian, and no pivot is above its own block."""
    solution = ShootingSolver(OCP).solve(lie.exp([0.3, 0.2, -0.1]), np.zeros(3))
    plan = Plans(
        np.eye(3)[None], solution.attitudes[None], solution.momenta[None],
        solution.torques[None], *NOTHING,
    )  # fmt: skip
    curvature = CERTIFIER.certify(plan).curvature[0]
    hessian = OCP.hessian(solution.torques, solution.attitudes[0], solution.momenta[0])
    smallest = np.linalg.eigvalsh(hessian)[0]
    last = np.linalg.eigvalsh(hessian[-3:, -3:])[0]
    assert 0.0 < smallest <= curvature * (1.0 + 1e-9)
    assert curvature <= last * (1.0 + 1e-9)
