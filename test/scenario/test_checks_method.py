"""Parameters that the method does not read are refused, unless they say nothing new."""

from __future__ import annotations

from typing import Any

import pytest

from spacecraft_gnc.scenario import InvalidScenario, from_sections, registry
from spacecraft_gnc.scenario.checks_method import READERS
from spacecraft_gnc.scenario.declare import declarations
from spacecraft_gnc.scenario.registry import BuiltIn

INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
NOMINAL = {"nominal_rotation_vector": [0.0, 0.0, 0.5]}
CHANGED: dict[str, Any] = {
    "formulation": "single_shooting",
    "step_rule": "damped",
    "damping": 0.7,
    "continuation": "state",
    **NOMINAL,
    "nominal_momentum": [0.0, 0.0, 0.1],
    "exact_every": 10,
    "ne_tolerance": 0.1,
    "ne_max_age": 3,
    "terminal_set": "false",
    "stage_cost_scale": 0.2,
    "weights.stage_rate": 1.0,
    "weights.stage_momentum": 0.5,
    "weights.terminal_attitude": 0.5,
    "weights.terminal_momentum": 0.5,
    "torque_penalty": 1.0,
    "actuators": [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    "standstill_error_deg": 0.2,
}


@pytest.fixture(autouse=True)
def _methods(monkeypatch: pytest.MonkeyPatch) -> None:
    """Methods by name only: nothing is built here."""
    target = BuiltIn("nowhere:Nothing")
    methods = {
        "shooting": BuiltIn("nowhere:Nothing", ("exact", "estimated_u")),
        "neighboring_extremal": target,
        "slsqp": target,
        "terminal_set": target,
    }
    monkeypatch.setitem(registry.BUILT_IN, "controllers", methods)
    monkeypatch.setattr(registry, "names", lambda group: (*registry.BUILT_IN[group], "foreign"))


def problems(**controller: Any) -> list[str]:
    try:
        from_sections({"plant": {"inertia": INERTIA}, "nmpc_controller": controller})
    except InvalidScenario as error:
        return [str(problem) for problem in error.problems]
    return []


def test_every_parameter_of_the_table_exists() -> None:
    assert READERS.keys() <= {d.name for d in declarations("nmpc_controller")}
    assert READERS.keys() == CHANGED.keys()


@pytest.mark.parametrize("name", CHANGED)
@pytest.mark.parametrize(
    "method", ["shooting", "neighboring_extremal", "slsqp", "terminal_set", "foreign"]
)
def test_who_reads_what(method: str, name: str) -> None:
    given = {name: CHANGED[name]}
    if method == "neighboring_extremal":
        given |= NOMINAL
    found = problems(method=method, **given)
    if method == "foreign" or method in READERS[name]:
        assert found == []
    else:
        (line,) = found
        readers = " or ".join(READERS[name])
        assert f"nmpc_controller.{name}: received" in line
        assert f"required a method that reads it ({readers}), not {method}; remove it" in line


@pytest.mark.parametrize("method", ["shooting", "neighboring_extremal", "slsqp"])
def test_a_default_that_is_stated_is_no_fault(method: str) -> None:
    """The launcher states all of them in the file that it hands to the nodes."""
    stated = {d.name: d.spec.default for d in declarations("nmpc_controller")}
    assert problems(**{**stated, "method": method}) == []


@pytest.mark.parametrize("name", ["nominal_momentum", "exact_every"])
def test_a_nominal_run_needs_its_start(name: str) -> None:
    (line,) = problems(method="neighboring_extremal", **{name: CHANGED[name]})
    assert "required nominal_rotation_vector beside it" in line
    assert line.endswith("give nominal_rotation_vector, or remove it")
    assert problems(method="neighboring_extremal", **NOMINAL, **{name: CHANGED[name]}) == []


def test_variants_are_those_of_the_method() -> None:
    assert problems(variant="estimated_u") == []
    (line,) = problems(variant="estimated_v")
    assert line.endswith("required one of exact, estimated_u; did you mean 'estimated_u'?")
    (line,) = problems(method="slsqp", variant="estimated_u")
    assert line.endswith("required no variant: slsqp has none; remove it")
