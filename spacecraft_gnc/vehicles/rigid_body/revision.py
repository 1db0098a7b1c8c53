"""Revision of a scenario for another controller along a recorded flight."""

from __future__ import annotations

from typing import Any

from spacecraft_gnc.vehicles.rigid_body.governors.laws import NONE
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def without_start_and_target(scenario: Scenario, sections: dict[str, dict[str, Any]]) -> None:
    """Take out of given values, by section and dotted name, what only a flight has to meet.

    A governor that moved the reference has done its work, and the new controller need not reach the
    target from the start by itself.
    """
    if scenario.governor.governor == NONE.name:
        return
    target = scenario.governor.target_rotation_vector
    sections["reference_governor"] = {"target_rotation_vector": target}
    plant = sections.setdefault("plant", {})
    plant |= {"initial_rotation_vector": target, "initial_momentum": None}
