"""Whatever is written, the answer is a scenario or a list of problems, never another exception."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from spacecraft_gnc.scenario import InvalidScenario, from_sections, load
from spacecraft_gnc.scenario.schema import ROLES, schema_of
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE

CASE_1 = Path(__file__).resolve().parents[2] / "config" / "gupta2015_case1.yaml"
KEYS = [
    f"{section}.{declaration.name}"
    for section in ROLES
    for declaration in schema_of(VEHICLE).declarations(section, {"zones": ["star"]})
]
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5),
    st.sampled_from(["star", "plant", 0.0, 1e308, 5e-324, -1.0, 9]),
)
VALUES = st.one_of(
    SCALARS,
    st.lists(SCALARS, max_size=10),
    st.lists(st.floats(), min_size=9, max_size=9),
    st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3),
    st.dictionaries(st.text(max_size=3), SCALARS, max_size=2),
)
SETTINGS = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


def require_clear(error: InvalidScenario) -> None:
    """Every problem fills one line and says what, what instead, and what to do."""
    assert error.problems
    for problem in error.problems:
        assert len(str(problem).splitlines()) == 1
        assert all((problem.value, problem.requirement, problem.remedy))


@given(st.dictionaries(st.sampled_from(KEYS), VALUES, max_size=6))
@example({"plant.inertia": [1e308] * 9})
@example({"plant.initial_momentum": [1e308, 0.0, 0.0]})
@example({"plant.time_step": 5e-324})
@example({"nmpc_controller.time_step": 5e-324})
@example({"plant.initial_rotation_vector": [1e308, 1e308, 0.0]})
def test_any_value(changes: dict[str, Any]) -> None:
    try:
        scenario = load(CASE_1, changes)
    except InvalidScenario as error:
        require_clear(error)
    else:
        assert scenario.n_steps >= 1
        assert from_sections(scenario.values).values == scenario.values


@SETTINGS
@given(st.text(max_size=200))
@example("plant: {ros__parameters: {inertia: {a: {b: [}}}}")
@example("? [a]\n: b\n")
@example("plant:\n  ros__parameters: [1, 2]\n")
@example("plant:\n  ros__parameters:\n    '': 1\n    ? {a: b}\n    : 2\n")
@example("plant: &a\n  ros__parameters: *a\n")
@example("/:\n  ros__parameters: {x: 1}\n//plant: {ros__parameters: {y: 2}}\n")
@example("**: {ros__parameters: {x..y: 1, .: 2, zones.a.b.c: 3}}")
def test_any_text(tmp_path: Path, text: str) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(InvalidScenario) as error:
        load(path)
    require_clear(error.value)


@given(st.text(max_size=40))
@example("plant.duration={a: {b: 1}}")
@example("plant.inertia={}")
@example("nmpc_controller.weights=1")
@example("nmpc_controller.zones={a: 1}")
def test_any_setting(text: str) -> None:
    try:
        load(CASE_1, [text])
    except InvalidScenario as error:
        require_clear(error)
