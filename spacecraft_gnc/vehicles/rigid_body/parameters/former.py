"""Former defaults, which did not follow from the spacecraft, for flights recorded with them.

They were those of Gupta et al. (2015), Case I, whatever the spacecraft. A recording that does not
state the defaults that it took is one of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from spacecraft_gnc.parameters.parameter import Value

_PLANT: Final[Mapping[str, Value]] = {"time_step": 0.4, "duration": 150.0}
_CONTROLLER: Final[Mapping[str, Value]] = {
    "horizon": 5,
    "max_torque": 0.01,
    "torque_penalty": 1.0e10,
    "weights.stage_attitude": 0.01,
    "weights.stage_momentum": 0.01,
    "weights.stage_torque": 1.0,
    "weights.terminal_attitude": 0.01,
    "weights.terminal_momentum": 0.01,
}
_ZONE_PENALTY: Final = 1000.0
_BANDWIDTH: Final = 0.05  # of the feedback law, in units of 1 / period


def former_defaults(
    sections: Mapping[str, Mapping[str, Value]],
) -> Mapping[str, Mapping[str, Value]]:
    """Return the defaults that a scenario took.

    Parameters
    ----------
    sections : mapping
        Node name -> dotted name -> the value given, as of `read_sections`.
    """
    plant, controller = sections.get("plant", {}), sections.get("nmpc_controller", {})
    zones = controller.get("zone_names", [])
    penalties: dict[str, Value] = {
        f"zones.{name}.penalty": _ZONE_PENALTY
        for name in (zones if isinstance(zones, list) else ())
    }
    return {
        "plant": _PLANT,
        "nmpc_controller": {**_CONTROLLER, **penalties, **_gains(plant, controller)},
        "reference_governor": {"slew_rate_tolerance": 1.0e-3},
    }


def _gains(plant: Mapping[str, Value], controller: Mapping[str, Value]) -> dict[str, Value]:
    """Return A = J omega^2 / 2 and K = 2 omega I; none where no inertia is told."""
    inertia = controller.get("inertia") or plant.get("inertia")
    period = controller.get("time_step") or plant.get("time_step", _PLANT["time_step"])
    if not (isinstance(inertia, list) and isinstance(period, float) and period > 0.0):
        return {}
    omega = _BANDWIDTH / period
    attitude = 0.5 * omega**2 * np.array(inertia, dtype=np.float64)
    return {
        "feedback_attitude_gain": attitude.tolist(),
        "feedback_momentum_gain": (2.0 * omega * np.eye(3)).ravel().tolist(),
    }
