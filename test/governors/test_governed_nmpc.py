"""The governor in front of an NMPC: hard zones and limits that its horizon cannot see."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles.rigid_body.governors.build import reference_set_of

SCENARIO = shipped("governed_nmpc")


def fly(path=SCENARIO, **words):
    """Fly a scenario with changes; return it, the flight and its errors [deg]."""
    changes = {key.replace("__", "."): value for key, value in words.items()}
    scenario = load(path, changes)
    flight = scenario.build().run()
    target = lie.exp(scenario.governor.target_rotation_vector)
    return scenario, flight, np.degrees(lie.angles_between(flight.attitude, target))


def zone_margins(scenario, flight):
    """Angle [deg] to the nearest zone at every step and at the end."""
    attitudes = np.concatenate([flight.attitude, flight.final_attitude[None]])
    return np.degrees(reference_set_of(scenario).margins(attitudes))


@pytest.fixture(scope="module")
def governed():
    return fly()


def test_the_governed_nmpc_goes_round_the_zone_and_arrives(governed):
    scenario, flight, errors = governed
    assert zone_margins(scenario, flight).min() >= 0.0
    late = flight.time > 200.0
    assert errors[late].max() < 0.1
    assert np.linalg.norm(flight.momentum[late], axis=1).max() < 1e-3
    assert np.linalg.norm(flight.torque, axis=1).max() <= 0.01 * (1.0 + 1e-6)
    assert set(flight.source) == {0}  # every torque from a solve


def test_every_reference_is_admissible_and_keeps_the_steady_margin(governed):
    scenario, flight, _ = governed
    reference_set = reference_set_of(scenario)
    assert reference_set.margins(flight.reference).min() >= reference_set.steady_margin
    assert flight.governor_margin.min() >= 0.0
    assert ((flight.alpha >= 0.0) & (flight.alpha <= 1.0)).all()
    assert flight.alpha.min() < 1.0  # it had something to do
    assert np.array_equal(flight.reference[-1], np.eye(3))


def test_the_nmpc_alone_enters_the_zone_or_stalls_before_it():
    scenario, flight, errors = fly(reference_governor__governor="none")
    assert zone_margins(scenario, flight).min() < -10.0  # the soft zone is run through
    assert errors[-1] < 0.1
    scenario, flight, errors = fly(
        reference_governor__governor="none", nmpc_controller__standstill_error_deg=0.0
    )
    assert zone_margins(scenario, flight).min() < -10.0
    assert errors[-1] > 50.0


def test_without_a_way_round_the_governor_waits_before_the_zone():
    scenario, flight, errors = fly(
        reference_governor__route=False,
        reference_governor__alpha_tolerance=0.02,
        plant__duration=80.0,
    )
    assert zone_margins(scenario, flight).min() >= 0.0
    assert errors[-1] > 50.0
    assert flight.governor_margin.min() >= 0.0


def test_a_momentum_limit_is_kept_that_the_nmpc_knows_nothing_of():
    _, flight, _ = fly(plant__duration=120.0, reference_governor__governor="none")
    assert np.linalg.norm(flight.momentum, axis=1).max() > 0.06
    scenario, flight, errors = fly(
        plant__duration=120.0,
        reference_governor__max_momentum=0.03,
        reference_governor__alpha_tolerance=0.02,
    )
    largest = np.linalg.norm(flight.momentum, axis=1).max()
    assert 0.02 < largest <= 0.03
    assert zone_margins(scenario, flight).min() >= 0.0
    assert errors[-1] < 5.0


def test_neighboring_extremals_are_governed_as_well():
    scenario, flight, errors = fly(
        nmpc_controller__method="neighboring_extremal",
        plant__duration=120.0,
        reference_governor__alpha_tolerance=0.02,
    )
    assert (flight.source == 1).mean() > 0.5
    assert zone_margins(scenario, flight).min() >= 0.0
    assert flight.governor_margin.min() >= 0.0
    assert errors[-1] < 3.0


@pytest.mark.parametrize("seed", [2, 3, 5, 11])
def test_any_zones_are_kept_from_anywhere(seed):
    rng = np.random.default_rng(seed)

    def direction():
        return lie.orthonormalize(rng.normal(size=(3, 3)))[0]

    axis = direction()
    words = {"plant__initial_rotation_vector": (2.0 * axis).tolist()}
    # A cone across the way of a body axis: the shortest turn would carry it through the middle.
    side = np.cross(axis, direction())
    body_axis = (side + 0.2 * axis) / np.linalg.norm(side + 0.2 * axis)
    ahead = lie.exp(axis) @ body_axis
    words["nmpc_controller__zone_names"] = ["across"]
    across = {
        "kind": "exclusion",
        "body_axis": body_axis.tolist(),
        "inertial_axis": ahead.tolist(),
        "half_angle_deg": float(rng.uniform(5.0, 25.0)),
        "penalty": 1000.0,
    }
    words |= {f"nmpc_controller__zones__across__{key}": value for key, value in across.items()}
    words |= {"reference_governor__governor": "attitude", "plant__duration": 200.0}
    words["reference_governor__alpha_tolerance"] = 0.02
    scenario, flight, errors = fly(shipped("gupta2015_case1"), **words)
    assert zone_margins(scenario, flight).min() >= 0.0
    assert flight.governor_margin.min() >= 0.0
    assert errors[-1] < 1.5
    assert math.isclose(flight.alpha[-1], 1.0)
