"""Short flights that compile every kernel of a spacecraft with wheels."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from spacecraft_gnc.vehicles.two_wheel.build import plant
from spacecraft_gnc.vehicles.two_wheel.controllers.methods import METHODS
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated import UnderactuatedParameters
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario

_SPHEROID: Final = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]  # [kg m^2]


def flights() -> Iterator[dict[str, Any]]:
    """Yield scenarios, by section: every method."""
    for method in METHODS:
        wheels = 2 if method.parameters is UnderactuatedParameters else 3
        yield {
            "plant": {
                "vehicle": "two_wheel",
                "inertia": _SPHEROID,
                "wheel_axes": np.eye(3)[:, :wheels].ravel().tolist(),
                "wheel_inertias": [0.01] * wheels,
                "time_step": 0.4,
                "duration": 1.0,
            },
            "nmpc_controller": {"method": method.name},
        }


def compile_further(scenario: Scenario) -> None:
    """Compile what no flight needs: histories in one call."""
    flown = plant(scenario)
    flown.gyrostat.simulate(flown.state, np.zeros((2, flown.gyrostat.n_wheels)))


WARMUP: Final = (flights, compile_further)
