"""What wheels and method cannot do is refused, or warned of where it may be flown on purpose."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from two_wheels import two_wheels
from wheel_losses import FOUR, THREE, scenario_sections
from wheeled import AFRL_SPEED, AFRL_WHEEL, PYRAMID

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.scenario import InvalidScenario, from_sections
from spacecraft_gnc.vehicles.two_wheel.capability import _least_speed
from spacecraft_gnc.vehicles.two_wheel.summary import lines

MOTOR = 0.043 * 5.0  # [N m]


def _told(name=THREE, **changes):
    return from_sections(scenario_sections(name, **changes)).warnings


@pytest.mark.parametrize("name", [THREE, FOUR])
def test_what_is_shipped_is_flown_without_a_warning(name):
    assert _told(name) == ()
    assert from_sections(two_wheels()).warnings == ()


def test_friction_that_no_motor_overcomes_is_refused():
    with pytest.raises(
        InvalidScenario,
        match=r"plant.wheel_coulomb_friction: received \[0.0, 0.216, 0.0\]; required less than .* "
        r"0.215 N m for wheel 2 .*; lower it or raise max_wheel_acceleration",
    ) as refused:
        _told(wheel_coulomb_friction=[0.0, 0.216, 0.0])
    assert len(refused.value.problems) == 1
    assert _told(wheel_coulomb_friction=[0.0, 0.999 * MOTOR, 0.0]) == ()
    assert _told(wheel_coulomb_friction=[0.0, MOTOR, 0.0], max_wheel_acceleration=0.0) == ()


def test_a_wheel_whose_friction_is_just_less_starts():
    """It is not refused for a wheel that does move: the law of friction says so."""
    sections = scenario_sections(lost={}, wheel_coulomb_friction=[0.99 * MOTOR] * 3)
    plant = from_sections(sections).build_plant()
    plant.step(np.full(3, 5.0))
    assert plant.state.wheel_speed == pytest.approx(np.full(3, 0.01 * 5.0 * 10.0))


@pytest.mark.parametrize("method", ["feedback", "shooting"])
def test_a_loss_that_the_method_does_not_survive_is_warned_of(method):
    (warning,) = _told(controller={"method": method})
    assert "plant.wheel_lost_at: received [-1.0, -1.0, 100.0] with method: " + method in warning
    assert "required method: fault_tolerant to survive it" in warning
    assert _told(lost={}, controller={"method": method}) == ()


def test_two_wheels_are_told_that_they_need_a_third():
    sections = two_wheels(plant={"wheel_lost_at": [-1.0, 50.0]})
    (warning,) = from_sections(sections).warnings
    assert "method: fault_tolerant with three wheels or more" in warning


def test_more_losses_than_an_attitude_can_be_held_with_are_warned_of():
    (warning,) = _told(lost={0: 50.0, 2: 100.0})
    assert "leaves axes that span 1 dimension(s); required 2" in warning
    assert _told(FOUR, lost={0: 50.0, 2: 100.0}) == ()


CARRIED = {
    "all wheels": (THREE, {}, [3.0, 4.4, 0.0], "3 wheels", 4.3 / 4.4),
    "two left": (THREE, {2: 100.0}, [4.0, 0.0, 4.0], "the 2 wheels left", 4.3 / 32**0.5),
    "three left": (FOUR, {0: 100.0}, [0.0, 0.0, 9.3], "the 3 wheels left", None),
}


@pytest.mark.parametrize(
    ("name", "lost", "momentum", "who", "share"), CARRIED.values(), ids=CARRIED
)
def test_momentum_that_the_wheels_cannot_carry_is_refused(name, lost, momentum, who, share):
    """The method would tell an attitude that it holds, and not hold it."""
    with pytest.raises(InvalidScenario, match=rf"initial_total_momentum: .* {who} can") as refused:
        _told(name, lost=lost, initial_total_momentum=momentum)
    text = str(refused.value)
    least = float(text.partition("at most ")[2].split()[0])
    size = float(np.linalg.norm(momentum))
    if share == 4.3 / 32**0.5:  # on the cone: all of it lies in the plane of the wheels left
        share = 4.3 / size
    if share is not None:
        assert least == pytest.approx(share * size, rel=1e-5)
    within = (0.999 * least / size * np.array(momentum)).tolist()
    assert _told(name, lost=lost, initial_total_momentum=within) == ()


def test_a_method_that_tells_nothing_of_what_it_holds_may_fly_it():
    (warning,) = _told(
        lost={}, controller={"method": "feedback"}, initial_total_momentum=[0.0, 5.0, 0.0]
    )
    assert "required at most 4.3 N m s of its 5 N m s" in warning


def test_momentum_of_a_rate_counts_as_well():
    with pytest.raises(InvalidScenario, match=r"initial_angular_velocity: .* of its 13 N m s"):
        _told(lost={}, initial_angular_velocity=[0.0, 0.0, 0.01])


@pytest.mark.parametrize("seed", range(10))
def test_the_least_speed_is_that_of_the_facets(seed):
    """What wheels carry is a zonotope; its facets are normal to two axes each."""
    wheels = AFRL_WHEEL * PYRAMID / np.linalg.norm(PYRAMID, axis=0)
    momentum = np.random.default_rng(seed).normal(size=3)
    found = []
    for i, j in combinations(range(4), 2):
        normal = np.cross(wheels[:, i], wheels[:, j])
        found.append(abs(normal @ momentum) / np.abs(normal @ wheels).sum())
    assert _least_speed(wheels, momentum) == pytest.approx(max(found), rel=1e-9)
    largest = AFRL_SPEED / max(found) * momentum
    assert _least_speed(wheels, largest) == pytest.approx(AFRL_SPEED, rel=1e-9)


@pytest.mark.parametrize("name", ["wheel_viscous_friction", "wheel_coulomb_friction"])
def test_a_bound_below_the_friction_of_the_plant_is_warned_of(name):
    rubs = {name: [1e-3, 2e-3, 1e-3]}
    (warning,) = _told(controller={name: [1e-3] * 3}, **rubs)
    assert f"nmpc_controller.{name}: received [0.001, 0.001, 0.001]; required at least" in warning
    assert "[0.001, 0.002, 0.001]" in warning
    assert _told(**rubs) == ()
    assert _told(controller={name: [2e-3] * 3}, **rubs) == ()
    heavier = {"wheel_inertias": [0.043, 0.086, 0.043], name: [2e-3] * 3}
    (warning,) = _told(controller=heavier, **rubs)  # the bound is that of friction over inertia
    assert "[0.001, 0.004, 0.001]" in warning


@pytest.mark.parametrize("name", ["max_wheel_speed", "max_wheel_acceleration"])
def test_a_limit_beyond_that_of_the_plant_is_warned_of(name):
    (warning,) = _told(controller={name: 200.0})
    assert f"nmpc_controller.{name}: received 200.0; required at most plant.{name}" in warning
    assert _told(controller={name: 4.0}) == ()


def test_the_alarm_that_was_warned_of_comes_and_is_told_as_such():
    sections = scenario_sections(
        lost={2: 100.0}, controller={"wheel_coulomb_friction": [2e-3, 1e-4, 2e-3]},
        wheel_coulomb_friction=[1e-3] * 3, duration=300.0,
    )  # fmt: skip
    scenario = from_sections(sections)
    (warning,) = scenario.warnings
    assert "healthy wheels are excluded" in warning
    found = summarize(scenario.build().run(), scenario)
    (alarm,) = found["false_alarms"]
    assert alarm["wheel"] == 2
    assert alarm["at"] <= 20.0
    (loss,) = found["wheel_losses"]
    assert (loss["wheel"], loss["lost_at"]) == (3, 100.0)
    assert found["wheel_loss_detected_at"] == loss["detected_at"]
    assert loss["detected_at"] is None or loss["detected_at"] >= 100.0
    rows = lines(found)
    assert ("false alarm", f"2 excluded at {alarm['at']:g} s") in rows
    assert dict(rows)["wheel lost"].startswith("3 at 100 s, ")


def test_several_losses_are_all_told_and_plans_are_counted():
    scenario = from_sections(scenario_sections(FOUR, lost={0: 50.0, 2: 100.0}, duration=400.0))
    found = summarize(scenario.build().run(), scenario)
    assert [(one["wheel"], one["lost_at"]) for one in found["wheel_losses"]] == [
        (1, 50.0), (3, 100.0),
    ]  # fmt: skip
    assert [one["detected_at"] for one in found["wheel_losses"]] == [60.0, 110.0]
    rows = [text for label, text in lines(found) if label == "wheel lost"]
    assert rows == ["1 at 50 s, noticed at 60 s", "3 at 100 s, noticed at 110 s"]
    assert sum(found["plans"].values()) == 40
    assert found["plans"]["free"] == 11
    assert "free 11" in dict(lines(found))["plans by their end"]
