"""Governor of the docking vehicle: constraint rows, optimality, refusals, targets in flight."""

from __future__ import annotations

import numpy as np
import pytest
from docking_flights import quick, scenario
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError, ParameterError
from spacecraft_gnc.vehicles.docking.build import believed_motion, periodic_law
from spacecraft_gnc.vehicles.docking.decision import Answer, Phase
from spacecraft_gnc.vehicles.docking.geometry import line_of_sight_margin
from spacecraft_gnc.vehicles.docking.governors.build import tightened_bounds
from spacecraft_gnc.vehicles.docking.governors.rows import constraints
from spacecraft_gnc.vehicles.docking.state import RelativeReference

MARGINS = {
    "reference_governor__force_margin": 0.1,
    "reference_governor__moment_margin": 0.01,
    "reference_governor__distance_margin": 0.01,
}
NUMBERS = st.lists(st.floats(-3.0, 3.0), min_size=18, max_size=18)


@pytest.fixture(scope="module")
def rows():
    """Rows with margins, the law and the motion that they are of, by name."""
    tight = scenario("afrl_docking_tilted", **MARGINS)
    law = periodic_law(tight)
    made = constraints(law, tightened_bounds(tight))
    return made, law, believed_motion(tight)


def slacks(made, k, x, v):
    """Slack of each row of step k, by name."""
    row = made.bounds[k] - made.state_rows[k] @ x - made.reference_rows[k] @ v
    return dict(zip(made.names, row, strict=True))


@given(st.integers(0, 99), NUMBERS)
def test_rows_of_force_and_moment_are_the_law_against_the_tightened_limits(rows, k, numbers):
    made, law, _ = rows
    x, v = np.split(np.array(numbers), [12])
    wrench, found = law.wrench(k, x, v), slacks(made, k, x, v)
    for part, first, limit in (("force", 0, 0.9), ("moment", 3, 0.04)):
        for i, axis in enumerate("xyz"):
            assert found[f"{part} +{axis}"] == pytest.approx(limit - wrench[first + i], abs=1e-9)
            assert found[f"{part} -{axis}"] == pytest.approx(limit + wrench[first + i], abs=1e-9)


@given(NUMBERS)
def test_rows_of_the_line_of_sight_are_its_margin(rows, numbers):
    made, _, motion = rows
    x, v = np.split(np.array(numbers), [12])
    found = slacks(made, 0, x, v)
    least = min(value for name, value in found.items() if name.startswith("line of sight"))
    assert least == pytest.approx(line_of_sight_margin(x[:3], *motion.line_of_sight) - 0.01)


@given(NUMBERS)
def test_rows_of_the_vertices_miss_their_height_by_the_square_of_the_angle(rows, numbers):
    made, _, motion = rows
    x, v = np.split(np.array(numbers), [12])
    x[6:9] *= 0.1
    turn, angle = lie.exp(x[6:9]), np.linalg.norm(x[6:9])
    found = slacks(made, 0, x, v)
    for i, vertex in enumerate(motion.deputy.vertices):
        arm = vertex - motion.deputy.port
        height = x[0] + (turn @ arm)[0]  # over the docking face, on which the chief's port lies
        miss = found[f"vertex {i + 1} off the docking face"] - (height + 0.02 - 0.01)
        assert abs(miss) <= 0.5 * angle**2 * np.linalg.norm(arm) + 1e-12


@pytest.fixture(scope="module")
def loop():
    """Closed loop with one set."""
    return quick().build()


def fresh(loop):
    for core in (loop.plant, loop.controller, loop.governor):
        core.reset()
    return loop.plant, loop.controller, loop.governor


def test_decisions_are_optimal_and_told(loop):
    plant, controller, governor = fresh(loop)
    limited = 0
    for k in range(60):
        decision = governor.decide(plant.state)
        assert decision.answer == Answer.OPTIMAL
        assert decision.phase == Phase.DOCKING
        assert decision.residual < 1e-6
        assert decision.slack >= -1e-6
        assert decision.lost_thruster == -1
        assert np.isnan(decision.response_error) == (k == 0)
        assert decision.decision_time > 0.0
        if decision.active:
            limited += 1
            away = np.abs(decision.reference.vector - decision.wish)
            assert away.max() > 0.0
            multipliers = [a.multiplier for a in decision.active]
            assert multipliers == sorted(multipliers, reverse=True)
            assert min(multipliers) > 0.0
        plant.step(controller.command(plant.state, decision.reference).control)
    assert 10 < limited < 60  # at first it holds the loop back, then it lets go


def test_a_start_without_an_admissible_reference_is_refused_before_the_flight():
    fast = quick(plant__initial_port_velocity=[-1.0, 0.0, 0.0])
    with pytest.raises(GncError, match="no reference keeps every constraint") as refused:
        fast.build()
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("target", "why"),
    [
        ([2.0, 3.0, 0.0, 0.0, 0.0, 0.0], "line of sight [+]y"),
        ([-0.5, 0.0, 0.0, 0.0, 0.0, 0.0], "off the docking face|line of sight"),
        ([0.0, 0.0, 0.0, 0.0, 0.3, 0.0], "off the docking face"),
        ([400.0, 0.0, 0.0, 0.0, 0.0, 0.0], "force -x"),
        ([np.nan, 0.0, 0.0, 0.0, 0.0, 0.0], "6 finite numbers"),
    ],
)
def test_a_target_that_cannot_be_held_is_refused_and_the_last_one_stays(loop, target, why):
    _, _, governor = fresh(loop)
    with pytest.raises(ParameterError, match=why):
        governor.set_target(RelativeReference.of(np.array(target)))
    assert np.array_equal(governor.target.vector, np.zeros(6))


def test_a_target_taken_in_flight_is_reached(loop):
    plant, controller, governor = fresh(loop)
    wish = RelativeReference.of(np.array([2.0, 0.5, -0.3, 0.0, 0.1, 0.0]))
    for k in range(100):
        if k == 10:
            governor.set_target(wish)
        decision = governor.decide(plant.state)
        assert np.array_equal(decision.wish, (wish.vector if k >= 10 else np.zeros(6)))
        plant.step(controller.command(plant.state, decision.reference).control)
    state = plant.state
    assert state.port_offset == pytest.approx(wish.port_offset, abs=0.03)
    assert lie.log(state.attitude) == pytest.approx(wish.rotation_vector, abs=0.01)
    governor.reset()
    assert np.array_equal(governor.target.vector, np.zeros(6))


def test_without_an_admissible_reference_the_last_one_is_held(loop):
    plant, _, governor = fresh(loop)
    first = governor.decide(plant.state)
    pushed = plant.state.measured._replace(port_velocity=np.array([-2.0, 0.0, 0.0]))
    held = governor.decide(plant.state._replace(measured=pushed))
    assert held.answer == Answer.INFEASIBLE
    assert held.slack < 0.0
    assert held.constraint
    assert np.array_equal(held.reference.vector, first.reference.vector)


def test_the_law_none_passes_the_target_on():
    plain = scenario("afrl_docking_ungoverned")
    plant, governor = plain.build_plant(), plain.build_governor()
    wish = RelativeReference.of(np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    governor.set_target(wish)
    decision = governor.decide(plant.state)
    assert decision.reference.vector == pytest.approx(wish.vector)
    assert decision.answer == Answer.PASSED
    assert decision.slack == np.inf
    with pytest.raises(ParameterError, match="finite"):
        governor.set_target(RelativeReference.of(np.full(6, np.nan)))
    governor.reset()
    assert np.array_equal(governor.target.vector, np.zeros(6))
