"""Which limits a flight exceeded, and by what factor."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.audit.limits import Exceedance
from spacecraft_gnc.scenario import from_sections, load
from spacecraft_gnc.vehicles.rigid_body.metrics.limits import limits_exceeded

BODY = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
AHEAD = np.eye(3)[None]
REST = np.zeros((1, 3))


def scenario(governor=None, **controller):
    return from_sections(
        {
            "plant": {"inertia": BODY, "initial_rotation_vector": [0.3, 0.0, 0.0]},
            "nmpc_controller": controller,
            "reference_governor": governor or {},
        }
    )


def zone(kind, axis, half_angle_deg):
    star = {
        "kind": kind, "body_axis": [1.0, 0.0, 0.0], "inertial_axis": axis,
        "half_angle_deg": half_angle_deg,
    }  # fmt: skip
    return scenario(zone_names=["star"], zones={"star": star})


@pytest.mark.parametrize(("torque", "told"), [(0.010009, False), (0.010011, True), (4.7, True)])
def test_a_torque_is_told_beyond_a_thousandth_of_its_limit(torque, told):
    largest = np.array([[0.0, 0.003, 0.0], [0.0, 0.0, -torque], [math.nan] * 3])
    found = limits_exceeded(scenario(max_torque=0.01), AHEAD, REST, largest)
    expected = (Exceedance("torque", torque / 0.01, torque, 0.01, "N m"),)
    assert found == (expected if told else ())


def test_without_a_limit_none_is_exceeded():
    assert limits_exceeded(scenario(max_torque=0.0), AHEAD, REST, np.full((1, 3), 1e9)) == ()


def test_with_actuators_the_limit_is_that_of_their_commands():
    half = scenario(max_torque=0.01, actuators=(0.5 * np.eye(3)).ravel().tolist())
    (found,) = limits_exceeded(half, AHEAD, REST, np.array([[0.008, 0.0, 0.0]]))
    assert found.factor == pytest.approx(1.6, rel=1e-12)
    assert found.value == pytest.approx(0.016, rel=1e-12)


def test_a_governors_limits_are_those_of_torque_and_momentum():
    limits = {"governor": "attitude", "max_torque": 0.02, "max_momentum": 0.5}
    governed = scenario(limits, method="feedback", max_torque=0.0)
    momenta = np.array([[0.0, 0.6, 0.0]])
    found = limits_exceeded(governed, AHEAD, momenta, np.array([[0.03, 0.0, 0.0]]))
    told = [(each.limit, round(each.factor, 12), each.unit) for each in found]
    assert told == [("governed torque", 1.5, "N m"), ("momentum", 1.2, "N m s")]
    ungoverned = scenario(method="feedback", max_torque=0.0)
    assert limits_exceeded(ungoverned, AHEAD, momenta, np.array([[0.03, 0.0, 0.0]])) == ()


def test_the_depth_in_a_zone_is_told_as_a_share_of_its_half_angle():
    axis = [math.cos(math.radians(10.0)), math.sin(math.radians(10.0)), 0.0]
    turned = np.stack([lie.exp([0.0, 0.0, -1.0]), lie.exp([0.0, 0.0, math.radians(3.0)])])
    (found,) = limits_exceeded(zone("exclusion", axis, 9.0), turned, REST, REST)  # 7 deg off
    assert (found.limit, found.unit) == ("zone star", "deg")
    assert found.value == pytest.approx(2.0, rel=1e-9)
    assert found.factor == pytest.approx(11.0 / 9.0, rel=1e-9)
    assert limits_exceeded(zone("exclusion", axis, 6.9), turned, REST, REST) == ()
    away = turned[:1]  # 57.3 + 10 deg off
    (found,) = limits_exceeded(zone("inclusion", axis, 15.0), away, REST, REST)
    assert found.factor == pytest.approx((math.degrees(1.0) + 10.0) / 15.0, rel=1e-9)


def test_the_metrics_of_a_flight_tell_them():
    soft = load("gupta2015_case1", {"nmpc_controller.torque_penalty": 1.0, "plant.duration": 4.0,
                                    "launcher.cut_short": True})  # fmt: skip
    flown = soft.build().run()
    metrics = summarize(flown, soft)
    (told,) = metrics["limits_exceeded"]
    assert told["value"] == metrics["max_torque"]
    assert told["factor"] == pytest.approx(metrics["max_torque"] / metrics["torque_limit"])
    assert told["text"].startswith(f"torque {told['factor']:.4g} times (")
    assert summarize(flown)["limits_exceeded"] == []
