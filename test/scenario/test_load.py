"""A scenario file to typed parameters, and back."""

from __future__ import annotations

import array
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.scenario import (
    InvalidScenario,
    from_sections,
    load,
    load_fleet,
    read_sections,
)
from spacecraft_gnc.scenario.checks import steps_in
from spacecraft_gnc.scenario.schema import ROLES

CONFIG = Path(__file__).resolve().parents[2] / "config"
CASE_1 = CONFIG / "gupta2015_case1.yaml"
INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
ZONE = {
    "kind": "inclusion",
    "body_axis": [1.0, 0.0, 0.0],
    "inertial_axis": [2.0, 0.0, 0.0],
    "half_angle_deg": 60.0,
    "penalty": 10.0,
}


@pytest.mark.parametrize("path", sorted(CONFIG.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_scenario_of_the_package_is_good(path: Path) -> None:
    assert load_fleet(path).n_steps >= 1


def test_case_1_has_the_figures_of_the_paper() -> None:
    scenario = load(CASE_1)
    assert scenario.path == str(CASE_1)
    assert (scenario.n_steps, scenario.substeps, scenario.period) == (375, 1, 0.4)
    assert scenario.controller.horizon == 5
    assert scenario.controller.max_torque == 0.01
    assert scenario.controller.torque_penalty == 1e10
    assert scenario.controller.zones == ()
    np.testing.assert_array_equal(scenario.plant.inertia, np.diag([1.0, 0.8, 0.8]))
    np.testing.assert_array_equal(scenario.controller.weights.stage_attitude, 0.01 * np.eye(3))
    np.testing.assert_array_equal(scenario.controller.weights.stage_torque, np.eye(3))
    assert scenario.launcher.domain_id == -1


def test_arrays_are_read_only() -> None:
    scenario = load(CASE_1)
    for array_ in (scenario.plant.inertia, scenario.controller.weights.stage_torque):
        assert array_.dtype == np.float64
        assert not array_.flags.writeable


def test_the_controller_takes_over_from_the_plant() -> None:
    scenario = from_sections({"plant": {"inertia": INERTIA, "time_step": 0.2}})
    np.testing.assert_array_equal(scenario.controller.inertia, scenario.plant.inertia)
    assert scenario.controller.time_step == 0.2


def test_the_controller_may_believe_otherwise() -> None:
    own = [1.1, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
    scenario = from_sections(
        {
            "plant": {"inertia": INERTIA, "time_step": 0.4},
            "nmpc_controller": {"inertia": own, "time_step": 0.8},
        }
    )
    assert scenario.controller.inertia[0, 0] == 1.1
    assert (scenario.substeps, scenario.period) == (2, 0.8)


def test_zones_and_weights() -> None:
    weight = [2.0, 0.5, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0, 1.0]
    scenario = from_sections(
        {
            "plant": {"inertia": INERTIA},
            "nmpc_controller": {
                "zone_names": ["sun", "earth"],
                "zones": {
                    "earth": {**ZONE, "inertial_axis": [1.0, 1.0, 0.0], "penalty": 3},
                    "sun": ZONE,
                },
                "weights": {"stage_attitude": weight, "stage_torque": 2},
            },
        }
    )
    sun, earth = scenario.controller.zones
    assert (sun.name, earth.name) == ("sun", "earth")
    assert (sun.kind, sun.half_angle_deg, sun.penalty, earth.penalty) == (
        "inclusion", 60.0, 10.0, 3.0,
    )  # fmt: skip
    np.testing.assert_array_equal(sun.inertial_axis, [2.0, 0.0, 0.0])
    np.testing.assert_array_equal(scenario.controller.weights.stage_attitude.ravel(), weight)
    np.testing.assert_array_equal(scenario.controller.weights.stage_torque, 2.0 * np.eye(3))


def test_actuators_come_as_columns() -> None:
    four = [1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.5]
    controller = {"actuators": four}
    scenario = from_sections({"plant": {"inertia": INERTIA}, "nmpc_controller": controller})
    np.testing.assert_array_equal(scenario.controller.actuators[:, 3], [0.5, 0.5, 0.5])
    assert load(CASE_1).controller.actuators.shape == (3, 0)
    assert np.isnan(load(CASE_1).controller.nominal_rotation_vector).all()


@pytest.mark.parametrize("section", [name for name in ROLES if name != "plant"])
def test_a_node_alone_needs_no_plant(section: str) -> None:
    given_inertia = {"inertia": INERTIA} if section == "nmpc_controller" else {}
    scenario = from_sections({section: given_inertia})
    assert np.isnan(scenario.plant.inertia).all()
    with pytest.raises(InvalidScenario, match=r"plant\.inertia: received nothing"):
        scenario.build_plant()


@pytest.mark.parametrize("section", ["plant", "nmpc_controller"])
def test_whoever_needs_the_inertia_asks_for_it(section: str) -> None:
    with pytest.raises(InvalidScenario, match=r"plant\.inertia: received nothing"):
        from_sections({section: {}})


def test_parameters_of_a_live_node() -> None:
    """A node holds dotted names, arrays of its own type, and None for an empty list."""
    scenario = from_sections(
        {
            "plant": {
                "inertia": array.array("d", INERTIA),
                "initial_momentum": np.array([0.0, 0.0, 0.1]),
                "peers": (),
                "use_sim_time": True,
                "start_type_description_service": True,
                "qos_overrides./clock.publisher.depth": 1,
            },
            "nmpc_controller": {"weights.stage_torque": 2.0, "zone_names": None},
        },
        "/plant",
    )
    assert scenario.plant.initial_momentum[2] == 0.1
    assert scenario.plant.peers == ()
    assert scenario.controller.weights.stage_torque[0, 0] == 2.0


def test_unknown_section() -> None:
    with pytest.raises(InvalidScenario, match="required one of plant") as error:
        from_sections({"plnt": {}, "recorder": {"chunk_size": 1}}, "here")
    assert [problem.key for problem in error.value.problems] == ["plnt", "recorder.chunk_size"]
    assert {problem.file for problem in error.value.problems} == {"here"}


OVERRIDES: dict[str, Any] = {
    "strings": ["plant.duration=10", "nmpc_controller.weights={stage_torque: 2}"],
    "dotted": {"plant.duration": 10, "nmpc_controller.weights.stage_torque": 2.0},
    "nested": {"plant": {"duration": 10.0}, "nmpc_controller": {"weights": {"stage_torque": 2}}},
}


@pytest.mark.parametrize("overrides", OVERRIDES.values(), ids=OVERRIDES.keys())
def test_overrides(overrides: Any) -> None:
    scenario = load(CASE_1, overrides)
    assert scenario.plant.duration == 10.0
    assert isinstance(scenario.plant.duration, float)
    assert scenario.controller.weights.stage_torque[0, 0] == 2.0
    assert scenario.controller.weights.stage_attitude[0, 0] == 0.01
    assert scenario.sections["plant"]["duration"] == 10.0
    assert scenario.sections["nmpc_controller"]["weights"]["stage_torque"] == 2.0


def test_override_of_a_whole_zone() -> None:
    zone = "{body_axis: [1, 0, 0], inertial_axis: [0, 1, 0], half_angle_deg: 5}"
    scenario = load(CASE_1, ["nmpc_controller.zone_names=[a]", f"nmpc_controller.zones.a={zone}"])
    assert scenario.controller.zones[0].half_angle_deg == 5.0


def test_an_override_mends_what_the_file_gets_wrong(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(CASE_1.read_text(encoding="utf-8").replace("horizon: 5", "horizon: 0"))
    assert load(path, ["nmpc_controller.horizon=3"]).controller.horizon == 3


def test_wildcards_give_each_node_what_it_knows(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(
        "/**:\n  ros__parameters:\n    use_sim_time: true\n    time_step: 0.2\n"
        "    autostart: false\n"
        f"plant:\n  ros__parameters:\n    inertia: {INERTIA}\n    time_step: 0.1\n"
    )
    scenario = load(path)
    assert (scenario.plant.time_step, scenario.controller.time_step) == (0.1, 0.2)
    assert not scenario.recorder.autostart
    assert scenario.sections["plant"]["use_sim_time"] is True
    assert scenario.warnings == ()


@pytest.mark.parametrize("name", ["plant", "/plant", "/sat1/plant", "sat1: {plant: "])
def test_namespaces(name: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    if "{" in name:
        path.write_text(f"{name}{{ros__parameters: {{inertia: {INERTIA}}}}}}}\n")
    else:
        path.write_text(f"{name}: {{ros__parameters: {{inertia: {INERTIA}}}}}\n")
    assert load(path).plant.inertia[0, 0] == 1.0


def test_one_spacecraft_of_several(tmp_path: Path) -> None:
    path = tmp_path / "two.yaml"
    sections = (
        f"{name}: {{ros__parameters: {{inertia: {INERTIA}, duration: {duration}}}}}"
        for name, duration in (("/chaser/plant", 10.0), ("target: {plant", 20.0))
    )
    path.write_text("\n".join(sections) + "}\n")
    with pytest.raises(InvalidScenario, match=r"\(/chaser, /target\); required one; name it with"):
        load(path)
    chaser = load(path, namespace="chaser")
    assert chaser.plant.duration == 10.0
    assert chaser.warnings == (
        f"{path}: /target/plant: not read, no node of namespace /chaser matches",
    )
    assert read_sections(path, "/target")["plant"]["duration"] == 20.0
    with pytest.raises(InvalidScenario, match="/third; required one of /chaser, /target"):
        load(path, namespace="third")


@pytest.mark.parametrize(
    "name", ["//plant", "/plant/", "a: {/plant", "1a/plant", "p*/plant", "/***"]
)
def test_no_name_of_a_node(name: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(f"{name}: {{ros__parameters: {{inertia: {INERTIA}}}}}" + "}" * name.count("{"))
    with pytest.raises(InvalidScenario, match=r"received (no name of a|an unknown) node; required"):
        load(path)


def test_plugin_parameters_pass_through(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(
        f"plant:\n  ros__parameters:\n    inertia: {INERTIA}\n"
        "    plugin:\n      gain: 2.0\n      deep: {names: [a, b]}\n"
    )
    scenario = load(path)
    assert scenario.plant.plugin == {"gain": 2.0, "deep.names": ["a", "b"]}
    again = from_sections(scenario.values, "values")
    assert again.plant.plugin == scenario.plant.plugin


def test_plugin_parameters_are_numbers_too() -> None:
    with pytest.raises(InvalidScenario, match="finite"):
        from_sections({"recorder": {"plugin.x": [1.0, float("nan")]}})
    with pytest.raises(InvalidScenario, match="launcher"):
        from_sections({"launcher": {"plugin.x": 1.0}})


@pytest.mark.parametrize("defaults", [False, True])
def test_round_trip(defaults: bool, tmp_path: Path) -> None:
    path = tmp_path / "again.yaml"
    scenario = load(
        CASE_1,
        {
            "recorder.storage_folder": "on",  # a boolean unless quoted
            "recorder.topics": ["y", "1e3", "/a b", "null", "x"],
            "plant.duration": 1e-5 * 4e4 * 400,
            "nmpc_controller.residual_tolerance": 1e-12,
            "nmpc_controller.torque_penalty": 1e22,
            "nmpc_controller.zone_names": ["a"],
            "nmpc_controller.zones.a": ZONE,
            "plant.peers": [],
        },
    )
    path.write_text(scenario.to_yaml(defaults))
    again = load(path)
    assert again.values == scenario.values
    assert again.to_yaml(defaults=True) == scenario.to_yaml(defaults=True)


def test_read_sections_is_what_the_file_says() -> None:
    sections = read_sections(CASE_1)
    assert sections["plant"]["duration"] == 150.0
    assert sections["nmpc_controller"]["weights.stage_torque"] == 1.0
    assert from_sections(sections).values == load(CASE_1).values


def test_read_sections_reports_what_ros_could_not_read(tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text("plant:\n  ros__parameters:\n    a:\n")
    with pytest.raises(InvalidScenario, match=r"plant\.a: received nothing"):
        read_sections(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("plant: {ros__parameters: }", "'name: value' lines beneath ros__parameters"),
        ("plant: {ros__parameters: {plugin: {a: {}, b: 1}}}", r"plant\.plugin\.a: received {}"),
        ("%YAML 1.2\n---\nplant: {ros__parameters: {}}", r":2: received .*YAML 1\.1"),
    ],
)
def test_what_ros_refuses_is_refused(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "a.yaml"
    path.write_text(text)
    with pytest.raises(InvalidScenario, match=words):
        read_sections(path)


@given(st.floats(1e-6, 1e3), st.integers(1, 10**6))
def test_whole_multiples_are_recognized(step: float, count: int) -> None:
    assert steps_in(step * count, step) == count
    assert steps_in(step * (count + 0.5), step) is None


def test_a_momentum_that_turns_beyond_the_integrator_is_refused() -> None:
    """Its first step exists; the free body lacks a later one."""
    body, momentum = RigidBody(np.diag([1.0, 0.7, 0.5]), 0.4), [0.6, 0.2, 0.3]
    assert body.is_solvable(np.array(momentum))
    with pytest.raises(ParameterError, match="at step"):
        body.simulate(np.eye(3), momentum, np.zeros(3), 100)
    plant = {"inertia": body.inertia.ravel().tolist(), "initial_momentum": momentum}
    with pytest.raises(InvalidScenario, match=r"Kalabic.*in free motion from"):
        from_sections({"plant": plant | {"time_step": 0.4}})
    assert from_sections({"plant": plant | {"time_step": 0.38}}).plant.time_step == 0.38


def test_a_method_that_is_laid_over_leaves_out_what_it_does_not_read() -> None:
    """The file's weights are another method's; one line says which are not read."""
    scenario = load(CASE_1, ["nmpc_controller.method=feedback"])
    (warning,) = scenario.warnings
    assert warning.startswith(f"{CASE_1}: not read by method feedback: nmpc_controller.horizon, ")
    assert warning.endswith("torque_penalty")
    assert "horizon" not in scenario.sections["nmpc_controller"]
    assert from_sections(scenario.values).values == scenario.values
    with pytest.raises(InvalidScenario, match="required a method that reads it"):
        load(CASE_1, ["nmpc_controller.method=feedback", "nmpc_controller.horizon=6"])
    assert load(CASE_1, ["nmpc_controller.method=neighboring_extremal"]).warnings == ()
