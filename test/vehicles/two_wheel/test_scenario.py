"""Scenarios of a spacecraft with wheels: what flies, what is refused, and with which words."""

from __future__ import annotations

import math

import numpy as np
import pytest
from wheel_bags import fly, sections

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import load_run, read_flight
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.scenario import InvalidScenario, from_sections, load
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321

ORTHOGONAL = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
AFRL = {
    "vehicle": "two_wheel",
    "inertia": [430.0, 0.0, 0.0, 0.0, 1210.0, 0.0, 0.0, 0.0, 1300.0],
    "wheel_axes": ORTHOGONAL,
    "wheel_inertias": [0.043, 0.043, 0.043],
}
LIMITED = {**AFRL, "max_wheel_speed": 100.0, "max_wheel_acceleration": 5.0}


def test_the_shipped_slew_settles_within_the_limits():
    scenario = load("three_wheel_slew")
    flight = scenario.build().run()
    found = summarize(flight, scenario)
    assert found["settle_time"] == 550.0
    assert found["final_error_deg"] < 0.01
    assert 50.0 < found["max_wheel_speed"] < 100.0
    assert found["max_wheel_acceleration"] < 5.0
    assert found["momentum_drift"] == 0.0
    assert found["wheel_lost_at"] is None
    assert np.allclose(flight.euler_321[0], [0.5, 0.3, -0.4], atol=1e-15)


def test_arrays_and_a_file_of_them_have_the_promised_shapes(tmp_path):
    flight = from_sections(sections()).build().run()
    n, m = 20, 4
    shapes = {
        "time": (n,), "status": (n,), "source": (n,), "iterations": (n,), "residual": (n,),
        "solve_time": (n,), "attitude": (n, 3, 3), "angular_velocity": (n, 3), "euler_321": (n, 3),
        "wheel_speed": (n, m), "wheel_acceleration": (n, m), "total_momentum": (n, 3),
        "healthy": (n, m),
    }  # fmt: skip
    assert {name: getattr(flight, name).shape for name in shapes} == shapes
    assert flight.healthy.dtype == bool
    scenario = from_sections(sections())
    file = flight.save(tmp_path / "flight.npz", scenario.to_yaml(), scenario.stated_defaults())
    again = load_run(file).trajectory
    for name in shapes:
        assert np.array_equal(getattr(again, name), getattr(flight, name), equal_nan=True), name


def test_a_bag_holds_the_arrays_of_simulate_bit_for_bit(tmp_path):
    flight = from_sections(sections()).build().run()
    recorded = read_flight(fly(tmp_path)[0]).trajectory
    for name, _ in type(flight).columns():
        mine, theirs = getattr(flight, name), getattr(recorded, name)
        assert (mine.dtype, mine.shape) == (theirs.dtype, theirs.shape), name
        assert mine.tobytes() == theirs.tobytes(), name


def test_a_lost_wheel_is_told():
    scenario = from_sections(sections())
    found = summarize(scenario.build().run(), scenario)
    assert found["wheel_lost_at"] == 1.0
    assert found["momentum_drift"] == 0.0


def test_a_wheel_may_be_lost_at_the_last_control_step():
    plant = {**LIMITED, "wheel_lost_at": [-1.0, 0.7, -1.0], "duration": 0.8, "time_step": 0.1}
    scenario = from_sections({"plant": plant, "nmpc_controller": {"feedback_bandwidth": 0.01}})
    found = summarize(scenario.build().run(), scenario)
    assert (found["steps"], found["wheel_lost_at"]) == (8, pytest.approx(0.7))


def test_a_start_by_euler_angles_is_that_by_a_rotation_vector():
    vector = [0.3, -0.2, 0.9]
    by_vector = from_sections({"plant": {**AFRL, "initial_rotation_vector": vector}}).build_plant()
    assert np.array_equal(by_vector.state.attitude, lie.exp(np.array(vector)))
    by_angles = from_sections({"plant": {**AFRL, "initial_euler_321": vector}}).build_plant()
    assert np.array_equal(by_angles.state.attitude, from_euler_321(np.array(vector)))


def test_a_start_by_its_total_momentum_has_it_to_the_last_bit():
    total, speeds = [1.0, -2.0, 0.5], [10.0, -20.0, 30.0]
    changes = {"initial_total_momentum": total, "initial_wheel_speed": speeds}
    plant = from_sections({"plant": {**LIMITED, **changes, "initial_euler_321": [0.5, 0.3, -0.4]}})
    state = plant.build_plant().state
    assert np.array_equal(state.total_momentum, total)
    body = np.diag([430.0, 1210.0, 1300.0]) @ state.angular_velocity + 0.043 * np.array(speeds)
    assert state.attitude @ body == pytest.approx(total, abs=1e-12)


def test_wheels_that_span_one_dimension_are_refused_whatever_the_method():
    axes = [1.0, 2.0, 0.0, 0.0, 0.0, 0.0]
    plant = {**LIMITED, "wheel_axes": axes, "wheel_inertias": [0.01, 0.01]}
    with pytest.raises(InvalidScenario, match=r"plant.wheel_axes: .*span 1 dim.*required [23]"):
        from_sections({"plant": plant})


def test_the_friction_of_a_lost_wheel_follows_from_its_limit():
    lost = {"wheel_lost_at": [-1.0, 10.0, -1.0]}
    limited = from_sections({"plant": {**LIMITED, **lost}})
    assert limited.plant.lost_wheel_friction == 0.0215  # 0.043 * 5 / 10
    settling = {"nmpc_controller": {"settling_time": 500.0}}
    free = from_sections({"plant": {**AFRL, **lost}, **settling})
    assert free.plant.lost_wheel_friction == pytest.approx(0.043 * 10.0 / 500.0, rel=1e-11)
    assert from_sections({"plant": LIMITED}).plant.lost_wheel_friction == 0.0


def test_defaults_follow_from_the_limits():
    scenario = from_sections({"plant": LIMITED})
    # 2 s N / J_1 = 2 * 0.043 * 100 / 1300 is less than sqrt(s U / J_1)
    settling = 8.0 * 1300.0 / (2.0 * 0.043 * 100.0)
    assert scenario.controller.settling_time == pytest.approx(settling, rel=1e-11)
    assert scenario.controller.feedback_bandwidth == pytest.approx(8.0 / settling, rel=1e-11)
    assert scenario.period == pytest.approx(settling / 80.0, abs=1e-9)
    assert scenario.plant.duration == pytest.approx(3.0 * settling, rel=1e-11)
    tolerance = math.radians(0.1) * 8.0 / settling
    assert scenario.governor.slew_rate_tolerance == pytest.approx(tolerance, rel=1e-11)


@pytest.mark.parametrize(
    "attitude",
    [{"initial_euler_321": [0.5, 0.3, -0.4]}, {"initial_rotation_vector": [0.3, -0.2, 2.9]}],
)
def test_a_start_by_total_momentum_has_the_time_step_of_its_rate(attitude):
    wheels = {**AFRL, **attitude, "initial_wheel_speed": [20.0, -30.0, 90.0]}
    by_rate = from_sections({"plant": {**wheels, "initial_angular_velocity": [0.3, -0.1, 0.6]}})
    first = by_rate.build_plant().state
    total = {"initial_total_momentum": first.total_momentum.tolist()}
    by_momentum = from_sections({"plant": {**wheels, **total}})
    assert by_momentum.plant.time_step == pytest.approx(by_rate.plant.time_step, rel=1e-8)
    assert by_momentum.plant.time_step < from_sections({"plant": wheels}).plant.time_step
    again = by_momentum.build_plant().state.angular_velocity
    assert again == pytest.approx(first.angular_velocity, rel=1e-12)


@pytest.mark.parametrize("angles", [[0.5, 0.3, -0.4], [3.0, 0.0, 0.0], [0.1, 1.2, 2.0]])
@pytest.mark.parametrize("scale", [1e-3, 1.0])
def test_the_defaults_settle_without_touching_a_limit(angles, scale):
    inertia = (scale * np.array(AFRL["inertia"])).tolist()
    plant = {**LIMITED, "inertia": inertia, "initial_euler_321": angles}
    plant["wheel_inertias"] = [0.043 * scale] * 3
    scenario = from_sections({"plant": plant})
    found = summarize(scenario.build().run(), scenario)
    assert found["settle_time"] is not None
    assert found["max_wheel_speed"] < 100.0
    assert found["max_wheel_acceleration"] < 5.0


def test_a_controller_that_believes_another_body_flies_by_its_belief():
    believed = [400.0, 0.0, 0.0, 0.0, 1300.0, 0.0, 0.0, 0.0, 1250.0]
    plant = {**LIMITED, "initial_euler_321": [5e-4, 3e-4, -4e-4]}
    flights = [
        from_sections(
            {"plant": plant, "nmpc_controller": {"feedback_bandwidth": 0.01, **controller}}
        ).build().run()
        for controller in ({"time_step": 10.0}, {"time_step": 10.0, "inertia": believed})
    ]  # fmt: skip
    ratio = flights[1].wheel_acceleration[0] / flights[0].wheel_acceleration[0]
    expected = np.array(believed)[::4] / np.array(AFRL["inertia"])[::4]
    assert ratio == pytest.approx(expected, rel=1e-3)
    assert np.array_equal(flights[0].total_momentum[0], flights[1].total_momentum[0])


REFUSED = {
    "two wheels": (
        {"wheel_axes": [1.0, 0.0, 0.0, 1.0, 0.0, 0.0], "wheel_inertias": [0.01, 0.01]}, {},
        r"plant.wheel_axes: received 2 .*span 2 dimension.*required 3, .*; add a wheel",
    ),
    "a third wheel nearly in the plane of the others": (
        {"wheel_axes": [1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1e-3]}, {},
        r"plant.wheel_axes: received 3 .*span 2 dimension.* some 0.1 deg apart count as one",
    ),
    "two wheels nearly about one axis": (
        {"wheel_axes": [1.0, 1.0, 0.0, 1e-3, 0.0, 0.0], "wheel_inertias": [0.043] * 2},
        {"method": "underactuated"}, r"plant.wheel_axes: received 2 .*span 1 dimension",
    ),
    "four wheels in a plane": (
        {"wheel_axes": [1.0, 0.0, 1.0, 1.0, 0.0, 1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0],
         "wheel_inertias": [0.01] * 4}, {},
        r"plant.wheel_axes: received 4 .*span 2 dimension",
    ),
    "a zero axis": (
        {"wheel_axes": [0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]}, {},
        r"plant.wheel_axes: .* of zeros",
    ),
    "an inertia too few": (
        {"wheel_inertias": [0.01, 0.01]}, {}, r"plant.wheel_inertias: .*; required 3 numbers",
    ),
    "wheels larger than the bus": (
        {"wheel_inertias": [500.0, 0.1, 0.1]}, {}, r"plant.wheel_inertias: .* leaves the bus",
    ),
    "rows of unequal length": (
        {"wheel_axes": ORTHOGONAL[:8]}, {}, r"plant.wheel_axes: .*write 3 rows",
    ),
    "speeds of other wheels": (
        {"initial_wheel_speed": [1.0, 2.0]}, {}, r"plant.initial_wheel_speed: .*required 3 numbers",
    ),
    "a speed above its limit": (
        {"initial_wheel_speed": [0.0, 0.0, -101.0]}, {},
        r"plant.initial_wheel_speed: .*at most max_wheel_speed \(100 rad/s\)",
    ),
    "losses of other wheels": (
        {"wheel_lost_at": [1.0]}, {}, r"plant.wheel_lost_at: .*required 3 numbers",
    ),
    "a loss beyond the flight": (
        {"wheel_lost_at": [-1.0, 2000.0, -1.0], "duration": 1000.0}, {"time_step": 10.0},
        r"plant.wheel_lost_at: .*required times up to the start of the last .*\(990 s\); lose",
    ),
    "a loss after the last control step has begun": (
        {"wheel_lost_at": [-1.0, 990.5, -1.0], "duration": 1000.0}, {"time_step": 10.0},
        r"plant.wheel_lost_at: .*\(990 s\)",
    ),
    "a share of a wheel that is dead": (
        {"lost_wheel_share": 0.3}, {}, r"plant.lost_wheel_share: .*; required wheel_loss: partial",
    ),
    "friction of a wheel that spins on": (
        {"lost_wheel_friction": 0.3, "wheel_loss": "spinning"}, {},
        r"plant.lost_wheel_friction: .*required wheel_loss: friction beside it; give 0.0 or leave",
    ),
    "an unknown loss": ({"wheel_loss": "stuck"}, {}, r"plant.wheel_loss: .*friction, spinning"),
    "friction of other wheels": (
        {"wheel_viscous_friction": [1e-3]}, {},
        r"plant.wheel_viscous_friction: .*required 3 numbers",
    ),
    "friction that drives": (
        {"wheel_coulomb_friction": [-1e-3, 0.0, 0.0]}, {},
        r"plant.wheel_coulomb_friction: .*0 to 1e\+15",
    ),
    "a momentum beside a rate": (
        {"initial_total_momentum": [0.0] * 3, "initial_angular_velocity": [0.1, 0.0, 0.0]}, {},
        r"plant.initial_angular_velocity: .*either it or initial_total_momentum; remove one",
    ),
    "one wheel": (
        {"wheel_axes": [1.0, 0.0, 0.0], "wheel_inertias": [0.01]}, {},
        r"plant.wheel_axes: received 1 .*span 1 dimension",
    ),
    "two starts": (
        {"initial_euler_321": [0.1, 0.0, 0.0], "initial_rotation_vector": [0.1, 0.0, 0.0]}, {},
        r"plant.initial_rotation_vector: .*either it or initial_euler_321; remove one",
    ),
    "nothing but a vehicle": (
        {"inertia": [], "wheel_axes": [], "wheel_inertias": []}, {},
        r"(?s)plant.inertia: received nothing.*plant.wheel_axes.*plant.wheel_inertias",
    ),
    "a belief in other wheels": (
        {}, {"wheel_axes": [1.0] * 3 + [0.0, 1.0, 0.0, 0.0] + [0.0] * 4 + [1.0],
             "wheel_inertias": [0.01] * 4},
        r"nmpc_controller.wheel_axes: received 4 wheels; required as many as plant.wheel_axes",
    ),
    "another vehicle's parameters": (
        {"initial_momentum": [0.0, 0.0, 0.0]}, {"max_torque": 1.0},
        r"plant.vehicle: received 'two_wheel' beside parameters of vehicle rigid_body",
    ),
    "another vehicle's method": (
        {}, {"method": "terminal_set"}, r"nmpc_controller.method: .*required one of feedback",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("plant", "controller", "words"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_fly_is_refused(plant, controller, words):
    with pytest.raises(InvalidScenario, match=words):
        from_sections({"plant": {**LIMITED, **plant}, "nmpc_controller": controller})


def test_a_rigid_body_with_wheels_is_told_which_vehicle_it_wants(tmp_path, capsys):
    file = tmp_path / "mixed.yaml"
    file.write_text(load("three_wheel_slew").to_yaml().replace("two_wheel", "rigid_body"))
    assert _exit_code(["check", str(file)]) == 2
    assert "set vehicle: two_wheel" in capsys.readouterr().err


def test_check_and_simulate_tell_of_wheels(capsys):
    assert _exit_code(["check", "three_wheel_slew"]) == 0
    assert "3 wheels" in capsys.readouterr().out
    assert _exit_code(["simulate", "three_wheel_slew", "-q"]) == 0
    assert _exit_code(["simulate", "three_wheel_slew"]) == 0
    assert "limit 100 rad/s" in capsys.readouterr().out


def test_check_tells_of_friction_losses_and_the_method(capsys):
    lost = "plant.wheel_lost_at=[-1.0, 150.0, -1.0]"
    rub = "plant.wheel_coulomb_friction=[0.0, 0.002, 0.001]"
    assert _exit_code(["check", "three_wheel_slew", "--set", lost, "--set", rub]) == 0
    told = capsys.readouterr().out
    assert "Coulomb up to 0.002 N m" in told
    assert "2 at 150 s: braked by 0.0215 N m" in told
    assert "controller      feedback, bandwidth 0.012 rad/s, damping ratio 1" in told
    total = "plant.initial_total_momentum=[3.0, 4.0, 0.0]"
    assert _exit_code(["check", "afrl_wheel_loss", "--set", total]) == 0
    told = capsys.readouterr().out
    assert "total momentum 5 N m s" in told
    assert "two wheels: N = 30, model so3, solver sqp, end shaped" in told


def _exit_code(argv):
    try:
        main(argv)
    except SystemExit as end:
        return end.code or 0
    return 0
