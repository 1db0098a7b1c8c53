"""Linear laws of the docking vehicle: commands, steady states, what periodicity is worth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from docking_flights import quick, scenario
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.vehicles.docking.build import mean_law, periodic_law
from spacecraft_gnc.vehicles.docking.linear import HELD, coordinates
from spacecraft_gnc.vehicles.docking.state import RelativeReference

LAWS = {"periodic_lqr": periodic_law, "time_invariant_lqr": mean_law}
DOCKED = {
    "plant__initial_port_offset": [0.0, 0.0, 0.0],
    "plant__initial_rotation_vector": [0.0, 0.0, 0.0],
}


def ungoverned(method, name="afrl_docking_ungoverned", **changes):
    return scenario(
        name,
        nmpc_controller__method=method,
        reference_governor__governor="none",
        plant__saturates=False,
        **changes,
    )


@pytest.mark.parametrize("method", LAWS)
def test_a_command_is_the_law_of_the_measured_state(method):
    flown = quick("afrl_docking_noise", nmpc_controller__method=method)
    plant, controller, law = flown.build_plant(), flown.build_controller(), LAWS[method](flown)
    reference = RelativeReference.of(np.array([1.0, 0.2, -0.1, 0.02, 0.01, -0.03]))
    for _ in range(3):
        state = plant.state
        command = controller.command(state, reference)
        k, v = state.step % law.period, reference.vector
        error = coordinates(*state.measured) - HELD @ v
        model = law.model
        held = model.feedforward[k] + model.reference_feedforward[k] @ v
        assert command.control == pytest.approx(held - law.gains[k] @ error, rel=1e-12)
        assert command.source == Source.METHOD
        assert not command.is_fallback
        plant.step(command.control)


def test_a_state_that_is_not_finite_leaves_the_thrusters_at_rest():
    flown = quick()
    state, controller = flown.build_plant().state, flown.build_controller()
    reference = RelativeReference.of(np.zeros(6))
    for bad in (math.nan, math.inf):
        measured = state.measured._replace(port_velocity=np.array([0.0, bad, 0.0]))
        command = controller.command(state._replace(measured=measured), reference)
        assert command.source == Source.ZERO
        assert np.array_equal(command.control, np.zeros(6))
    wild = RelativeReference.of(np.full(6, np.inf))
    assert controller.command(state, wild).source == Source.ZERO


@pytest.fixture(scope="module")
def law():
    """Periodic law of a chief that tumbles about a tilted axis."""
    return periodic_law(scenario("afrl_docking_tilted"))


@given(st.integers(0, 400), st.lists(st.floats(-5.0, 5.0), min_size=18, max_size=18))
def test_the_reference_of_a_wrench_gives_that_wrench(law, step, numbers):
    state, wrench = np.split(np.array(numbers), [12])
    reference = law.reference(step, state, wrench)
    assert law.wrench(step, state, reference) == pytest.approx(wrench, abs=1e-9)


def test_the_loop_settles_at_any_reference():
    law = periodic_law(scenario())
    steady = law.loop().steady_maps()
    assert law.loop().spectral_radius < 1e-6  # over a rotation
    assert np.abs(steady - HELD).max() < 0.05  # the output tends to the reference, (11)


def error_at_the_end(flight):
    """Largest distance between the ports and angle over the last 500 s of a flight."""
    last = flight.time >= flight.time[-1] - 500.0
    turns = [np.linalg.norm(lie.log(R)) for R in flight.attitude[last]]
    return np.linalg.norm(flight.port_offset[last], axis=1).max(), max(turns)


def test_where_the_axis_is_tilted_the_law_of_the_mean_model_does_not_dock():
    tilted = {
        "plant__chief_spin_rate": 2.0 * math.pi / 500.0,
        "plant__chief_spin_axis": [0.0, math.sin(math.pi / 3.0), 0.5],
        "plant__chief_initial_rotation_vector": [-math.pi / 3.0, 0.0, 0.0],
        "plant__duration": 1000.0,
    }
    found = {m: error_at_the_end(ungoverned(m, **tilted, **DOCKED).build().run()) for m in LAWS}
    distance, angle = found["periodic_lqr"]
    assert distance < 2e-4
    assert angle < 1e-5
    distance, angle = found["time_invariant_lqr"]
    assert distance > 0.02  # not docked
    assert math.degrees(angle) > 0.2
