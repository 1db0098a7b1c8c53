"""Closed loop of a formation: the report's figures, and what the parts say to each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.scenario import Scenario, load
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.geometry import communication_angles_deg, separations

FORMATION = "config/afrl_formation.yaml"


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    return load(FORMATION)


@pytest.fixture(scope="module")
def flight(scenario: Scenario) -> Any:
    return scenario.build().run()


def test_the_governed_flight_has_the_figures_of_the_report(flight: Any) -> None:
    formed = np.flatnonzero(flight.formed)
    assert abs(int(formed[0]) - 73) <= 3
    assert np.linalg.norm(flight.delta_v, axis=2).max() == pytest.approx(0.887, rel=0.01)
    assert flight.separation.min() == pytest.approx(1665.0, rel=0.01)
    assert flight.communication_angle_deg.max() <= 60.0


def test_the_flight_without_a_governor_breaks_all_three_limits() -> None:
    flight: Any = load(f"{FORMATION[:-5]}_ungoverned.yaml").build().run()
    assert np.linalg.norm(flight.delta_v, axis=2).max() == pytest.approx(1.219, rel=0.01)
    assert flight.separation.min() == pytest.approx(579.0, rel=0.01)
    assert flight.communication_angle_deg.max() > 60.0


def test_columns_follow_from_states_and_reference(flight: Any) -> None:
    np.testing.assert_array_equal(flight.separation, separations(flight.position))
    np.testing.assert_array_equal(
        flight.communication_angle_deg,
        communication_angles_deg(flight.position, flight.reference_position),
    )
    assert set(flight.status.tolist()) == {Answer.OPTIMAL}
    assert set(flight.source.tolist()) == {Source.METHOD}
    assert flight.delta_v.shape == flight.position.shape == (flight.n_steps, 3, 3)


def test_the_whole_controller_commands_what_each_craft_s_own_does(scenario: Scenario) -> None:
    controller: Any = scenario.build_controller()
    state = scenario.build_plant().state
    reference = scenario.build_governor().decide(state).reference
    together = controller.command(state, reference).control
    alone = [one.command(state, reference).control for one in controller.craft]
    np.testing.assert_array_equal(together, np.stack(alone), strict=True)


def test_a_state_that_is_no_number_rests_one_craft_only(scenario: Scenario) -> None:
    controller: Any = scenario.build_controller()
    state: Any = scenario.build_plant().state
    reference = scenario.build_governor().decide(state).reference
    torn = state.position.copy()
    torn[1, 2] = np.nan
    command = controller.command(state._replace(position=torn), reference)
    assert command.source is Source.ZERO
    assert (command.control[1] == 0.0).all()
    assert (np.abs(command.control[[0, 2]]).max(axis=1) > 0.0).all()


@pytest.mark.parametrize("law", ["none", "time_shift"])
def test_no_governor_takes_another_target(law: str) -> None:
    governor = load(FORMATION, {"reference_governor.governor": law}).build_governor()
    assert np.asarray(governor.target).tolist() == [16, 0, 33]
    with pytest.raises(ParameterError, match=r"reference_governor\.phase"):
        governor.set_target(np.array([1, 2, 3]))
