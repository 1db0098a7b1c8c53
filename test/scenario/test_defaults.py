"""Defaults follow from the spacecraft: their values, and the laws that make them fit any other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from strategies import inertias, rotations

from spacecraft_gnc.ocp import ShootingSolver, linearize
from spacecraft_gnc.scenario import Scenario, from_sections, load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of

DIAGONAL = np.diag([1.0, 0.8, 0.8])
ROUNDED = 1e-11  # defaults keep 12 digits
EXACT_STEP = 1e-6  # [s]: a period is a whole number of nanoseconds, here in units up to 100 s
SOLVED = 3e-5  # relative: a solve ends at a residual, not at the optimum


def scenario(inertia: Any, limit: float = 0.01, **controller: Any) -> Scenario:
    plant = {k: controller.pop(k) for k in ("time_step", "duration") if k in controller}
    plant |= {"inertia": np.ravel(inertia), "initial_rotation_vector": [0.2, 0.4, -0.2]}
    return from_sections({"plant": plant, "nmpc_controller": {"max_torque": limit, **controller}})


def poles(built: Scenario) -> np.ndarray:
    """Return the eigenvalues of one step of the loop at the target, by the solver itself."""
    ocp = problem_of(built)
    return np.linalg.eigvals(
        linearize(ShootingSolver(ocp).solve(np.eye(3), np.zeros(3))).closed_loop
    )


def test_the_numbers_of_a_spacecraft_like_that_of_case_1() -> None:
    """J_max = 1 kg m^2 and U = 0.01 N m: omega = 0.2 rad/s."""
    built = scenario(DIAGONAL)
    c = built.controller
    assert c.settling_time == pytest.approx(4.0 * np.sqrt(1.0 / 0.01), rel=ROUNDED)
    assert built.plant.time_step == 0.5
    assert built.plant.duration == pytest.approx(120.0)
    assert c.horizon == 20
    weights = c.weights
    assert weights.stage_torque == pytest.approx(1e4 * np.eye(3))
    assert weights.stage_momentum == pytest.approx(2.0 * 0.2**2 * 1e4 * np.eye(3))
    # J^2 = diag(1, 0.64, 0.64), tr(J^2) I - 2 J^2 = diag(0.28, 1, 1)
    assert weights.stage_attitude == pytest.approx(16.0 * np.diag([0.28, 1.0, 1.0]))
    slope = np.hypot(1.0 / (19 * 0.5), 0.4)
    assert weights.terminal_attitude == pytest.approx(400.0 * slope * np.diag([0.28, 1.0, 1.0]))
    assert weights.terminal_momentum == pytest.approx(0.4e4 * np.eye(3))
    assert c.torque_penalty == pytest.approx(1e6 * 1e4 / 0.01**2)
    assert c.feedback_attitude_gain == pytest.approx(0.04 * (0.501 * 2.6 * np.eye(3) - DIAGONAL))
    assert c.feedback_momentum_gain == pytest.approx(0.4 * np.eye(3))
    assert built.governor.slew_rate_tolerance == pytest.approx(np.radians(0.1) * 0.2)


def test_what_is_given_counts_and_the_rest_follows_from_it() -> None:
    slow = scenario(DIAGONAL, settling_time=400.0, time_step=1.0, horizon=7)
    assert (slow.period, slow.controller.horizon) == (1.0, 7)
    assert slow.plant.duration == pytest.approx(1200.0)
    assert slow.controller.weights.stage_momentum[0, 0] == pytest.approx(
        2.0 * 0.02**2 * slow.controller.weights.stage_torque[0, 0]
    )
    coarse = scenario(DIAGONAL, time_step=4.0)
    assert coarse.controller.settling_time == pytest.approx(40.0 * 4.0)
    free = scenario(DIAGONAL, limit=0.0, time_step=0.25)
    assert free.controller.settling_time == pytest.approx(80.0 * 0.25)
    assert scenario(DIAGONAL, limit=0.0).controller.settling_time == 60.0


@pytest.mark.parametrize("name", ["stage_torque", "stage_attitude", "terminal_momentum"])
def test_one_weight_sets_the_scale_of_the_others(name: str) -> None:
    """The law does not change when all weights are multiplied: one tells the factor."""
    plain = scenario(DIAGONAL).controller.weights
    doubled = 2.0 * getattr(plain, name)
    other = scenario(DIAGONAL, weights={name: doubled.ravel()}).controller
    for each in ("stage_attitude", "stage_momentum", "stage_torque", "terminal_attitude"):
        assert getattr(other.weights, each) == pytest.approx(2.0 * getattr(plain, each))
    assert other.torque_penalty == pytest.approx(2.0 * scenario(DIAGONAL).controller.torque_penalty)


def test_a_resolved_scenario_resolves_to_itself() -> None:
    for controller in ({}, {"method": "feedback"}, {"time_step": 0.3, "horizon": 9}):
        built = scenario(DIAGONAL, **controller)
        again = from_sections(built.values)
        assert again.values == built.values
        again.build_controller()


@given(st.data(), st.floats(-2.0, 6.0), st.integers(-2, 2))
@settings(max_examples=12, deadline=None)
def test_the_same_flight_in_other_units(data: Any, mass: float, time: int) -> None:
    """A body a J with a limit b U flies as J with U does, in times sqrt(a / b)."""
    inertia = data.draw(inertias())
    a, unit = 10.0**mass, 10.0**time
    b = a / unit**2
    period = scenario(inertia).period
    assert scenario(a * inertia, 0.01 * b).period == pytest.approx(unit * period, abs=EXACT_STEP)
    flights = [
        scenario(m * inertia, 0.01 * u, time_step=t * period, duration=60.0 * t * period)
        .build()
        .run()
        for m, u, t in ((1.0, 1.0, 1.0), (a, b, unit))
    ]
    one, other = flights
    assert len(one.time) == len(other.time) == 60
    assert other.attitude == pytest.approx(one.attitude, abs=SOLVED)
    assert other.torque / b == pytest.approx(one.torque, abs=0.01 * SOLVED)
    assert other.momentum / (b * unit) == pytest.approx(one.momentum, abs=SOLVED)


@given(inertias(), st.floats(1e-4, 0.2), st.integers(2, 60))
@settings(max_examples=60, deadline=None)
@example(DIAGONAL, 0.2, 2)
@example(DIAGONAL, 1e-4, 60)
@example(np.diag([1.0, 1.0, 0.02]), 0.1, 20)
def test_bandwidth_and_damping_at_any_horizon(inertia: Any, step: float, horizon: int) -> None:
    """About each axis the loop is near the double pole exp(-omega h) that the formulas aim at."""
    h = 8.0 * step
    built = scenario(inertia, settling_time=64.0, time_step=h, horizon=horizon)
    own = np.log(poles(built).astype(complex)) / (0.125 * h)
    frequency, damping = np.abs(own), -own.real / np.abs(own)
    principal = np.sort(np.linalg.eigvalsh(inertia))
    regular = principal[2] ** 2 < principal[0] ** 2 + principal[1] ** 2
    highest = 1.9 if regular else 5.0
    assert frequency.max() < highest
    assert frequency.min() > 0.5
    assert damping.min() > 0.7


@given(rotations(), st.floats(0.2, 5.0))
@settings(max_examples=20, deadline=None)
def test_actuators_count_as_what_they_make_of_a_command(axes: Any, gain: float) -> None:
    """With B = gain times a rotation, the loop is that of a limit gain times as large."""
    plain = scenario(DIAGONAL, gain * 0.01)
    turned = scenario(DIAGONAL, 0.01, actuators=(gain * axes).ravel())
    assert turned.controller.settling_time == pytest.approx(plain.controller.settling_time)
    assert np.poly(poles(turned)) == pytest.approx(np.poly(poles(plain)), abs=1e-9)


def test_four_wheels_settle() -> None:
    wheels = [0.6, -0.6, -0.6, 0.6, 0.6, 0.6, -0.6, -0.6, 0.5, 0.5, 0.5, 0.5]
    built = scenario(DIAGONAL, actuators=wheels)
    flight = built.build().run()
    commands = flight.torque @ problem_of(built).allocation.T
    assert np.linalg.norm(commands, axis=1).max() <= 0.01 * 1.001
    assert np.degrees(np.arccos((np.trace(flight.final_attitude) - 1.0) / 2.0)) < 0.1


def test_the_package_names_what_its_figures_rest_on() -> None:
    """The published flights do not move when a formula does."""
    quiet = {"settling_time", "feedback_attitude_gain", "feedback_momentum_gain"}
    for name in ("gupta2015_case1", "gupta2015_case2", "governed_nmpc", "sun_moon"):
        built = load(shipped(name))
        taken = {
            f"{section}.{key}"
            for section, defaults in built.defaults.items()
            for key in defaults
            if key not in flat(built.sections.get(section, {}))
        }
        assert taken == {f"nmpc_controller.{key}" for key in quiet}


def flat(nested: Any, prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in nested.items():
        found |= (
            flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {prefix + key: value}
        )
    return found


def test_settling_is_never_longer_than_the_duration_that_follows() -> None:
    tumbling = from_sections(
        {
            "plant": {"inertia": DIAGONAL.ravel(), "initial_momentum": [0.05, -0.1, 0.02]},
            "nmpc_controller": {"max_torque": 0.01},
        }
    )
    flight = tumbling.build().run()
    assert np.degrees(np.arccos(min(1.0, (np.trace(flight.final_attitude) - 1.0) / 2.0))) < 0.1
    assert np.linalg.norm(flight.torque, axis=1).max() <= 0.01 * 1.001
