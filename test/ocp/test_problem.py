"""What an optimal control problem accepts and refuses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, ShootingSolver, Weights

INERTIA = np.diag([1.0, 0.8, 0.8])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"horizon": 0}, "horizon"),
        ({"horizon": 2.5}, "horizon"),
        ({"time_step": 0.0}, "time_step"),
        ({"time_step": math.nan}, "time_step"),
        ({"max_torque": -1.0}, "max_torque"),
        ({"max_torque": 0.1, "torque_penalty": 0.0}, "torque_penalty"),
        ({"inertia": np.diag([1.0, 0.1, 0.1])}, "triangle"),
    ],
)
def test_values_that_make_no_problem_are_refused(change, words):
    arguments = {"inertia": INERTIA, "time_step": 0.4, "horizon": 5} | change
    with pytest.raises(ParameterError, match=words):
        AttitudeOcp(**arguments)


@pytest.mark.parametrize(
    ("weights", "words"),
    [
        ({"stage_attitude": -1.0}, "stage_attitude.*semi-definite"),
        ({"stage_torque": 0.0}, "stage_torque.*positive definite"),
        ({"terminal_momentum": [0, 1, 0, 0, 0, 0, 0, 0, 0]}, "terminal_momentum.*symmetric"),
    ],
)
def test_weights_are_checked(weights, words):
    with pytest.raises(ParameterError, match=words):
        Weights(**weights)


def test_weights_of_a_wrong_shape_are_refused():
    with pytest.raises(ShapeError, match="9 numbers"):
        Weights(stage_attitude=[1.0, 2.0])


def test_scalar_nine_numbers_and_matrix_are_the_same_weight():
    for weight in (0.3, (0.3 * np.eye(3)).ravel().tolist(), 0.3 * np.eye(3)):
        assert np.array_equal(Weights(stage_attitude=weight).stage_attitude, 0.3 * np.eye(3))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"kind": "avoid"}, "exclusion"),
        ({"body_axis": [0, 0, 0]}, "body_axis.*non-zero"),
        ({"inertial_axis": [math.nan, 0, 0]}, "inertial_axis"),
        ({"half_angle": 0.0}, "half_angle"),
        ({"penalty": -1.0}, "penalty"),
    ],
)
def test_zones_are_checked(change, words):
    arguments = {
        "kind": "exclusion", "body_axis": [1, 0, 0], "inertial_axis": [0, 1, 0],
        "half_angle": 0.1, "penalty": 1.0,
    }  # fmt: skip
    with pytest.raises(ParameterError, match=words):
        PointingZone(**(arguments | change))


def test_zone_margins_are_angles_to_the_cone():
    away = PointingZone("exclusion", [2, 0, 0], [0, 0, 3], 0.2, 1.0)
    inside = PointingZone("inclusion", [1, 0, 0], [1, 0, 0], 0.2, 1.0)
    turned = lie.exp(np.array([0.0, 0.0, 0.15]))
    assert away.margin(turned) == pytest.approx(0.5 * math.pi - 0.2)
    assert inside.margin(np.stack([np.eye(3), turned])) == pytest.approx([0.2, 0.05])


def test_torques_of_a_wrong_shape_are_refused():
    ocp = AttitudeOcp(INERTIA, 0.4, 5)
    with pytest.raises(ShapeError, match=r"controls.*\(5, 3\)"):
        ocp.cost(np.zeros((4, 3)), np.eye(3), np.zeros(3))


def test_unknown_variants_are_refused():
    with pytest.raises(ParameterError, match="variant"):
        ShootingSolver(AttitudeOcp(INERTIA, 0.4, 5), variant="quick")


@pytest.mark.parametrize("horizon", [10_001, 10**9, 10**30])
def test_a_horizon_beyond_what_a_scenario_may_ask_for_is_refused(horizon: int) -> None:
    with pytest.raises(ParameterError, match=r"horizon: received 1.*; required .* 1 to 10000"):
        AttitudeOcp(inertia=np.eye(3), time_step=0.4, horizon=horizon)
