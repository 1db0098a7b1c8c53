"""Parameters that the method does not read are refused, unless they say nothing new."""

from __future__ import annotations

from typing import Any

import pytest

from spacecraft_gnc.scenario import InvalidScenario, from_sections
from spacecraft_gnc.scenario.checks_reads import readers
from spacecraft_gnc.scenario.schema import schema_of
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.rigid_body import descriptor

INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
METHODS = tuple(method.name for method in descriptor.VEHICLE.methods)
READERS = readers(descriptor.VEHICLE.methods)
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
    "weights.stage_momentum": 0.02,
    "weights.terminal_attitude": 0.02,
    "weights.terminal_momentum": 0.02,
    "torque_penalty": 1.0e9,
    "actuators": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
    "standstill_error_deg": 1.0,
    "weights.stage_attitude": 0.02,
    "weights.stage_torque": 2.0,
    "horizon": 6,
    "residual_tolerance": 1.0e-11,
    "max_iterations": 60,
    "feedback_attitude_gain": INERTIA,
    "feedback_momentum_gain": INERTIA,
    "plan.duration": 2.0,
    "plan.torque_bounds": [1.0],
    "plan.momentum_bounds": [1.0],
    "plan.torque_reserve": 0.1,
    "plan.momentum_reserve": 0.1,
    "plan.starts": 4,
    "plan.replan_error_deg": 1.0,
    "plan.replan_lead": 6,
    "plan.file": "plan.npz",
}


@pytest.fixture(autouse=True)
def _methods(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the name of another package's method be known: nothing is built here."""
    names = registry.names
    known = lambda group, vehicle=None: (*names(group, vehicle), "foreign")  # noqa: E731
    monkeypatch.setattr(registry, "names", known)


def problems(**controller: Any) -> list[str]:
    try:
        from_sections({"plant": {"inertia": INERTIA}, "nmpc_controller": controller})
    except InvalidScenario as error:
        return [str(problem) for problem in error.problems]
    return []


def test_every_parameter_of_the_table_exists() -> None:
    declared = schema_of(descriptor.VEHICLE).declarations("nmpc_controller")
    assert READERS.keys() <= {declaration.name for declaration in declared}
    assert READERS.keys() == CHANGED.keys()


@pytest.mark.parametrize("name", CHANGED)
@pytest.mark.parametrize("method", [*METHODS, "foreign"])
def test_who_reads_what(method: str, name: str) -> None:
    given = {name: CHANGED[name]}
    if method == "neighboring_extremal":
        given |= NOMINAL
    found = problems(method=method, **given)
    if method == "foreign" or method in READERS[name]:
        assert found == []
    else:
        (line,) = found
        known = " or ".join(READERS[name])
        assert f"nmpc_controller.{name}: received" in line
        assert f"required a method that reads it ({known}), not {method}; remove it" in line


@pytest.mark.parametrize("method", METHODS)
def test_a_default_that_is_stated_is_no_fault(method: str) -> None:
    """The launcher states all of them in the file that it hands to the nodes."""
    sections = {"plant": {"inertia": INERTIA}, "nmpc_controller": {"method": method}}
    stated = from_sections(sections).values["nmpc_controller"]
    assert problems(**stated) == []


@pytest.mark.parametrize("name", ["nominal_momentum", "exact_every"])
def test_a_nominal_run_needs_its_start(name: str) -> None:
    (line,) = problems(method="neighboring_extremal", **{name: CHANGED[name]})
    assert "required nominal_rotation_vector beside it" in line
    assert line.endswith("give nominal_rotation_vector, or remove it")
    assert problems(method="neighboring_extremal", **NOMINAL, **{name: CHANGED[name]}) == []


def test_variants_are_those_of_the_method() -> None:
    assert problems(variant="estimated_u") == []
    (line,) = problems(variant="estimated_v")
    assert "required one of exact, estimated_du, estimated_u; did you mean 'estimated_" in line
    (line,) = problems(method="slsqp", variant="estimated_u")
    assert line.endswith("required no variant: slsqp has none; remove it")
