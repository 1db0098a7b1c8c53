"""scipy's solvers against the exact one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    FsolveSolver,
    PointingZone,
    ShootingSolver,
    SlsqpSolver,
    Status,
    Weights,
)

BOTH = pytest.mark.parametrize("kind", [SlsqpSolver, FsolveSolver], ids=["slsqp", "fsolve"])
REST = np.zeros(3)


def test_slsqp_agrees_on_case_1(case_1):
    ocp, attitude, momentum = case_1
    exact = ShootingSolver(ocp).solve(attitude, momentum)
    found = SlsqpSolver(ocp).solve(attitude, momentum)
    # Differences of a cost of 1e-2: some 1e-8 in its gradient, which ftol may never call the end.
    assert found.status in (Status.CONVERGED, Status.MAX_ITERATIONS)
    assert np.abs(found.torques - exact.torques).max() < 1e-6
    assert found.cost == pytest.approx(exact.cost, abs=1e-10)
    assert found.formulation == "slsqp"
    assert found.residual < 1e-6
    assert found.torque_margin > -1e-12  # the limit is hard here
    assert math.isnan(found.min_curvature)
    assert np.abs(found.attitudes - exact.attitudes).max() < 1e-6
    assert np.abs(found.costates[:, 3:] - exact.costates[:, 3:]).max() < 1e-6


def test_slsqp_agrees_along_a_flight_and_warm(case_1):
    ocp, R, Pi = case_1
    solver, exact, warm = SlsqpSolver(ocp), ShootingSolver(ocp), None
    converged = 0
    for _ in range(25):
        found, expected = solver.solve(R, Pi, None, warm), exact.solve(R, Pi)
        warm = found.warm_start
        converged += found.converged
        assert np.abs(found.torques - expected.torques).max() < 1e-6
        R, Pi = ocp.body.step(R, Pi, expected.torques[0])
    assert converged >= 24


def test_slsqp_keeps_out_of_a_zone():
    zone = PointingZone("exclusion", [1, 0, 0], [math.cos(0.3), math.sin(0.3), 0.0], 0.2, 1e5)
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.9]), 0.4, 6, Weights(), zones=(zone,))
    attitude, momentum = lie.exp(np.array([0.02, 0.01, 0.55])), np.array([0.0, 0.0, -0.15])
    found = SlsqpSolver(ocp).solve(attitude, momentum)
    exact = ShootingSolver(ocp).solve(attitude, momentum)
    assert found.status is Status.CONVERGED
    # R_2 .. R_{N-1} keep out of the cone; the soft penalty lets them in a little.
    assert zone.margin(found.attitudes[2:-1]).min() > -1e-9
    assert -1e-2 < zone.margin(exact.attitudes[2:-1]).min() < 0.0
    assert np.abs(found.torques - exact.torques).max() < 0.02


def test_slsqp_says_when_it_was_stopped(case_1):
    ocp, attitude, momentum = case_1
    found = SlsqpSolver(ocp, max_iterations=1).solve(attitude, momentum)
    assert found.status is Status.MAX_ITERATIONS
    assert found.warm_start is None


def test_fsolve_agrees_on_case_1_and_certifies(case_1):
    ocp, attitude, momentum = case_1
    exact = ShootingSolver(ocp).solve(attitude, momentum)
    found = FsolveSolver(ocp).solve(attitude, momentum)
    assert found.status is Status.CONVERGED
    assert found.formulation == "fsolve"
    assert np.abs(found.torques - exact.torques).max() < 1e-10
    assert found.cost == pytest.approx(exact.cost, rel=1e-12)
    assert found.min_curvature == pytest.approx(exact.min_curvature, rel=1e-6)
    again = FsolveSolver(ocp).solve(attitude, momentum, None, found.costates)
    assert again.iterations < found.iterations
    assert np.abs(again.torques - exact.torques).max() < 1e-10


def test_fsolve_calls_a_saddle_a_saddle():
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 30)
    found = FsolveSolver(ocp).solve(lie.exp(np.array([math.pi, 0.0, 0.0])), REST)
    assert found.status is Status.SADDLE
    assert found.min_curvature < 0.0


@BOTH
def test_both_track_a_reference_and_actuators(kind):
    B = np.array([[0.9, 0.3, -0.2], [0.1, 1.2, 0.4], [-0.3, 0.2, 0.7]])
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.9]), 0.4, 4, max_torque=0.01, actuators=B)
    attitude, reference = lie.exp(np.array([0.2, 0.1, 0.3])), lie.exp(np.array([-0.1, 0.2, 0.1]))
    exact = ShootingSolver(ocp).solve(attitude, REST, reference)
    found = kind(ocp).solve(attitude, REST, reference)
    assert np.array_equal(found.reference, reference)
    assert np.abs(found.torques - exact.torques).max() < 1e-6
    assert np.linalg.norm(found.controls[0]) <= 0.01 + 1e-8
    assert found.attitude_error == pytest.approx(exact.attitude_error, abs=1e-12)


@BOTH
@pytest.mark.parametrize("speed", [1.95, 3.0, 1e8])
def test_wild_states_give_a_status_not_an_exception(case_1, kind, speed):
    ocp, attitude, momentum = case_1
    solver = kind(ocp)
    before = solver.solve(attitude, momentum)
    wild = solver.solve(attitude, np.array([0.0, speed, 0.0]))
    assert wild.status is Status.UNSOLVABLE_STEP
    assert not wild.converged
    assert wild.warm_start is None
    assert np.isnan(wild.torques).all()  # no plan, rather than the last one's
    after = solver.solve(attitude, momentum)
    assert np.array_equal(after.torques, before.torques)


@BOTH
def test_what_is_no_state_is_refused(case_1, kind):
    with pytest.raises(ParameterError, match="attitude"):
        kind(case_1[0]).solve(np.full((3, 3), np.nan), REST)
