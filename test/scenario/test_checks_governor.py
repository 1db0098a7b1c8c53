"""Parameters that the governor does not read are refused, unless they say nothing new."""

from __future__ import annotations

from typing import Any

import pytest

from spacecraft_gnc.scenario import InvalidScenario, from_sections
from spacecraft_gnc.scenario.checks_reads import readers
from spacecraft_gnc.scenario.schema import schema_of
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE

INERTIA = [10.0, 0.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0, 8.0]
CHANGED: dict[str, Any] = {
    "initial_reference_rotation_vector": [0.1, 0.0, 0.0],
    "max_torque": 0.02,
    "max_momentum": 1.0,
    "steady_margin_deg": 0.2,
    "lyapunov_level": 0.1,
    "prediction_horizon": 60,
    "alpha_tolerance": 1e-4,
    "cut_point_shift": 0.02,
    "route": False,
    "route_clearance_deg": 3.0,
}
MOVING: dict[str, tuple[str, Any]] = {
    "reference_rate": ("turning_reference", [0.0, 0.0, 0.1]),
    "trajectory.times": ("stored_trajectory", [0.0, 1.0]),
    "trajectory.rotation_vectors": ("stored_trajectory", [0.1] * 6),
    "trajectory.angular_velocities": ("stored_trajectory", [0.0, 0.0, 0.1]),
    **{
        f"plan.{name}": ("planned", value)
        for name, value in (
            ("duration", 2.0),
            ("torque_bounds", [1.0]),
            ("momentum_bounds", [1.0]),
            ("torque_reserve", 0.1),
            ("momentum_reserve", 0.1),
            ("starts", 4),
            ("replan_error_deg", 1.0),
            ("replan_lead", 6),
            ("file", "plan.npz"),
        )
    },
}


def problems(method: str, **governor: Any) -> list[str]:
    sections = {
        "plant": {"inertia": INERTIA, "initial_rotation_vector": [0.1, 0.0, 0.0]},
        "nmpc_controller": {"method": method},
        "reference_governor": governor,
    }
    try:
        from_sections(sections)
    except InvalidScenario as error:
        return [str(problem) for problem in error.problems]
    return []


def test_every_parameter_of_the_table_exists() -> None:
    declared = {d.name for d in schema_of(VEHICLE).declarations("reference_governor")}
    assert readers(VEHICLE.governors).keys() <= declared
    assert readers(VEHICLE.governors).keys() == CHANGED.keys() | MOVING.keys()


@pytest.mark.parametrize("name", CHANGED)
def test_only_the_governor_attitude_reads_them(name: str) -> None:
    given = {name: CHANGED[name]}
    assert problems("feedback", governor="attitude", **given) == []
    (line,) = problems("feedback", governor="none", **given)
    assert f"reference_governor.{name}: received" in line
    assert "required a governor that reads it (attitude), not none; remove it" in line


@pytest.mark.parametrize("name", MOVING)
def test_only_a_law_that_moves_the_reference_reads_these(name: str) -> None:
    law, value = MOVING[name]
    for other in ("none", "attitude"):
        (line,) = problems("feedback", governor=other, **{name: value})
        assert f"required a governor that reads it ({law}), not {other}; remove it" in line


def test_a_default_that_is_stated_is_no_fault() -> None:
    declarations = schema_of(VEHICLE).declarations("reference_governor")
    stated = {d.name: d.spec.default for d in declarations}
    assert problems("shooting", **stated) == []


def test_a_level_needs_the_law_that_has_one() -> None:
    (line,) = problems("shooting", governor="attitude", lyapunov_level=0.1)
    assert "required nmpc_controller.method: feedback beside it, not shooting" in line
