"""The variations file: what it gives each run, and every problem of it at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spacecraft_gnc.campaign.design import Design
from spacecraft_gnc.campaign.variations import load_variations
from spacecraft_gnc.parameters.problems import InvalidScenario
from spacecraft_gnc.scenario import load

CONFIG = Path(__file__).resolve().parents[2] / "config"
SCENARIO = load(CONFIG / "gupta2015_case1.yaml")
ZONES = load(CONFIG / "gupta2015_case2.yaml")
WHEELS = load(CONFIG / "three_wheel_slew.yaml")
TEXT = """\
sampling: sobol
runs: 200
vary:
  plant.initial_rotation_vector: {distribution: rotation, max_angle_deg: 60.0}
  plant.inertia: {distribution: inertia, factor: 0.1, axes_deg: 5.0}
  plant.initial_momentum:
    distribution: direction
    length: {distribution: uniform, from: 0.0, to: 0.02}
  nmpc_controller.horizon: {distribution: choice, values: [5, 8]}
  nmpc_controller.method: {distribution: constant, value: shooting}
pass: final_error_deg < 0.1 and "settle_time_1deg" < 140
worst: 5
"""
CONTINUUM = "vary: {plant.duration: {distribution: uniform, from: 1.0, to: 2.0}}\n"
PAIR = "vary: {nmpc_controller.horizon: {distribution: choice, values: [5, 8]}}\n"
HUGE = """\
vary:
  plant.duration: {distribution: choice, linspace: [1, 2, 100000]}
  nmpc_controller.max_torque: {distribution: choice, linspace: [1, 2, 100000]}
"""
PASS = "pass: final_error_deg < 0.1\n"


def variations(text, scenario=SCENARIO):
    return load_variations("v.yaml", scenario, text)


def varied(lines, scenario=SCENARIO, head=""):
    indented = "".join(f"  {line}\n" for line in lines)
    return variations(f"{PASS}{head}vary:\n{indented}", scenario)


def problems(text, scenario=SCENARIO):
    with pytest.raises(InvalidScenario) as caught:
        variations(text, scenario)
    return str(caught.value).split("\n")


def test_a_file_is_read_whole(tmp_path):
    file = tmp_path / "v.yaml"
    file.write_text(TEXT)
    for found in (load_variations(file, SCENARIO), load_variations(str(file), SCENARIO, TEXT)):
        assert (found.path, found.text) == (str(file), TEXT)
        assert (found.sampling, found.runs, found.worst) == ("sobol", 200, 5)
        assert found.names == (
            "plant.initial_rotation_vector",
            "plant.inertia",
            "plant.initial_momentum",
            "nmpc_controller.horizon",
            "nmpc_controller.method",
        )
        assert (found.dimensions, found.grid_size) == (13, None)
        assert found.criterion.names == {"final_error_deg", "settle_time_1deg"}


def test_what_is_left_out_takes_its_default():
    found = variations(PASS)
    assert (found.sampling, found.runs, found.worst) == ("random", None, 3)
    assert (found.names, found.dimensions) == ((), 0)
    assert found.values(np.zeros(0)) == {}


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10**6), st.sampled_from(["random", "sobol"]))
def test_the_values_of_every_run_are_admitted_by_the_scenario(run, sampling):
    found = variations(TEXT.replace("sampling: sobol", f"sampling: {sampling}"))
    point = Design(found, 3, 10**6 + 1).points(run, 1)[0]
    values = found.values(point)
    assert tuple(values) == found.names
    flown = load(CONFIG / "gupta2015_case1.yaml", values | {"plant.duration": 1000.0})
    for name, value in values.items():
        section, _, key = name.partition(".")
        assert flown.values[section][key] == value


def test_an_inertia_left_to_the_plant_varies_about_that_of_the_plant():
    found = varied(["nmpc_controller.inertia: {distribution: inertia, factor: 0.1}"])
    (value,) = found.values(np.full(3, 0.5)).values()
    np.testing.assert_allclose(value, np.diag([1.0, 0.8, 0.8]).ravel(), atol=1e-15)


def test_a_zone_and_the_wheels_of_another_vehicle_vary_too():
    (zone,) = ZONES.controller.zones
    name = f"nmpc_controller.zones.{zone.name}.half_angle_deg"
    found = varied([f"{name}: {{distribution: uniform, from: 10.0, to: 20.0}}"], ZONES)
    assert found.values(np.array([0.5])) == {name: 15.0}
    name, count = "plant.wheel_inertias", len(WHEELS.values["plant"]["wheel_inertias"])
    found = varied([f"{name}: {{distribution: uniform, from: 1.0, to: 2.0}}"], WHEELS)
    assert found.dimensions == count
    assert found.values(np.zeros(count)) == {name: [1.0] * count}


def test_a_grid_is_the_product_of_its_lists():
    lines = [
        "nmpc_controller.horizon: {distribution: choice, values: [5, 8, 10]}",
        "plant.duration: {distribution: choice, linspace: [150, 300, 4]}",
        "plant.pose_every: {distribution: constant, value: 2}",
    ]
    found = varied(lines, head="sampling: grid\n")
    assert (found.grid_size, Design(found).runs) == (12, 12)
    assert found.values(Design(found).points(5, 1)[0]) == {
        "nmpc_controller.horizon": 8,
        "plant.duration": 200.0,
        "plant.pose_every": 2,
    }


def test_every_problem_is_named_with_its_line():
    text = """\
sampling: randm
runs: 0
vary:
  plant.initial_rotation_vecto: {distribution: rotation}
  plant.inertia: {distribution: inertia, factor: 1.5, axes_deg: -5.0}
  plant.initial_momentum:
    distribution: uniform
    from: [0.0, 0.0, 0.0]
    to: [1.0, .nan, 1.0]
    form: 3
  nmpc_controller.horizon: {distribution: choice, values: [5, 8.5]}
  nmpc_controller.horizon: {distribution: choice, values: [5, 8]}
  plant.duration: {distribution: normal, mean: 1.0, std: 1.0}
  nmpc_controller.time_step: 0.4
  plant.seed: {distribution: constant, value: 1}
pass: open('x') < 1
worst: many
extra: 3
"""
    lines = problems(text)
    expected = [
        ("1: sampling", "did you mean 'random'?"),
        ("2: runs", "received 0"),
        ("4: plant.initial_rotation_vecto", "did you mean 'initial_rotation_vector'?"),
        ("5: plant.inertia.factor", "received 1.5"),
        ("5: plant.inertia.axes_deg", "received -5.0"),
        ("9: plant.initial_momentum.to", "received [1.0, nan, 1.0]"),
        ("10: plant.initial_momentum.form", "did you mean 'from'?"),
        ("11: nmpc_controller.horizon.values", "received 8.5"),
        ("12: vary.nmpc_controller.horizon", "a second time (first on line 11)"),
        ("13: plant.duration", "received -7.29"),
        ("14: nmpc_controller.time_step", "write {distribution: constant, value: 0.4}"),
        ("15: plant.seed", "the seed of the campaign"),
        ("16: pass", "there are no functions"),
        ("17: worst", "received 'many'"),
        ("18: extra", "an unknown key"),
    ]
    assert len(lines) == len(expected)
    for line, (start, part) in zip(lines, expected, strict=True):
        assert line.startswith(f"v.yaml:{start}: received "), line
        assert part in line
        assert "; required " in line


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("plant.vehicle: {distribution: constant, value: two_wheel}", "one vehicle throughout"),
        ("plant.run: {distribution: constant, value: 1}", "the number of the run"),
        ("recorder.topics: {distribution: constant, value: []}", "a node out of plant"),
        ("plnt.duration: {distribution: constant, value: 1.0}", "did you mean 'plant'?"),
        ("/sc1/plant.duration: {distribution: constant, value: 1.0}", "did you mean 'plant'?"),
        ("plant: {distribution: constant, value: 1.0}", "add the name of the parameter"),
        ("plant.duration: {}", "plant.duration.distribution: received nothing"),
        ("plant.duration: [1.0, 2.0]", "received a nested list; required a distribution"),
        ("plant.duration: {distribution: constant, value: 1e-9}", "received 1e-09"),
        ("plant.inertia: {distribution: constant, value: [1, 0, 0, 0, 1, 0, 0, 0, 3]}", "triangle"),
        (
            "nmpc_controller.method: {distribution: choice, values: [shooting, shoting]}",
            "did you mean 'shooting'?",
        ),
        (
            "reference_governor.steady_margin_deg: {distribution: constant, value: 1.0}",
            "a governor that reads it (attitude), not none",
        ),
        (
            "nmpc_controller.zones.sun.half_angle_deg: {distribution: constant, value: 1.0}",
            "unknown",
        ),
        ("nmpc_controller.plugin.gain: {distribution: constant, value: 1.0}", "in the scenario"),
        ("plant.wheel_inertias: {distribution: constant, value: [1.0]}", "an unknown parameter"),
        ("[1]: {distribution: constant, value: [1.0]}", "a key that is no word"),
    ],
)
def test_a_line_that_varies_nothing_of_the_scenario_is_refused(line, reason):
    (problem,) = problems(f"{PASS}vary:\n  {line}\n")
    assert problem.startswith("v.yaml:3: ")
    assert reason in problem


def test_a_parameter_of_another_method_may_vary_together_with_the_method():
    lines = [
        "reference_governor.steady_margin_deg: {distribution: constant, value: 1.0}",
        "reference_governor.governor: {distribution: constant, value: attitude}",
    ]
    assert len(varied(lines).names) == 2


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "v.yaml: received an empty file; required a readable variations file"),
        ("# nothing\n", "v.yaml: received an empty file"),
        ("- 1\n", "v.yaml: received a nested list"),
        ("a: [\n", "v.yaml:2: received bad YAML"),
        ("{" * 5000, "nested too deeply"),
        ("a: \0\n", "v.yaml:1: received bad YAML (a forbidden character)"),
        ("pass: &a b < 1\nvary: *a\n", "no aliases"),
        ("sampling: random\n", "pass: received nothing; required what counts as success"),
        (f"{PASS}{PASS}", "v.yaml:2: pass: received the key a second time"),
        ("pass: [a < 1]\n", "v.yaml:1: pass: received a nested list"),
        ("pass: true\n", "no metric in it"),
        (f"{PASS}vary: 3\n", "v.yaml:2: vary: received '3'"),
        (f"{PASS}vary:\n", "v.yaml:2: vary: received nothing"),
        (f"{PASS}runs: 1.5\n", "v.yaml:2: runs: received 1.5 (a number)"),
        (f"{PASS}runs: -3\n", "runs: received -3"),
        (f"{PASS}sampling: grid\n", "vary: received an empty grid"),
        (f"{PASS}sampling: grid\nvary: {{}}\n", "vary: received an empty grid"),
        (f"{PASS}sampling: grid\n{CONTINUUM}", "a continuum for plant.duration"),
        (f"{PASS}sampling: grid\nruns: 3\n{PAIR}", "v.yaml:3: runs: received 3; required at most"),
        (f"{PASS}sampling: grid\n{HUGE}", "a grid of 1e+10 cells"),
    ],
)
def test_what_is_no_variations_file_is_refused(text, reason):
    (problem,) = problems(text)
    assert reason in problem


@pytest.mark.parametrize("name", ["missing.yaml", "."])
def test_what_is_no_file_is_refused(name, tmp_path):
    with pytest.raises(InvalidScenario, match="required a readable variations file"):
        load_variations(tmp_path / name, SCENARIO)


@settings(deadline=None)
@given(st.text(max_size=60) | st.text("abvry:{}[] \n-'\"&*!,.0123", max_size=60))
def test_any_text_is_read_or_refused(text):
    try:
        found = variations(text)
    except InvalidScenario:
        return
    assert found.criterion.names
