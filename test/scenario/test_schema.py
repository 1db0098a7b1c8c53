"""The schema: complete, consistent with itself, and declarable by a ROS 2 node."""

from __future__ import annotations

import pytest

from spacecraft_gnc.parameters.declare import Declaration, flatten, unflatten
from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec, typed
from spacecraft_gnc.parameters.sections import NODE_NAMES
from spacecraft_gnc.parameters.values import admissible
from spacecraft_gnc.scenario.schema import ROLES, schema_of
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE

SCHEMA = schema_of(VEHICLE)
ALL = [
    pytest.param(declaration, id=f"{section}.{declaration.name}")
    for section in ROLES
    for declaration in SCHEMA.declarations(section, {"zones": ["star"]})
]
PYTHON_TYPES = {
    Kind.BOOL: bool,
    Kind.INTEGER: int,
    Kind.DOUBLE: float,
    Kind.STRING: str,
    Kind.DOUBLE_ARRAY: list,
    Kind.STRING_ARRAY: list,
    Kind.DYNAMIC: float,
}


@pytest.mark.parametrize("declaration", ALL)
def test_every_parameter_is_described(declaration: Declaration) -> None:
    spec = declaration.spec
    assert len(spec.description) > 10
    assert not spec.description.endswith(".")
    assert type(spec.default) is PYTHON_TYPES[spec.kind]
    assert spec.requirement


@pytest.mark.parametrize("declaration", ALL)
def test_every_default_is_admissible(declaration: Declaration) -> None:
    spec = declaration.spec
    if not spec.required:
        assert admissible(spec, spec.default, coerce=False) == spec.default
    typed(spec, spec.default)


def test_sections_and_nodes() -> None:
    assert tuple(SCHEMA.sections) == ROLES == (*NODE_NAMES, "launcher")
    for node in NODE_NAMES:
        assert "autostart" in {declaration.name for declaration in SCHEMA.declarations(node)}
    assert "autostart" not in {declaration.name for declaration in SCHEMA.declarations("launcher")}


def test_names_are_those_of_ros() -> None:
    plugin = {"gain": 2.0, "names": ["a"], "counts": [1, 2], "flag": True}
    zones = {"zones": ["star", "sun"]}
    found = {d.name: d.spec for d in SCHEMA.declarations("nmpc_controller", zones, plugin)}
    assert found["weights.stage_attitude"].kind is Kind.DYNAMIC
    assert found["zones.sun.half_angle_deg"].unit == "deg"
    assert found["plugin.gain"].kind is Kind.DOUBLE
    assert found["plugin.names"].kind is Kind.STRING_ARRAY
    assert found["plugin.counts"].kind is Kind.INTEGER_ARRAY
    assert found["plugin.flag"].kind is Kind.BOOL
    assert all(spec.read_only for spec in found.values())


def test_flatten_and_back() -> None:
    nested = {"a": 1, "b": {"c": [1.0], "d": {"e": "x"}}}
    assert flatten(nested) == {"a": 1, "b.c": [1.0], "b.d.e": "x"}
    assert unflatten(flatten(nested)) == nested


@pytest.mark.parametrize(
    ("bounds", "text"),
    [
        ({}, ""),
        ({"minimum": 0.0}, ">= 0"),
        ({"above": 0.0}, "> 0"),
        ({"above": 0.0, "below": 180.0}, "> 0 and < 180"),
        ({"minimum": -1, "maximum": 232}, "-1 to 232"),
        ({"maximum": 1 << 30}, "<= 1073741824"),
    ],
)
def test_range_in_words(bounds: dict[str, float], text: str) -> None:
    spec = ParameterSpec(kind=Kind.DOUBLE, default=1.0, description="a number", **bounds)
    assert spec.range_text == text
