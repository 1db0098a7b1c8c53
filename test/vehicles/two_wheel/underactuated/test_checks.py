"""Scenarios that two wheels cannot fly are refused, with the reason."""

from __future__ import annotations

import pytest
from two_wheels import two_wheels
from wheel_losses import scenario_sections

from spacecraft_gnc import extras
from spacecraft_gnc.scenario import InvalidScenario, from_sections
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated import checks

ZERO = [0.0, 0.0, 0.0]
REFUSED = {
    "three wheels": (
        {"wheel_axes": [1.0, *ZERO, 1.0, *ZERO, 1.0], "wheel_inertias": [0.043] * 3}, {},
        r"plant.wheel_axes: received 3 wheels; required 2 for method: underactuated; remove",
    ),
    "two wheels about one axis": (
        {"wheel_axes": [1.0, 1.0, 0.0, 0.0, 0.0, 0.0]}, {},
        r"plant.wheel_axes: received 2 .*span 1 dimension",
    ),
    "a momentum": (
        {"initial_angular_velocity": [0.0, 0.0, 0.01]}, {},
        r"plant.initial_angular_velocity: .*required no total momentum: .* 13 N m s",
    ),
    "a momentum of the wheels": (
        {"initial_wheel_speed": [10.0, 0.0]}, {},
        r"required no total momentum: .* 0.43 N m s; give initial_total_momentum: \[0.0",
    ),
    "fast wheels": (
        {"initial_wheel_speed": [0.0, 101.0], "initial_total_momentum": ZERO}, {},
        r"plant.initial_wheel_speed: .*at most max_wheel_speed \(100 rad/s\)",
    ),
    "a start at the singularity": (
        {"initial_euler_321": [0.2, 1.5707963, 0.3]}, {"prediction_model": "simplified"},
        r"plant.initial_euler_321: .*a pitch off \+-90 deg .*it is 90 deg; .*prediction_model: so3",
    ),
    "the same with exact angles": (
        {"initial_euler_321": [0.2, -1.5707963, 0.3]}, {"prediction_model": "euler_321"},
        r"for prediction_model: euler_321; it is -90 deg",
    ),
    "a horizon in which the wheels do not stop": (
        {"initial_wheel_speed": [90.0, 0.0], "initial_total_momentum": ZERO},
        {"horizon": 2, "max_wheel_acceleration": 1.0},
        r"nmpc_controller.horizon: received 2; required at least 9 steps, in which the wheels",
    ),
    "a horizon that is too short for the proof": (
        {}, {"horizon": 3},
        r"horizon: received 3; required at least 4 steps for terminal: shaped, .*; give 4 or more",
    ),
    "a horizon that is too short": (
        {"initial_euler_321": [0.3, 0.0, 0.0]}, {"horizon": 3, "terminal": "hard"},
        r"horizon: received 3; .* terminal: hard; \d+ steps are the fewest found; lengthen it, or",
    ),
    "weights of nothing": (
        {}, {"attitude_weights": [1.0, 0.0, 1.0]}, r"nmpc_controller.attitude_weights: .*> 0",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("plant", "controller", "words"), REFUSED.values(), ids=REFUSED)
def test_what_two_wheels_cannot_fly_is_refused(plant, controller, words):
    with pytest.raises(InvalidScenario, match=words) as refused:
        from_sections(two_wheels(plant=plant, nmpc_controller=controller))
    assert len(refused.value.problems) == 1


@pytest.mark.parametrize("terminal", ["soft", "hard"])
def test_only_a_shaped_end_needs_four_steps(terminal):
    near = {"initial_euler_321": [0.01, 0.0, 0.0]}
    from_sections(two_wheels(plant=near, nmpc_controller={"horizon": 3, "terminal": terminal}))


def test_a_horizon_for_the_two_wheels_left_is_refused_likewise():
    with pytest.raises(InvalidScenario, match=r"horizon: received 3; required at least 4 steps"):
        from_sections(scenario_sections(controller={"horizon": 3}))


def test_the_horizon_that_is_named_is_the_shortest():
    start = {"plant": {"initial_euler_321": [0.3, 0.0, 0.0]}}
    hard = {"terminal": "hard"}
    with pytest.raises(InvalidScenario) as refused:
        from_sections(two_wheels(nmpc_controller={**hard, "horizon": 3}, **start))
    shortest = int(str(refused.value).partition("hard; ")[2].split()[0])
    from_sections(two_wheels(nmpc_controller={**hard, "horizon": shortest}, **start))
    with pytest.raises(InvalidScenario, match=f"; {shortest} steps"):
        from_sections(two_wheels(nmpc_controller={**hard, "horizon": shortest - 1}, **start))


def test_ipopt_without_casadi_is_refused(monkeypatch):
    monkeypatch.setattr(checks, "find_spec", lambda _: None)
    with pytest.raises(InvalidScenario, match=r"solver: received ipopt; required CasADi .*pip"):
        from_sections(two_wheels(nmpc_controller={"solver": "ipopt"}))
    assert "casadi" in extras._NEEDS


def test_wheels_that_turn_without_momentum_may_start():
    plant = {"initial_wheel_speed": [50.0, -80.0], "initial_total_momentum": ZERO}
    state = from_sections(two_wheels(plant=plant)).build_plant().state
    assert not state.total_momentum.any()
    assert state.angular_velocity == pytest.approx([-0.005, 80.0 * 0.043 / 1210.0, 0.0])
