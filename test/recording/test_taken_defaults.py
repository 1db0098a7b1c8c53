"""A recording is read with the defaults that it took, whatever the formulas give today."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flown_bags import fly

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.reader import load_run
from spacecraft_gnc.scenario import Scenario, from_sections
from spacecraft_gnc.scenario.recorded import parse_scenario
from spacecraft_gnc.vehicles.rigid_body.parameters import defaults, known

INERTIA = [2.0, 0.0, 0.0, 0.0, 1.8, 0.0, 0.0, 0.0, 1.5]
LEFT_OPEN: dict[str, dict[str, Any]] = {
    "plant": {"inertia": INERTIA, "initial_rotation_vector": [0.2, 0.1, -0.3], "duration": 6.0},
    "nmpc_controller": {"max_torque": 0.3},
}
"""About ten steps; time step, horizon, weights and penalty follow."""
FORMER = """\
plant:
  ros__parameters:
    inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
nmpc_controller:
  ros__parameters:
    zone_names: [star]
    zones:
      star: {body_axis: [1.0, 0.0, 0.0], inertial_axis: [0.0, 0.0, 1.0], half_angle_deg: 5.0}
"""


@pytest.fixture
def other_formulas(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the formulas give other numbers, as a later version might."""
    monkeypatch.setattr(known, "SETTLING", 5.0)
    monkeypatch.setattr(defaults, "SETTLING", 5.0)
    monkeypatch.setattr(defaults, "STEPS", 50.0)


def recorded(path: Path) -> Scenario:
    scenario = load_run(path).info.scenario
    assert scenario is not None
    return scenario


def test_a_bag_is_audited_with_what_flew(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    flown = from_sections(LEFT_OPEN)
    bag = fly(tmp_path, LEFT_OPEN)
    request.getfixturevalue("other_formulas")
    assert from_sections(LEFT_OPEN).values != flown.values
    assert recorded(bag).values == flown.values
    audit = audit_bag(bag)
    assert audit.passed, audit.first


def test_so_is_a_file_of_simulate(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    flown = from_sections(LEFT_OPEN)
    file = (
        flown.build().run().save(tmp_path / "flight.npz", flown.to_yaml(), flown.stated_defaults())
    )
    request.getfixturevalue("other_formulas")
    assert recorded(file).values == flown.values


def test_what_states_everything_needs_no_defaults(tmp_path: Path) -> None:
    stated = from_sections(from_sections(LEFT_OPEN).values)
    assert stated.stated_defaults().count("\n") <= 2  # a comment
    file = (
        stated.build()
        .run()
        .save(tmp_path / "flight.npz", stated.to_yaml(), stated.stated_defaults())
    )
    assert recorded(file).values == stated.values


def test_a_recording_without_any_took_those_of_case_1() -> None:
    """It is one of before they followed from the spacecraft."""
    scenario, problem = parse_scenario(FORMER, Path("bag"))
    assert scenario is not None, problem
    plant, controller = scenario.plant, scenario.controller
    assert (plant.time_step, plant.duration, scenario.n_steps) == (0.4, 150.0, 375)
    assert (controller.horizon, controller.max_torque) == (5, 0.01)
    assert controller.torque_penalty == 1e10
    for name in ("stage_attitude", "stage_momentum", "terminal_attitude", "terminal_momentum"):
        np.testing.assert_array_equal(getattr(controller.weights, name), 0.01 * np.eye(3))
    np.testing.assert_array_equal(controller.weights.stage_torque, np.eye(3))
    assert controller.zones[0].penalty == 1000.0
    assert scenario.governor.slew_rate_tolerance == 1e-3


def test_a_recorded_pd_without_gains_had_those_of_its_period() -> None:
    text = FORMER.replace("zone_names: [star]", "method: feedback\n    zone_names: [star]")
    scenario, problem = parse_scenario(text, Path("bag"))
    assert scenario is not None, problem
    omega = 0.05 / 0.4
    gain = 0.5 * omega**2 * np.diag([1.0, 0.8, 0.8])
    np.testing.assert_allclose(scenario.controller.feedback_attitude_gain, gain, rtol=1e-15)
    np.testing.assert_allclose(
        scenario.controller.feedback_momentum_gain, 2.0 * omega * np.eye(3), rtol=1e-15
    )


@pytest.mark.parametrize(
    "damage",
    ["horizon: many", "weights: {stage_torque: -1.0}", "horizon: 0", "torque_penalty: .nan"],
)
def test_damaged_defaults_are_a_reason_and_no_traceback(damage: str) -> None:
    damaged = f"nmpc_controller: {{ros__parameters: {{{damage}}}}}"
    scenario, problem = parse_scenario(FORMER, Path("bag"), defaults=damaged)
    assert scenario is None
    assert "in the defaults that the recording states" in problem or "received" in problem


def test_defaults_of_what_the_scenario_has_not_are_left_out() -> None:
    stray = "nmpc_controller: {ros__parameters: {zones: {moon: {penalty: 1.0}}, horizon: 4}}"
    scenario, problem = parse_scenario(FORMER, Path("bag"), defaults=stray)
    assert scenario is not None, problem
    assert scenario.controller.horizon == 4
    assert "zones.moon.penalty" not in scenario.values["nmpc_controller"]


def test_a_default_that_no_formula_gives_is_refused(tmp_path: Path) -> None:
    """It would loosen an audit without a word in the scenario."""
    text = (
        "plant:\n  ros__parameters:\n    inertia: [2.0, 0.0, 0.0, 0.0, 1.8, 0.0, 0.0, 0.0, 1.5]\n"
    )
    loose = "nmpc_controller:\n  ros__parameters:\n    residual_tolerance: 1.0\n"
    scenario, why = parse_scenario(text, tmp_path, None, loose)
    assert scenario is None
    assert "nmpc_controller.residual_tolerance: received as a default" in why
