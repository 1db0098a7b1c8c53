"""Methods of the docking vehicle: the periodic law, and the same without its periodicity."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.docking.parameters.controller import ControllerParameters
from spacecraft_gnc.vehicles.vehicle import Method

_CONTROLLER: Final = f"{__package__}.lqr"

METHODS: Final[tuple[Method, ...]] = (
    Method(
        name="periodic_lqr",
        build=Lazy(f"{_CONTROLLER}:periodic"),
        parameters=ControllerParameters,
        memoryless=True,
    ),
    Method(
        name="time_invariant_lqr",
        build=Lazy(f"{_CONTROLLER}:time_invariant"),
        parameters=ControllerParameters,
        memoryless=True,
    ),
)
