"""The shortest time: under every flight that is flown, and reached by the best one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import inertias

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.scenario import InvalidScenario, Scenario, from_sections, load
from spacecraft_gnc.vehicles.rigid_body.checks.torque import shortest_time

INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
MOMENTS = st.floats(0.2, 10.0)
TORQUES = st.floats(1e-3, 1.0)
TIMES = st.floats(0.0, 50.0)


def from_file(folder, duration: str, controller: str = "", launcher: str = "") -> str:
    """Write a scenario of 90 deg about y (0.8 kg m^2) at rest; return its path."""
    path = folder / "scenario.yaml"
    path.write_text(
        f"plant:\n  ros__parameters:\n    inertia: {INERTIA}\n    {duration}\n"
        "    initial_rotation_vector: [0.0, 1.5707963267948966, 0.0]\n"
        f"nmpc_controller:\n  ros__parameters:\n    max_torque: 0.02\n{controller}{launcher}",
        encoding="utf-8",
    )
    return str(path)


@given(MOMENTS, TORQUES, TIMES, TIMES, st.floats(1.0, 3.0))
def test_a_bang_bang_slew_about_a_principal_axis_takes_as_long_or_longer(
    moment: float, torque: float, speed_up: float, coast: float, share: float
) -> None:
    """From rest: speed up, coast, slow down, about an axis of ``share`` times the least moment."""
    rate = torque * speed_up / (share * moment)
    flown = 2.0 * speed_up + coast
    bound = shortest_time(rate * (speed_up + coast), 0.0, torque, moment)
    assert bound <= flown * (1.0 + 1e-12)
    if coast == 0.0 and share == 1.0:
        assert bound == pytest.approx(flown)


@given(MOMENTS, TORQUES, st.floats(0.0, 5.0), st.floats(0.0, 20.0))
def test_the_best_slew_of_a_turning_body_takes_just_as_long(
    moment: float, torque: float, momentum: float, speed_up: float
) -> None:
    """About the axis of least moment: speed up further, then slow down to rest."""
    peak = momentum + torque * speed_up
    angle = (0.5 * (momentum + peak) * speed_up + 0.5 * peak * peak / torque) / moment
    bound = shortest_time(angle, momentum, torque, moment)
    assert bound == pytest.approx(speed_up + peak / torque)


@given(inertias(), TORQUES, st.integers(1, 60), st.integers(0, 2**32 - 1))
def test_no_flight_backwards_from_rest_undercuts_it(
    inertia: np.ndarray, torque: float, n_steps: int, seed: int
) -> None:
    """A flight from rest, seen backwards, ends at rest: its time is one step above the bound."""
    rng = np.random.default_rng(seed)
    step = 0.2
    body = RigidBody(inertia, step)
    attitude, momentum = np.eye(3), np.zeros(3)
    pushed = rng.normal(size=3)
    flown = 0
    while flown < n_steps and body.is_solvable(momentum):
        pushed += 0.3 * rng.normal(size=3)
        command = torque * pushed / np.linalg.norm(pushed)
        attitude, momentum = body.step(attitude, momentum, command)
        flown += 1
    angle = lie.angle_between(np.eye(3), attitude)
    bound = shortest_time(angle, float(np.linalg.norm(momentum)), torque, smallest(inertia))
    assert bound <= (flown + 1) * step


def smallest(inertia: np.ndarray) -> float:
    return float(np.linalg.eigvalsh(inertia)[0])


@given(st.floats(0.0, math.pi), st.floats(0.0, 5.0), TORQUES, MOMENTS)
def test_it_is_monotonous(angle: float, momentum: float, torque: float, moment: float) -> None:
    time = shortest_time(angle, momentum, torque, moment)
    assert time >= momentum / torque * (1.0 - 1e-12)
    assert shortest_time(angle + 0.1, momentum, torque, moment) >= time
    assert shortest_time(angle, momentum, 1.1 * torque, moment) <= time


# Least time at 0.02 N m: 2 sqrt(0.8 * (pi / 2) / 0.02) = 15.85 s


@pytest.mark.parametrize("duration", ["duration: 15.0", "duration: 4.0"])
def test_a_duration_in_the_file_is_held_against_the_bound(tmp_path, duration: str) -> None:
    message = (
        r"plant\.duration: received .* s; required at least 15\.85 s, the shortest time from 90"
    )
    with pytest.raises(InvalidScenario, match=message) as error:
        load(from_file(tmp_path, duration))
    assert [problem.line for problem in error.value.problems] == [4]


@pytest.mark.parametrize(
    ("controller", "launcher"),
    [
        ("", "launcher: {ros__parameters: {nodes: [plant, recorder]}}\n"),  # nobody steers
        ("    actuators: [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0]\n", ""),
        ("    actuators: [2.0, 0.0, 0.0, 2.0, 0.0, 0.0]\n", ""),  # rank 2
    ],
)
def test_what_brings_it_into_reach(tmp_path, controller: str, launcher: str) -> None:
    assert load(from_file(tmp_path, "duration: 12.0", controller, launcher)).plant.duration == 12.0


@pytest.mark.parametrize("overrides", [["plant.duration=4"], {"plant.duration": 4.0}])
def test_a_flight_may_be_cut_short_on_purpose(tmp_path, overrides) -> None:
    path = from_file(tmp_path, "duration: 20.0")
    assert load(path, overrides).plant.duration == 4.0


def test_an_override_is_held_against_the_duration_of_the_file(tmp_path) -> None:
    path = from_file(tmp_path, "duration: 20.0")
    with pytest.raises(InvalidScenario, match=r"required at least 22\.42 s"):
        load(path, ["nmpc_controller.max_torque=0.01"])
    assert load(path, ["nmpc_controller.max_torque=0.0"]).controller.max_torque == 0.0


def test_the_limit_of_the_governor_counts_too(tmp_path) -> None:
    path = from_file(tmp_path, "duration: 20.0", "    method: feedback\n")
    governed = ["reference_governor.governor=attitude", "reference_governor.max_torque=0.01"]
    message = r"at least 22\.42 s.*0\.01 N m at the most; .* raise reference_governor\.max_torque"
    with pytest.raises(InvalidScenario, match=message):
        load(path, governed)
    with pytest.raises(InvalidScenario, match=message):
        load(path, [*governed, "nmpc_controller.max_torque=0.0"])
    governed[1] = "reference_governor.max_torque=0.0"
    assert load(path, governed).controller.max_torque == 0.02


def built(**controller: object) -> Scenario:
    return from_sections({"plant": {"inertia": INERTIA}, "nmpc_controller": controller})


def test_a_multiple_of_the_identity_weighs_any_number_of_actuators() -> None:
    four = [1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.5]
    for weight in (2.0, [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0]):
        assert built(actuators=four, weights={"stage_torque": weight}).n_steps > 0
    full = [2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0]
    assert built(actuators=np.eye(3).ravel(), weights={"stage_torque": full})
    with pytest.raises(InvalidScenario, match="the actuator matrix has 4 columns and not 3"):
        built(actuators=four, weights={"stage_torque": full})


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=12))
def test_any_actuators_are_taken_or_refused(numbers: list[float]) -> None:
    try:
        matrix = built(actuators=numbers).controller.actuators
    except InvalidScenario as error:
        keys = {problem.key for problem in error.problems}
    else:
        keys = {"nmpc_controller.actuators"}
        assert matrix.shape[0] == 3
        assert matrix.size == 0 or np.linalg.matrix_rank(matrix / np.abs(matrix).max()) >= 2
    assert keys == {"nmpc_controller.actuators"}
