"""Zones against start, target and each other, in whole scenarios."""

from __future__ import annotations

from typing import Any

import pytest

from spacecraft_gnc.scenario import InvalidScenario, Scenario, from_sections

INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
X, Y, Z = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]
CASE_2 = {"body_axis": X, "inertial_axis": [0.9276, 0.3736, 0.0], "half_angle_deg": 4.9965}
"""The exclusion zone of Case II of Gupta et al. (2015), as printed."""


def zone(kind: str, body_axis: list[float], inertial_axis: list[float], half: float) -> dict:
    return {
        "kind": kind,
        "body_axis": body_axis,
        "inertial_axis": inertial_axis,
        "half_angle_deg": half,
    }


def scenario(
    zones: dict[str, Any], sections: dict[str, Any] | None = None, **plant: Any
) -> Scenario:
    others = sections or {}
    own = {"zone_names": list(zones), "zones": zones, **others.get("nmpc_controller", {})}
    plant = {"inertia": INERTIA, **plant}
    return from_sections({**others, "plant": plant, "nmpc_controller": own})


def refused(
    zones: dict[str, Any], sections: dict[str, Any] | None = None, **plant: Any
) -> list[str]:
    with pytest.raises(InvalidScenario) as error:
        scenario(zones, sections, **plant)
    return [problem.key.rpartition("zones.")[2] for problem in error.value.problems]


def test_case_2_as_printed_can_fly() -> None:
    assert scenario({"star": CASE_2}, initial_rotation_vector=[0.0, 0.0, 0.5]).n_steps > 0


INSIDE = {"initial_rotation_vector": [0.0, 0.0, 0.4]}
AT_THE_START = (
    "[0.0, 0.0, 0.4], the start at which the body axis is 0.980717 deg from the axis of the cone"
)
KEPT = "at least 4.9965 deg (exclusion zone 'star')"
HARD = {
    "governor": {"reference_governor": {"governor": "attitude"}},
    "governor, feedback": {
        "reference_governor": {"governor": "attitude"},
        "nmpc_controller": {"method": "feedback"},
    },
    "terminal set": {"nmpc_controller": {"method": "terminal_set"}},
    "nobody keeps it": {"nmpc_controller": {"method": "feedback"}},
}


@pytest.mark.parametrize("sections", HARD.values(), ids=HARD)
def test_a_start_inside_a_hard_zone_is_refused(sections: dict[str, Any]) -> None:
    with pytest.raises(InvalidScenario, match="initial_rotation_vector") as error:
        scenario({"star": CASE_2}, sections, **INSIDE)
    problem = error.value.problems[0]
    assert problem.value == AT_THE_START
    assert problem.requirement == KEPT
    assert problem.remedy == "choose another start, or shrink the cone"


@pytest.mark.parametrize("method", ["shooting", "neighboring_extremal", "slsqp", "fsolve"])
def test_a_start_inside_a_soft_zone_is_told(method: str) -> None:
    sections = {"nmpc_controller": {"method": method}}
    (warning,) = scenario({"star": CASE_2}, sections, **INSIDE).warnings
    assert warning == (
        f"parameters: plant.initial_rotation_vector: {AT_THE_START}; required {KEPT}; the zone is "
        "soft: the flight begins inside and leaves it"
    )


def test_a_start_left_at_its_default_is_told_at_the_zone() -> None:
    keys = refused({"a": zone("inclusion", X, Y, 30.0)}, initial_rotation_vector=[0.0, 0.0, 1.5])
    assert keys == ["a.half_angle_deg"]  # the target, at its default
    hard = {"nmpc_controller": {"method": "terminal_set"}}
    keys = refused({"a": zone("exclusion", X, X, 30.0)}, hard)
    assert keys == ["a.half_angle_deg", "a.half_angle_deg"]


def test_a_controller_by_itself_knows_of_no_start() -> None:
    section = {"inertia": INERTIA, "zone_names": ["a"], "zones": {"a": zone("exclusion", X, X, 9)}}
    assert from_sections({"nmpc_controller": section}).controller.zones[0].name == "a"
    with pytest.raises(InvalidScenario, match="the target at which"):
        from_sections({"nmpc_controller": section, "reference_governor": {}})


def test_start_and_target_may_touch_the_cone() -> None:
    assert scenario({"a": zone("inclusion", X, Y, 90.0)}).controller.zones
    assert scenario({"a": zone("exclusion", X, Y, 90.0)}).controller.zones


PAIRS: dict[str, tuple[dict, dict, list[str]]] = {
    "inclusion in exclusion": (
        zone("exclusion", X, Z, 30.0), zone("inclusion", X, [0.0, 0.1, 1.0], 5.0),
        ["b.half_angle_deg"],
    ),
    "disjoint inclusions": (
        zone("inclusion", X, [1.0, 1.0, 0.0], 10.0), zone("inclusion", X, Z, 10.0),
        ["b.half_angle_deg"],
    ),
    "exclusions that share no rest": (
        zone("exclusion", X, Z, 90.0), zone("exclusion", X, [0.0, 0.0, -1.0], 90.0),
        ["b.half_angle_deg"],
    ),
    "exclusion in exclusion": (
        zone("exclusion", X, Z, 30.0), zone("exclusion", X, [0.0, 0.1, 1.0], 5.0),
        ["b.half_angle_deg"],
    ),
    "exclusion around exclusion": (
        zone("exclusion", X, [0.0, 0.1, 1.0], 5.0), zone("exclusion", X, Z, 30.0),
        ["a.half_angle_deg"],
    ),
    "inclusion around inclusion": (
        zone("inclusion", X, X, 30.0), zone("inclusion", X, [1.0, 0.1, 0.0], 60.0),
        ["b.half_angle_deg"],
    ),
    "the same zone twice": (
        zone("exclusion", X, Z, 30.0), zone("exclusion", [2.0, 0.0, 0.0], Z, 30.0),
        ["b.half_angle_deg"],
    ),
    "two axes held too near": (
        zone("inclusion", X, X, 10.0), zone("inclusion", Y, [1.0, 1.0, 0.0], 10.0),
        ["b.half_angle_deg"],
    ),
    "two axes held too near by exclusions": (
        zone("exclusion", X, [-1.0, 0.0, 0.0], 170.0),
        zone("exclusion", Y, [-1.0, -1.0, 0.0], 170.0),
        ["b.half_angle_deg"],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("a", "b", "keys"), PAIRS.values(), ids=PAIRS.keys())
def test_pairs_at_odds(a: dict, b: dict, keys: list[str]) -> None:
    assert refused({"a": a, "b": b}) == keys


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (zone("exclusion", X, Z, 30.0), zone("exclusion", X, [0.0, 1.0, 1.0], 30.0)),  # overlap
        (zone("exclusion", X, Z, 30.0), zone("exclusion", Y, Z, 5.0)),  # of another axis
        (zone("inclusion", X, X, 30.0), zone("inclusion", X, [1.0, 0.1, 0.0], 30.0)),
        (zone("inclusion", X, X, 30.0), zone("exclusion", X, [1.0, 0.3, 0.0], 5.0)),
        (zone("inclusion", X, X, 30.0), zone("exclusion", X, Z, 5.0)),  # superfluous, but no fault
        (zone("inclusion", X, X, 10.0), zone("inclusion", Y, Y, 10.0)),
    ],
)
def test_pairs_that_fly(a: dict, b: dict) -> None:
    assert len(scenario({"a": a, "b": b}).controller.zones) == 2


def test_a_refused_zone_is_not_compared() -> None:
    bad = {**zone("exclusion", X, Z, 200.0), "body_axis": [0.0, 0.0, 0.0]}
    keys = refused({"a": bad, "b": zone("exclusion", X, Z, 5.0)})
    assert keys == ["a.body_axis", "a.half_angle_deg"]
