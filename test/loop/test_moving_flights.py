"""Scenarios whose reference moves: flown without lag, checked, judged and replayed."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.scenario import InvalidScenario, load, revise
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.pictures.figures import flight_figures
from spacecraft_gnc.vehicles.rigid_body.resolve.replay import resolve

TURNING, STORED = "turning_reference", "stored_trajectory"
SETTLED = 20.0  # [s]
WITHOUT_LAG = 0.01  # [deg]
TO_REST = r"required a method that follows a moving reference"
OF_A_RUN = {"nmpc_controller.method": "neighboring_extremal"}


@pytest.fixture(scope="module", params=[TURNING, STORED])
def flown(request):
    scenario = load(request.param)
    return scenario, scenario.build().run()


def errors_deg(flight):
    return np.degrees(lie.angles_between(flight.reference, flight.attitude))


def test_the_body_follows_without_lag(flown):
    scenario, flight = flown
    late = errors_deg(flight)[round(SETTLED / scenario.period) :]
    assert late.max() < WITHOUT_LAG
    assert not flight.source.any()  # optimal from the first step to the last
    moved = np.degrees(lie.angles_between(flight.reference[1:], flight.reference[:-1]))
    assert moved.max() > 100.0 * late.max()


def test_it_is_judged_by_the_reference_of_each_step(flown):
    scenario, flight = flown
    metrics = summarize(flight, scenario)
    assert metrics["error_to"] == "reference"
    assert metrics["final_error_deg"] < 1e-6  # at the end of the flight, not a period before
    assert metrics["settle_time_0.1deg"] < SETTLED
    assert flight.target.tobytes() == flight.reference.tobytes()
    weights, inertia = scenario.controller.weights, scenario.controller.inertia
    costs = series.stage_costs(flight, weights, inertia=inertia)
    assert costs[-1] < 1e-8 < costs[0]  # the integrator's momentum is J omega up to h^2
    assert "tracking" in dict(flight_figures(flight, scenario))


def test_the_same_controller_gives_the_recorded_torques_again(flown):
    scenario, flight = flown
    revised, _ = revise(scenario)
    assert resolve(flight, scenario, revised, steps=(0, 60)).first_difference is None


@pytest.mark.parametrize("method", ["neighboring_extremal", "slsqp", "feedback"])
def test_another_method_solves_the_recorded_steps_for_the_moving_reference(flown, method):
    scenario, flight = flown
    revised, _ = revise(scenario, method=method)
    again = resolve(flight, scenario, revised, steps=(100, 104))
    largest = 1e-3 if method == "feedback" else 1e-5  # [N m]: at rest on the reference all agree
    assert again.torque_difference.max() < largest


@pytest.mark.parametrize("name", [TURNING, STORED])
@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            {"nmpc_controller.method": "terminal_set"},
            f"method: received 'terminal_set', whose terminal set lies around rest; {TO_REST}",
        ),
        (
            OF_A_RUN | {"nmpc_controller.nominal_rotation_vector": [0.1, 0.0, 0.0]},
            rf"received \[0.1, 0.0, 0.0\], of a stored run that leads to rest; {TO_REST}",
        ),
    ],
)
def test_a_method_that_leads_to_rest_is_refused(name, change, words):
    with pytest.raises(InvalidScenario, match=words):
        load(name, change)


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        (TURNING, {"reference_rate": [0.0, 0.0, 0.0]}, "reference_rate: .*a rate that is not zero"),
        (TURNING, {"reference_rate": [0.1, 0.0]}, "reference_rate: .*3 numbers"),
        (TURNING, {"max_torque": 1.0}, "max_torque: .*not turning_reference"),
        (STORED, {"target_rotation_vector": [0.1, 0.0, 0.0]}, "starts at its first row"),
        (STORED, {"trajectory.times": []}, "trajectory.times: received nothing; required a row"),
        (STORED, {"trajectory.times": [0.0, 5.0]}, r"trajectory.rotation_vectors: .*\(2, 3, 3\)"),
        (STORED, {"trajectory.rotation_vectors": [0.0, 0.1]}, r"3 n numbers \(n x 3, row-major\)"),
        (STORED, {"trajectory.times": [1.0] * 41}, "trajectory.times: received 1 s in row 0"),
        (
            STORED,
            {"trajectory.angular_velocities": [1.0] * 123},
            "trajectory.angular_velocities: received rates of rows 0 and 1.*rad/s",
        ),
        (STORED, {"reference_rate": [0.1, 0.0, 0.0]}, "reference_rate: .*turning_reference"),
    ],
)
def test_a_way_that_is_none_is_refused_in_a_line(name, change, words):
    with pytest.raises(InvalidScenario, match=words) as caught:
        load(name, {f"reference_governor.{key}": value for key, value in change.items()})
    assert len(str(caught.value).splitlines()) == 1
