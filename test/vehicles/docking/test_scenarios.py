"""Shipped docking scenarios: what the issue of docking asks of them.

Flown with one admissible set, of the mean model; about the orbit normal the flights differ by less
than 5 s from those of the periodic sets, which `gnc reproduce afrl2016 --only docking` flies.
"""

from __future__ import annotations

import numpy as np
import pytest
from docking_flights import CONFIG, quick, scenario
from docking_pair import STARTS

from spacecraft_gnc import lie
from spacecraft_gnc.vehicles.docking.build import plant
from spacecraft_gnc.vehicles.docking.decision import Answer, Phase

LATEST = (300.0, 290.0, 380.0)


@pytest.fixture(scope="module")
def loop():
    """Governed loop with one set, whose plant each flight replaces; the sets know no start."""
    return quick().build()


def at(start):
    offset, turn = start
    return {"plant__initial_port_offset": offset, "plant__initial_rotation_vector": turn}


def docked_at(flight):
    """Time from which on the ports are within 2 cm and 1 deg for good [s]; infinity: never."""
    far = np.linalg.norm(flight.port_offset, axis=1)
    turned = np.degrees([np.linalg.norm(lie.log(R)) for R in flight.attitude])
    away = np.flatnonzero((far > 0.02) | (turned > 1.0))
    last = int(away[-1]) + 1 if away.size else 0
    return flight.time[last] if last < len(flight.time) else np.inf


def least(flight):
    """Least line-of-sight margin and clearance of every integrator step [m]."""
    sight = min(flight.line_of_sight_margin.min(), float(flight.final_line_of_sight_margin))
    return sight, min(flight.clearance.min(), float(flight.final_clearance))


def require_constraints(flight):
    sight, clear = least(flight)
    assert sight >= 0.0
    assert clear >= -0.02
    assert np.abs(flight.force).max() <= 1.0 + 1e-6
    assert np.abs(flight.moment).max() <= 0.05 + 1e-6


@pytest.mark.parametrize(("start", "latest"), list(zip(STARTS, LATEST, strict=True)))
def test_governed_flights_dock_in_time_and_keep_every_constraint(start, latest):
    flight = quick(**at(start)).build().run()
    require_constraints(flight)
    assert docked_at(flight) <= latest
    assert (flight.status != Answer.OPTIMAL).sum() <= 1
    assert np.nanmax(flight.residual) < 1e-5


@pytest.mark.parametrize("start", [STARTS[0], STARTS[2]])
def test_ungoverned_flights_break_force_clearance_and_line_of_sight(start):
    flight = scenario("afrl_docking_ungoverned", **at(start)).build().run()
    sight, clear = least(flight)
    assert np.abs(flight.force).max() > 1.5
    assert sight < -0.5
    assert clear < -0.3
    assert docked_at(flight) < 600.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_with_noisy_navigation_the_truth_docks_and_keeps_every_constraint(seed):
    flight = quick("afrl_docking_noise", plant__seed=seed).build().run()
    assert not np.array_equal(flight.port_offset, flight.measured_port_offset)
    require_constraints(flight)
    assert docked_at(flight) <= 320.0
    assert (flight.lost_thruster == -1).all()


def test_the_scenario_with_a_failed_thruster_ends_at_its_hold_point(loop):
    loop.plant = plant(quick("afrl_docking_thruster_failed"))
    flight = loop.run()
    sight, clear = least(flight)
    assert clear > 0.0
    assert sight > -0.02
    assert flight.phase[-1] == Phase.HOLDING
    assert flight.final_port_offset == pytest.approx([10.0, 0.0, 0.0], abs=0.1)


@pytest.mark.parametrize("path", sorted(CONFIG.glob("afrl_docking*.yaml")), ids=lambda p: p.stem)
def test_each_scenario_loads_and_its_plant_starts_within_the_constraints(path):
    flown = scenario(path.stem)
    state = flown.build_plant().state
    assert state.line_of_sight_margin >= 0.0
    assert state.clearance >= 0.0
    assert flown.build_controller().name == "periodic_lqr"
