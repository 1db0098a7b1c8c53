"""What the parts of the loop make of a reference that moves."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    ShootingSolver,
    TerminalSetOcp,
    TerminalSetSolver,
)
from spacecraft_gnc.types import Reference, State
from spacecraft_gnc.vehicles.rigid_body.controllers.ladder import FallbackLadder
from spacecraft_gnc.vehicles.rigid_body.controllers.neighboring_extremal.controller import (
    NominalRunController,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import (
    ShootingController,
    SolverController,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.standstill import StandstillMonitor

J = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])
OMEGA = np.array([0.01, 0.02, -0.015])
TAU = np.cross(OMEGA, J @ OMEGA)
STEP = 0.4
OCP = AttitudeOcp(J, STEP, 5, max_torque=0.02)
START = lie.exp(np.array([0.1, -0.2, 0.3]))
STATE = State(0, START @ lie.exp(np.array([0.01, 0.02, -0.01])), J @ OMEGA)


def turned(steps):
    return Reference(START @ lie.exp(steps * STEP * OMEGA), OMEGA, TAU)


def test_the_feedback_law_adds_rate_and_torque():
    law = AttitudeFeedback(0.1 * J, 0.7, J)
    E = START.T @ STATE.attitude
    A_E = 0.1 * J @ E
    e = 2.0 * lie.vee(A_E)
    off = STATE.momentum - J @ (E.T @ OMEGA)
    expected = E.T @ TAU - 0.7 * off - e
    assert np.abs(law.torque(STATE, turned(0)) - expected).max() < 1e-15
    at_rest = Reference(START, np.zeros(3), np.zeros(3))
    assert law.torque(STATE, at_rest).tobytes() == law.torque(STATE, START).tobytes()


def test_the_feedback_law_keeps_its_limit():
    law = AttitudeFeedback(0.1 * J, 0.7, J, 1e-5)
    assert np.linalg.norm(law.torque(STATE, turned(0))) == pytest.approx(1e-5, rel=1e-12)


def test_after_a_plan_the_ladder_corrects_it_for_a_reference_that_moved_on_as_planned():
    ladder = FallbackLadder(OCP)
    plan = ShootingSolver(OCP).solve(*STATE[1:], turned(0))
    ladder.command(STATE, turned(0), plan)
    following = State(1, *OCP.body.step(*STATE[1:], plan.torques[0]))
    command = ladder.command(following, turned(1), None)
    assert command.source is Source.NEIGHBORING_EXTREMAL
    assert np.abs(command.control - plan.torques[1]).max() < 1e-15
    for other in (
        turned(0),
        turned(1)._replace(torque=2.0 * TAU),
        Reference(START, *np.zeros((2, 3))),
    ):
        assert ladder.command(following, other, None).source is Source.SHIFTED_PLAN


def test_without_a_plan_the_ladder_tracks_by_feedback():
    command = FallbackLadder(OCP).command(STATE, turned(0), None)
    assert command.source is Source.FEEDBACK
    law = AttitudeFeedback.critically_damped(J, STEP, 0.02, STEP)
    assert np.allclose(command.control, law.torque(STATE, turned(0)), atol=1e-18)


def test_a_terminal_set_controller_leaves_a_moving_reference_to_the_feedback():
    ocp = TerminalSetOcp(J, STEP, 5, max_torque=0.02, terminal_set="false")
    controller = SolverController(TerminalSetSolver(ocp))
    assert controller.command(STATE, turned(0)).source is Source.FEEDBACK
    assert controller.command(STATE, Reference(START, *np.zeros((2, 3)))).source is Source.OPTIMAL


def test_a_moving_reference_is_no_standstill():
    """Half a turn away at rest, which is one for a reference at rest."""
    monitor = StandstillMonitor(OCP, 0.01)
    state = START @ lie.exp(np.array([math.pi, 0.0, 0.0])), np.zeros(3)
    flat = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), STEP, 5, max_torque=0.02)
    solution = ShootingSolver(flat).solve(*state, START)
    found = StandstillMonitor(flat, 0.01).examine(solution)
    assert found is not None
    moving = solution.replace(feedforward=np.array([OMEGA, TAU]))
    assert StandstillMonitor(flat, 0.01).examine(moving) is None
    assert monitor.may_stand(1.0, 0.0, 0.0, 0.0)


def test_along_a_nominal_run_exact_solves_track_a_moving_reference():
    exact = ShootingController(ShootingSolver(OCP))
    controller = NominalRunController(exact, ShootingSolver(OCP), *STATE[1:], 5, 0)
    command = controller.command(STATE, turned(0))
    assert command.source is Source.OPTIMAL
    assert np.array_equal(
        command.control, ShootingSolver(OCP).solve(*STATE[1:], turned(0)).torques[0]
    )
