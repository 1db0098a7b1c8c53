"""One flight, one fingerprint, however its scenario is written; and the values that differ."""

from __future__ import annotations

from pathlib import Path

import pytest

from spacecraft_gnc.scenario import from_sections, load, load_fleet
from spacecraft_gnc.scenario.fingerprint import differences, fingerprint

CASE1 = load("gupta2015_case1")
SHIPPED = sorted(Path(__file__).parents[2].joinpath("config").glob("*.yaml"))
BODY = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_written_out_and_read_again_it_stays(file, tmp_path):
    fleet = load_fleet(file)
    for defaults in (False, True):
        again = tmp_path / f"{defaults}.yaml"
        again.write_text(fleet.to_yaml(defaults=defaults), encoding="utf-8")
        read = load_fleet(again).agents
        assert list(read) == list(fleet.agents)
        for agent, scenario in fleet.agents.items():
            assert differences(scenario, read[agent]) == ()
            assert fingerprint(read[agent]) == fingerprint(scenario)


@pytest.mark.parametrize(
    "words",
    [
        ["nmpc_controller.weights.stage_torque=[1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0]"],
        [f"nmpc_controller.inertia={BODY}"],
        ["launcher.composed=true", "plant.peers=[nmpc_controller]", "plant.autostart=false"],
        ["recorder.compression=none", "recorder.storage_folder=elsewhere"],
    ],
    ids=["a weight as a matrix", "inertia repeated", "started otherwise", "recorded otherwise"],
)
def test_what_changes_no_flight_changes_nothing(words):
    assert fingerprint(load("gupta2015_case1", words)) == fingerprint(CASE1)


def test_one_bit_of_one_value_changes_it_and_is_named():
    other = load(
        "gupta2015_case1", ["plant.initial_rotation_vector=[0.25, 0.5, 0.5000000000000001]"]
    )
    assert fingerprint(other) != fingerprint(CASE1)
    (found,) = differences(CASE1, other)
    assert found == (
        "plant.initial_rotation_vector", "[0.25, 0.5, 0.5]", "[0.25, 0.5, 0.5000000000000001]"
    )  # fmt: skip


def test_a_parameter_that_one_of_them_lacks_is_named():
    star = {
        "kind": "exclusion", "body_axis": [1.0, 0.0, 0.0], "inertial_axis": [0.0, 0.0, 1.0],
        "half_angle_deg": 5.0,
    }  # fmt: skip
    plant = {"inertia": BODY}
    plain = from_sections({"plant": plant, "nmpc_controller": {"max_torque": 0.01}})
    zoned = {"max_torque": 0.01, "zone_names": ["star"], "zones": {"star": star}}
    found = differences(plain, from_sections({"plant": plant, "nmpc_controller": zoned}))
    told = {str(difference) for difference in found}
    assert "nmpc_controller.zones.star.half_angle_deg: - / 5.0" in told
    assert "nmpc_controller.zone_names: [] / [star]" in told


def test_a_parameter_that_came_later_leaves_the_fingerprint_of_recorded_flights():
    """Its default says nothing new; another value does."""
    assert fingerprint(CASE1) == "c727be382435"  # of bags recorded before there were disturbances
    disturbed = ["plant.disturbances=[constant]", "plant.constant_torque=[1.0e-5, 0.0, 0.0]"]
    other = load("gupta2015_case1", disturbed)
    assert fingerprint(other) != fingerprint(CASE1)
    names = [difference.name for difference in differences(CASE1, other)]
    assert names == ["plant.constant_torque", "plant.disturbances"]
