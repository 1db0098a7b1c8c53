"""A template makes the scenarios that the file itself would."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spacecraft_gnc.scenario import InvalidScenario, Scenario, Template, load
from spacecraft_gnc.scenario.fingerprint import fingerprint

CONFIG = Path(__file__).resolve().parents[2] / "config"
CASE_1 = CONFIG / "gupta2015_case1.yaml"
SEVERAL = CONFIG / "two_spacecraft.yaml"
OF_ONE = [path for path in sorted(CONFIG.glob("*.yaml")) if path != SEVERAL]
BASE = ["plant.initial_momentum=[0.01, 0.0, 0.0]", "nmpc_controller.horizon=6"]


def loaded(path: Path, overrides: Any = ()) -> Scenario | InvalidScenario:
    try:
        return load(path, overrides)
    except InvalidScenario as refusal:
        return refusal


def made(template: Template, overrides: Any = ()) -> Scenario | InvalidScenario:
    try:
        return template.scenario(overrides)
    except InvalidScenario as refusal:
        return refusal


def plain(value: Any) -> Any:
    """Return a section as what compares by value, types included."""
    if dataclasses.is_dataclass(value):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return value.dtype, value.shape, value.tobytes(), value.flags.writeable
    if isinstance(value, tuple):
        return tuple(map(plain, value))
    return type(value), value


def assert_same(first: Scenario | InvalidScenario, second: Scenario | InvalidScenario) -> None:
    assert type(first) is type(second)
    if isinstance(first, InvalidScenario) or isinstance(second, InvalidScenario):
        assert first.problems == second.problems  # type: ignore[union-attr]
        return
    for name in ("plant", "controller", "governor", "recorder", "launcher"):
        assert plain(getattr(first, name)) == plain(getattr(second, name)), name
    for name in ("vehicle", "path", "values", "defaults", "sections", "warnings"):
        assert getattr(first, name) == getattr(second, name), name
    for name in ("values", "defaults", "sections"):
        pairs = zip(getattr(first, name).items(), getattr(second, name).items(), strict=True)
        assert all(repr(ours) == repr(theirs) for ours, theirs in pairs), name  # order and types
    assert fingerprint(first) == fingerprint(second)
    assert first.to_yaml() == second.to_yaml()
    assert first.stated_defaults() == second.stated_defaults()


NUMBERS = st.floats(-2.0, 2.0)
OVERRIDES = st.fixed_dictionaries(
    {},
    optional={
        "plant.initial_rotation_vector": st.lists(NUMBERS, min_size=3, max_size=3),
        "plant.initial_momentum": st.lists(NUMBERS, min_size=3, max_size=3),
        "plant.inertia": st.tuples(*[st.floats(0.5, 1.2)] * 3).map(
            lambda d: np.diag(d).ravel().tolist()
        ),
        "plant.duration": st.sampled_from([-1.0, 0.0, 4.0, 150.0, 150]),
        "plant.time_step": st.sampled_from([0.1, 0.4, 0.3, 1e9]),
        "nmpc_controller.horizon": st.integers(-1, 12),
        "nmpc_controller.method": st.sampled_from(["shooting", "slsqp", "feedback", "shoting"]),
        "nmpc_controller.max_torque": st.sampled_from([0.0, 0.01, -1.0, 1, "much"]),
        "nmpc_controller.weights.stage_torque": st.sampled_from([1.0, 2, [1.0] * 9, [1.0]]),
        "nmpc_controller.tipo": st.just(1.0),
        "plnt.duration": st.just(1.0),
        "reference_governor.governor": st.sampled_from(["none", "attitude", "turning_reference"]),
    },
)


@settings(deadline=None, max_examples=60)
@given(overrides=OVERRIDES)
def test_it_equals_the_file_under_any_overrides(overrides: dict[str, Any]) -> None:
    assert_same(made(Template(CASE_1), overrides), loaded(CASE_1, overrides))


@settings(deadline=None, max_examples=30)
@given(many=st.lists(OVERRIDES, min_size=2, max_size=5))
def test_no_scenario_leaves_anything_to_the_next(many: list[dict[str, Any]]) -> None:
    template = Template(CASE_1)
    for overrides in many:
        assert_same(made(template, overrides), loaded(CASE_1, overrides))


@pytest.mark.parametrize("path", OF_ONE, ids=lambda path: path.stem)
def test_it_equals_every_file_of_the_package(path: Path) -> None:
    template = Template(path)
    assert_same(made(template), loaded(path))
    assert_same(made(template, {"plant.duration": -1.0}), loaded(path, {"plant.duration": -1.0}))
    assert_same(made(template), loaded(path))


def test_overrides_of_its_own_stand_in_every_scenario() -> None:
    template = Template(CASE_1, BASE)
    assert_same(made(template), loaded(CASE_1, BASE))
    further = ["nmpc_controller.horizon=8", "plant.duration=40"]
    assert_same(made(template, further), loaded(CASE_1, [*BASE, *further]))
    assert_same(made(template), loaded(CASE_1, BASE))


def test_problems_of_both_kinds_of_overrides_are_told_at_once() -> None:
    template, bad = Template(CASE_1, ["plant.duratio=1"]), {"nmpc_controller.horizon": 0}
    refused = made(template, bad)
    assert isinstance(refused, InvalidScenario)
    assert {p.key for p in refused.problems} == {"plant.duratio", "nmpc_controller.horizon"}
    assert_same(made(template), loaded(CASE_1, ["plant.duratio=1"]))


def test_a_text_stands_for_the_file(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    text = CASE_1.read_text(encoding="utf-8")
    from_text = Template(path, text=text)
    path.write_text(text, encoding="utf-8")
    assert_same(made(from_text), loaded(path))
    assert_same(made(Template("gupta2015_case1")), loaded(CASE_1))


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario, match="no such file"):
        Template(tmp_path / "absent.yaml")
    with pytest.raises(InvalidScenario, match="mapping"):
        Template("some.yaml", text="- 1\n")


def test_of_several_spacecraft_it_takes_the_one_that_is_named() -> None:
    with pytest.raises(InvalidScenario, match="--namespace"):
        Template(SEVERAL)
    overrides = {"/sc2/plant.initial_rotation_vector": [0.1, 0.0, 0.0]}
    ours = Template(SEVERAL, namespace="sc2").scenario(overrides)
    assert_same(ours, load(SEVERAL, overrides, "sc2"))


def test_a_flight_of_it_is_that_of_the_file() -> None:
    overrides = {"plant.duration": 4.0, "plant.initial_rotation_vector": [0.1, -0.2, 0.3]}
    ours = Template(CASE_1).scenario(overrides).build().run()
    theirs = load(CASE_1, overrides).build().run()
    assert np.array_equal(ours.torque, theirs.torque)
    assert np.array_equal(ours.final_attitude, theirs.final_attitude)
