"""Methods of a spacecraft with wheels, and the section of the scenario file that they read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.vehicles.two_wheel.controllers import (
    fault_tolerant,
    feedback,
    shooting,
    underactuated,
)
from spacecraft_gnc.vehicles.two_wheel.controllers.fault_tolerant import FaultTolerantParameters
from spacecraft_gnc.vehicles.two_wheel.parameters.common import CommonParameters
from spacecraft_gnc.vehicles.vehicle import Method

METHODS: Final[tuple[Method, ...]] = (
    feedback.METHOD,
    shooting.METHOD,
    underactuated.METHOD,
    fault_tolerant.METHOD,
)


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllerParameters(FaultTolerantParameters, CommonParameters):
    """Section ``nmpc_controller``: what every method reads, and what each one adds."""
