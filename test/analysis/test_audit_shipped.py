"""Every shipped scenario, flown to its end by the cores, passes its audit."""

from __future__ import annotations

from pathlib import Path

import docking_bags
import flown_bags
import formation_bags
import pytest
import wheel_bags

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.scenario import load_fleet
from spacecraft_gnc.scenario.fingerprint import differences

pytestmark = pytest.mark.long

FLY = {
    "docking": docking_bags.fly,
    "formation": formation_bags.fly,
    "rigid_body": flown_bags.fly,
    "two_wheel": lambda folder, flown: wheel_bags.fly(folder, flown)[0],
}
"""What records a flight without ROS, by vehicle."""
SHIPPED = sorted(Path(__file__).parents[2].joinpath("config").glob("*.yaml"))


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_a_shipped_flight_passes(tmp_path, file):
    for agent, scenario in load_fleet(file).agents.items():
        audit = audit_bag(FLY[scenario.vehicle.name](tmp_path / agent, scenario.sections))
        assert audit.passed, audit.first
        assert audit.steps == scenario.n_steps
        assert differences(audit.scenario, scenario) == ()
        assert audit.counts.solves_repeated == 0
        assert audit.counts.standstills_found == audit.counts.standstills_reported
