"""``method: feedback`` behind the `Controller` protocol."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.loop import Reference, Source, State
from spacecraft_gnc.scenario import from_sections, load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback.controller import FeedbackController

TARGET = Reference(np.eye(3), np.zeros(3), np.zeros(3))
START = State(0, lie.exp(np.array([0.25, 0.5, 0.5])), np.array([0.1, 0.0, -0.2]))
NOWHERE = State(0, np.full((3, 3), np.nan), np.zeros(3))
INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]


def test_gains_and_limit_are_those_of_the_scenario():
    overrides = ["nmpc_controller.max_torque=0.05"]
    controller = load(shipped("kalabic2014_ungoverned"), overrides).build_controller()
    assert isinstance(controller, FeedbackController)
    assert (controller.name, controller.slow, controller.period) == ("feedback", False, 0.1)
    assert np.array_equal(controller.feedback.attitude_gain, np.diag([0.1, 0.2, 0.3]))
    command = controller.command(START, TARGET)
    assert (command.source, command.report, command.status) == (Source.METHOD, None, None)
    assert np.linalg.norm(command.control) == pytest.approx(0.05)


def test_its_default_gains_settle_in_the_wanted_time():
    """Critically damped about each axis; 0.1 % keeps the gain of a flat body definite."""
    sections = {"plant": {"inertia": INERTIA}, "nmpc_controller": {"method": "feedback"}}
    scenario = from_sections(sections)
    law = scenario.build_controller().feedback
    omega = 8.0 / scenario.controller.settling_time
    inertia = np.array(INERTIA).reshape(3, 3)
    assert law.stiffness == pytest.approx(
        omega**2 * (inertia + 0.002 * np.trace(inertia) * np.eye(3))
    )
    assert law.momentum_gain == pytest.approx(2.0 * omega * np.eye(3))


def test_a_state_or_reference_that_is_none_gives_zero_torque_and_no_exception():
    controller = load(shipped("kalabic2014_ungoverned")).build_controller()
    controller.warm_up()
    for state, reference in ((NOWHERE, TARGET), (START, Reference(*NOWHERE[1:], np.zeros(3)))):
        command = controller.command(state, reference)
        assert command.source is Source.ZERO
        assert np.array_equal(command.control, np.zeros(3))
