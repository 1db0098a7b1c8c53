"""What `gnc check` says of disturbances, with the line of the file where one was given."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc.parameters.checked import check_values
from spacecraft_gnc.parameters.declare import Schema
from spacecraft_gnc.parameters.parameter import specs_of
from spacecraft_gnc.parameters.yaml_file import Entry
from spacecraft_gnc.plant.disturbances.checks import check_disturbances
from spacecraft_gnc.plant.disturbances.parameters import DisturbanceParameters

SCHEMA = Schema({"plant": DisturbanceParameters})
INERTIA = np.diag([1.0, 0.8, 0.6])


def problems(**values):
    """Problems of a section of the plant, whose value i stands on line i + 1."""
    lines = enumerate(values.items(), 1)
    given = {"plant": {name: Entry(v, "f.yaml", line, coerce=True) for line, (name, v) in lines}}
    checked = check_values(SCHEMA, given, "f.yaml", [])
    check_disturbances(checked, INERTIA)
    return [str(problem) for problem in checked.problems]


GOOD = {
    "disturbances": ["constant", "gravity_gradient", "noise"],
    "constant_torque": [1e-4, 0, 0],
    "orbit_rate": 1.1e-3,
    "noise_torque": [1e-5, 1e-5, 1e-5],
}


def test_values_that_fit_are_not_complained_of():
    assert problems() == []
    assert problems(**GOOD) == []
    assert problems(constant_torque=[1.0, 0.0, 0.0]) == []  # not listed: not read


def test_every_part_that_cannot_be_built_is_told_with_its_line():
    found = problems(
        disturbances=["gravity_gradient", "constant", "nois"], orbit_position=[0, 0, 1]
    )
    rate, torque, name = found
    assert rate == (
        "f.yaml: plant.orbit_rate: received 0.0 rad/s; required a positive rate for the "
        "disturbance 'gravity_gradient'; add it, such as 1.1e-3 for a low orbit of the Earth"
    )
    assert torque == (
        "f.yaml: plant.constant_torque: received nothing; required 3 numbers [N m] for the "
        "disturbance 'constant'; add it, such as [1.0e-4, 0.0, 0.0]"
    )
    assert name == (
        "f.yaml:1: plant.disturbances: received 'nois'; required one of constant, "
        "gravity_gradient, noise, push; did you mean 'noise'?"
    )
    (found,) = problems(**GOOD, orbit_position=[0, 0, 1])
    assert found.startswith("f.yaml:5: plant.orbit_position: received [0, 0, 1], at 0 deg to")


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("disturbances", ["constant", "constant"]),
        ("disturbances", "constant"),
        ("constant_torque", [1.0, 2.0]),
        ("constant_torque", [1.0, float("nan"), 0.0]),
        ("orbit_rate", -1e-3),
        ("orbit_rate", float("inf")),
        ("orbit_normal", [0.0, 0.0, 0.0]),
        ("noise_torque", [1.0, -1.0, 0.0]),
        ("seed", -1),
        ("seed", 1.5),
    ],
)
def test_a_value_that_is_none_is_told_once(name, value):
    (found,) = problems(**GOOD | {name: value})
    assert f"plant.{name}" in found
    assert "required" in found


def test_every_parameter_is_described():
    for _, spec in specs_of(DisturbanceParameters):
        assert len(spec.description) > 10
        assert spec.requirement
