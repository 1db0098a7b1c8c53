"""Actuators of a plant: they give what is asked for within their limits, and count the rest."""

from __future__ import annotations

import math

import numpy as np
import pytest
from docking_pair import pair, rotation
from hypothesis import given, settings
from hypothesis import strategies as st
from wheeled import PYRAMID, small

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.plant.actuators import Actuators, component_limits, norm_limit
from spacecraft_gnc.plant.disturbances.constant import ConstantTorque
from spacecraft_gnc.plant.disturbances.torques import Disturbances
from spacecraft_gnc.vehicles.docking.plant import DockingPlant
from spacecraft_gnc.vehicles.docking.state import Navigation
from spacecraft_gnc.vehicles.formation.dynamics import FormationMotion
from spacecraft_gnc.vehicles.formation.plant import FormationPlant
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant
from spacecraft_gnc.vehicles.rigid_body.signals import INVARIANTS
from spacecraft_gnc.vehicles.two_wheel.plant import GyrostatPlant

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
CONTROLS = st.lists(NUMBERS, min_size=3, max_size=3).map(np.array)
IMPULSES = st.lists(st.floats(-1e150, 1e150), min_size=3, max_size=3).map(np.array)
LIMITS = st.floats(1e-300, 1e300)
ZERO = np.zeros(3)


@given(CONTROLS, st.lists(LIMITS, min_size=3, max_size=3).map(np.array))
def test_components_are_within_their_limits_and_untouched_there(control, limits):
    cut = component_limits(limits)
    given_ = cut(control)
    within = np.abs(control) <= limits
    assert (np.abs(given_) <= limits).all()
    assert given_[within].tobytes() == control[within].tobytes()
    assert (given_[~within] == np.copysign(limits, control)[~within]).all()
    assert (given_ is control) == within.all()
    assert cut(given_) is given_


@given(st.lists(IMPULSES, min_size=1, max_size=4).map(np.array), st.floats(1e-100, 1e100))
def test_norms_are_within_their_limit_and_keep_their_direction(control, limit):
    given_ = norm_limit(limit)(control)
    size = np.hypot.reduce(control, axis=1)
    assert (np.hypot.reduce(given_, axis=1) <= limit * (1.0 + 1e-12)).all()
    within = size <= limit
    assert given_[within].tobytes() == control[within].tobytes()
    assert ((given_ == 0.0) | (np.sign(given_) == np.sign(control))).all()


def test_without_a_limit_every_control_is_the_same_object():
    assert component_limits(math.inf) is None
    assert component_limits([math.inf, math.inf]) is None
    assert norm_limit(math.inf) is None
    actuators, control = Actuators(None, "N m"), np.array([1e300, 0.0, -1e300])
    assert not actuators.are_limited
    assert actuators.drive(0, control) is control
    assert actuators.shortfalls == 0


def test_steps_are_counted_on_which_more_than_rounding_is_missing():
    actuators = Actuators(component_limits(0.5), "N m")
    for step, largest in enumerate([0.5, 0.5 * (1.0 + 1e-12), 0.6, 1e308, 0.1]):
        actuators.drive(step, np.array([0.2, -largest, 0.0]))
        actuators.given(np.array([9.0, 9.0, 9.0]))  # a question, which drives nothing
    assert actuators.shortfalls == 2
    assert actuators.last.step == 3
    assert str(actuators.last) == (
        "step 3: asked for [0.2, -1e+308, 0] N m, given [0.2, -0.5, 0] N m"
    )
    actuators.reset()
    assert (actuators.shortfalls, actuators.last) == (0, None)


def body(**changes):
    return RigidBodyPlant(RigidBody(np.diag([1.0, 0.8, 0.8]), 0.4), np.eye(3), ZERO, 5, **changes)


def docking():
    start = Navigation(np.array([5.0, 0.4, -0.3]), ZERO, rotation([0.3, -0.2, 0.25]), ZERO)
    return DockingPlant(pair(), start, 5, 1.0, 0.05)


def formation():
    position, velocity = np.eye(3) * 1e3, np.zeros((3, 3))
    return FormationPlant(FormationMotion(350e3, 100.0), position, velocity, 5, 1.0)


def wheels():
    gyrostat = small(PYRAMID, 0.05, max_acceleration=40.0)
    return GyrostatPlant(gyrostat, gyrostat.state_from_rate(np.eye(3), ZERO, np.zeros(4)), 5)


PLANTS = {
    "rigid body": lambda: body(max_torque=0.02),
    "docking": docking,
    "formation": formation,
    "wheels": wheels,
}


MOTION = ("attitude", "momentum", "position", "velocity", "port_offset", "port_velocity",
          "wheel_speed")  # fmt: skip


def parts(state):
    """Return the numbers of a state that tell of the motion."""
    return [getattr(state, name) for name in MOTION if hasattr(state, name)]


@pytest.mark.parametrize("name", PLANTS)
def test_every_plant_counts_what_it_cuts_and_flies_what_is_left(name):
    plant, within = PLANTS[name](), PLANTS[name]()
    rest = plant.idle_control
    plant.step(rest)
    assert plant.actuators.shortfalls == 0
    asked = np.full(rest.shape, 1e6)
    left = plant.actuators.given(asked)
    plant.step(asked)
    assert plant.actuators.shortfalls == 1
    assert plant.actuators.last.step == 1
    assert (plant.actuators.last.asked == asked).all()
    within.step(rest)
    within.step(left)
    assert within.actuators.shortfalls == 0
    for ours, theirs in zip(parts(plant.state), parts(within.state), strict=True):
        assert ours.tobytes() == theirs.tobytes()
    plant.reset()
    assert plant.actuators.shortfalls == 0


@settings(max_examples=30)
@given(CONTROLS)
def test_a_body_with_a_limit_survives_every_torque_and_tells_what_acted(torque):
    plant = body(max_torque=0.02)
    state = plant.step(torque)
    acted = np.clip(torque, -0.02, 0.02)
    assert (np.abs(state.momentum) <= 0.4 * 0.02 * (1.0 + 1e-12)).all()
    told = dict(plant.outputs((torque, 1)))[INVARIANTS]
    assert told[3].tobytes() == acted.tobytes()


def test_a_disturbance_is_no_actuator():
    pushed = Disturbances({"constant": ConstantTorque([0.5, 0.0, 0.0])})
    plant = body(max_torque=0.02, disturbances=pushed)
    state = plant.step(np.array([3.0, 0.0, 0.0]))
    assert state.momentum[0] == pytest.approx(0.4 * (0.5 + 0.02))
    assert (plant.external_torque == [0.5, 0.0, 0.0]).all()


@pytest.mark.parametrize("value", [-1.0, math.nan, math.inf, "1", True])
def test_what_is_no_limit_is_refused(value):
    with pytest.raises(GncError, match=r"max_torque: received .*; required a number >= 0"):
        body(max_torque=value)
