"""Neighboring extremals along a stored run."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import AttitudeOcp, ShootingOptions, ShootingSolver, fly_nominal
from spacecraft_gnc.ocp.linearization import deviation

START = lie.exp(np.array([0.25, 0.5, 0.5]))
N_STEPS = 20


def solver(**options):
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 5, max_torque=0.01)
    return ShootingSolver(ocp, options=ShootingOptions(**options))


@pytest.fixture(scope="module")
def run():
    return fly_nominal(solver(), START, np.zeros(3), N_STEPS)


def test_on_the_run_the_torque_is_the_runs(run):
    for k in range(N_STEPS):
        torque = run.torque(k, run.attitudes[k], run.momenta[k])
        assert torque == pytest.approx(run.torques[k], abs=1e-16)


@pytest.mark.parametrize("angle", [1e-12, 1e-4, 0.1, 1.5, 3.0])
def test_beside_the_run_it_follows_the_gain(run, angle):
    axis = np.array([0.6, -0.48, 0.64])
    momentum = np.array([0.01, -0.02, 0.03])
    for k in (0, 7, N_STEPS - 1):
        attitude = run.attitudes[k] @ lie.exp(angle * axis)
        off = deviation(attitude, momentum, run.attitudes[k], run.momenta[k])
        expected = run.torques[k] + run.gains[k] @ off
        # atan2 near half a turn loses some digits of the axis: 1e-14 of a torque of about 1 N m
        assert run.torque(k, attitude, momentum) == pytest.approx(expected, abs=1e-14)


def test_it_takes_states_in_any_layout(run):
    attitude = np.asfortranarray(START)
    attitude.setflags(write=False)
    torque = run.torque(0, attitude, [0.0, 0.0, 0.0])
    assert torque == pytest.approx(run.torques[0], abs=1e-16)


def test_a_run_that_is_not_solved_is_refused():
    with pytest.raises(ParameterError, match="step 0 is not solved"):
        fly_nominal(solver(max_iterations=1), START, np.zeros(3), N_STEPS)
