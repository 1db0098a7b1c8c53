"""NMPC of the bus with three and more wheels: torque, limits, convergence, fallback."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from strategies import rotations, vectors
from wheeled import AFRL_ACCELERATION, AFRL_SPEED, ORTHOGONAL, PYRAMID, afrl, small

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp import ShootingOptions, ShootingSolver
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Terminal, solve_of
from spacecraft_gnc.vehicles.two_wheel.controllers.shooting.pilot import ShootingPilot
from spacecraft_gnc.vehicles.two_wheel.controllers.shooting.problem import (
    torque_limit,
    torque_problem,
)
from spacecraft_gnc.vehicles.two_wheel.metrics import summarize

TARGET = lie.exp(np.array([0.4, -0.8, 1.2]))
THREE_LEFT = np.array([True, True, False, True])


def fly(plant, pilot, state, n_steps, substeps=10):
    """Return the arguments of `summarize`, and the commands."""
    states, commands = [state], []
    for _ in range(n_steps):
        commands.append(pilot.command(state, TARGET))
        state = plant.step(state, commands[-1].control, substeps)
        states.append(state)
    _, attitudes, rates, speeds, *_ = map(np.array, zip(*(s[:4] for s in states), strict=True))
    times = plant.time_step * substeps * np.arange(n_steps + 1)
    controls = np.array([command.control for command in commands])
    return (times, attitudes, rates, speeds, controls), commands


@given(rotations(), vectors(0.3), vectors(20.0), vectors(3.0))
@settings(deadline=None)
def test_the_bus_gets_the_planned_torque(attitude, rate, speeds, own):
    """J omega' = T - omega x J omega, from the equations of motion, with a fourth wheel's own u."""
    gyrostat = small(PYRAMID, 0.1)
    pilot = ShootingPilot(gyrostat, 0.3, 1.0, 10, np.array([True, True, True, False]))
    state = gyrostat.state_from_rate(attitude, rate, np.append(speeds, -30.0))
    alone = np.array([0.0, 0.0, 0.0, own[0]])
    command = pilot.command(state, TARGET, alone)
    if command.source is not Source.OPTIMAL:
        return
    torque = solve_of(command).torques[0]
    u = command.control + alone
    held = gyrostat.wheels @ state.wheel_speed
    reaction = -np.cross(rate, gyrostat.inertia @ rate + held) - gyrostat.wheels @ u
    expected = torque - np.cross(rate, gyrostat.inertia @ rate)
    assert command.control[3] == 0.0
    assert np.abs(reaction - expected).max() < 1e-12 * max(1.0, np.abs(torque).max())


def test_near_the_target_every_axis_is_critically_damped():
    gyrostat, w, error = small(ORTHOGONAL, 0.1), 0.2, np.array([1e-3, -2e-3, 3e-3])
    pilot = ShootingPilot(gyrostat, w, 1.0, 400)
    start = gyrostat.state_from_rate(TARGET @ lie.exp(error), np.zeros(3), np.zeros(3))
    (times, attitudes, *_), commands = fly(gyrostat, pilot, start, 300, 1)
    found = np.array([lie.log(TARGET.T @ attitude) for attitude in attitudes[::30]])
    decay = (1.0 + w * times[::30]) * np.exp(-w * times[::30])
    assert np.abs(found - np.outer(decay, error)).max() < 0.01 * np.linalg.norm(error)
    assert all(command.source is Source.OPTIMAL for command in commands)


@pytest.mark.parametrize(
    ("axes", "healthy"),
    [(ORTHOGONAL, None), (PYRAMID, None), (PYRAMID, THREE_LEFT)],
    ids=["three", "pyramid", "pyramid, one wheel lost"],
)
def test_it_turns_the_reports_spacecraft_within_the_limits(axes, healthy):
    plant, believed = afrl(axes), afrl(axes, 10.0)
    pilot = ShootingPilot(believed, 0.015, 1.0, 20, healthy)
    for error in ([0.5, 0.3, -0.4], [1.5, -1.0, 1.2]):
        still = np.zeros(plant.n_wheels)
        pilot.reset()
        start = plant.state_from_rate(TARGET @ lie.exp(np.array(error)), np.zeros(3), still)
        flight, commands = fly(plant, pilot, start, 180)
        found = summarize(*flight, TARGET)
        assert found["settle_time"] is not None
        assert found["final_error_deg"] < 1e-3
        assert found["max_wheel_speed"] <= AFRL_SPEED * (1.0 + 1e-15)
        assert found["max_wheel_acceleration"] <= AFRL_ACCELERATION * (1.0 + 1e-15)
        assert sum(command.source is Source.OPTIMAL for command in commands) >= 175
        if healthy is not None:
            assert not flight[3][:, ~healthy].any()


def test_a_wheel_stops_at_its_limit_of_speed_and_not_before():
    gyrostat = afrl(ORTHOGONAL, 10.0)
    pilot = ShootingPilot(gyrostat, 0.1, 1.0, 20)
    start = gyrostat.state_from_rate(lie.exp(np.array([0.0, 0.0, 2.0])), np.zeros(3), np.zeros(3))
    state = start
    for _ in range(3):
        u = pilot.command(state, np.eye(3)).control
        state = gyrostat.step(state, u)
        assert np.abs(u).max() <= AFRL_ACCELERATION
    assert np.abs(state.wheel_speed).max() == pytest.approx(AFRL_SPEED, rel=1e-12)
    assert abs(pilot.command(state, np.eye(3)).control[2]) < 1e-9


def test_what_was_found_is_told():
    gyrostat = afrl(PYRAMID, 10.0)
    pilot = ShootingPilot(gyrostat, 0.015, 1.0, 15, THREE_LEFT)
    start = gyrostat.state_from_rate(np.eye(3), np.zeros(3), np.zeros(4))
    solve = solve_of(pilot.command(start, TARGET))
    assert (solve.method, solve.model, solve.solver) == ("shooting", "rigid_body", "shooting")
    assert solve.status is Status.CONVERGED
    assert solve.terminal is Terminal.FREE
    assert solve.planned.tolist() == THREE_LEFT.tolist()
    assert solve.torques.shape == (15, 3)
    assert solve.attitudes.shape == (16, 3, 3)
    assert solve.min_curvature > 0.0
    assert solve.terminal_violation == lie.angle_between(solve.attitudes[-1], TARGET)
    ocp = pilot.solver.ocp
    gradient = ocp.gradient(solve.torques, TARGET.T, np.zeros(3))
    scale = np.abs(ocp.gradient(np.zeros((15, 3)), TARGET.T, np.zeros(3))).max()
    assert np.abs(gradient).max() < 1e-9 * scale


def test_every_torque_within_the_limit_can_be_allocated():
    gyrostat = afrl(PYRAMID, 10.0)
    pilot = ShootingPilot(gyrostat, 0.015, 1.0, 15)
    limit = torque_limit(gyrostat, pilot.feedback.allocation)
    rng = np.random.default_rng(0)
    torques = rng.normal(size=(2000, 3))
    torques *= limit / np.linalg.norm(torques, axis=1, keepdims=True)
    largest = np.abs(torques @ pilot.feedback.allocation.T).max()
    assert 0.99 * AFRL_ACCELERATION < largest <= AFRL_ACCELERATION
    assert torque_limit(small(PYRAMID, 0.1), pilot.feedback.allocation) == 0.0
    assert torque_problem(small(PYRAMID, 0.1), pilot.feedback.allocation, 0.2, 5).max_torque == 0.0


@pytest.mark.parametrize("bad", ["attitude", "rate"])
def test_a_state_that_is_none_gives_no_acceleration(bad):
    gyrostat = afrl(ORTHOGONAL, 10.0)
    pilot = ShootingPilot(gyrostat, 0.015, 1.0, 20)
    start = gyrostat.state_from_rate(np.eye(3), np.zeros(3), np.zeros(3))
    nan = np.full(3, math.nan)
    broken = start._replace(angular_velocity=nan)
    if bad == "attitude":
        broken = start._replace(attitude=np.full((3, 3), math.nan))
    command = pilot.command(broken, np.eye(3))
    assert command.source is Source.ZERO
    assert not command.control.any()
    assert pilot.command(start, TARGET).source is Source.OPTIMAL


def test_where_a_solve_fails_the_feedback_law_flies():
    gyrostat = afrl(ORTHOGONAL, 10.0)
    pilot = ShootingPilot(gyrostat, 0.015, 1.0, 20)
    pilot.solver = ShootingSolver(pilot.solver.ocp, options=ShootingOptions(max_iterations=1))
    start = gyrostat.state_from_rate(np.eye(3), np.zeros(3), np.zeros(3))
    command = pilot.command(start, TARGET)
    expected = pilot.feedback.acceleration(start, TARGET)
    assert command.source is Source.FEEDBACK
    assert np.array_equal(command.control, expected)
    assert solve_of(command).status is Status.MAX_ITERATIONS


def test_two_wheels_are_refused():
    with pytest.raises(GncError, match="2 healthy wheel") as caught:
        ShootingPilot(afrl(ORTHOGONAL, 10.0), 0.015, 1.0, 20, np.array([True, True, False]))
    assert "\n" not in str(caught.value)
