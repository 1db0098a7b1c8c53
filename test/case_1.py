"""Parameters of Case I of Gupta et al. 2015, for tests whose reference values use them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from spacecraft_gnc.scenario.checks_reads import unread_by
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE as RIGID_BODY

INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
PLANT = {"inertia": INERTIA, "time_step": 0.4, "duration": 150.0}
CONTROLLER: Mapping[str, Any] = {
    "horizon": 5,
    "weights.stage_attitude": 0.01,
    "weights.stage_momentum": 0.01,
    "weights.stage_torque": 1.0,
    "weights.terminal_attitude": 0.01,
    "weights.terminal_momentum": 0.01,
    "max_torque": 0.01,
    "torque_penalty": 1.0e10,
}


def controller(**changes: Any) -> dict[str, Any]:
    """Return the controller section without parameters ignored by the method of ``changes``."""
    unread = set(unread_by(RIGID_BODY, changes.get("method", "shooting"), CONTROLLER))
    return {name: v for name, v in CONTROLLER.items() if name not in unread} | changes
