"""Governor laws of the rigid body."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.attitude import NoLawParameters
from spacecraft_gnc.vehicles.rigid_body.parameters.governor import (
    AttitudeLawParameters,
    PlannedLawParameters,
    TrajectoryParameters,
    TurningParameters,
)
from spacecraft_gnc.vehicles.vehicle import GovernorLaw

NONE: Final = GovernorLaw(
    name="none",
    build=Lazy(f"{__package__}.build:pass_through"),
    parameters=NoLawParameters,
    looks_ahead=False,
)
ATTITUDE: Final = GovernorLaw(
    name="attitude",
    build=Lazy(f"{__package__}.build:attitude_governor"),
    parameters=AttitudeLawParameters,
)
TURNING: Final = GovernorLaw(
    name="turning_reference",
    build=Lazy(f"{__package__}.build:turning_reference"),
    parameters=TurningParameters,
    looks_ahead=False,
    moves=True,
)
STORED: Final = GovernorLaw(
    name="stored_trajectory",
    build=Lazy(f"{__package__}.build:stored_trajectory"),
    parameters=TrajectoryParameters,
    looks_ahead=False,
    moves=True,
)
PLANNED: Final = GovernorLaw(
    name="planned",
    build=Lazy(f"{__package__}.build:planned"),
    parameters=PlannedLawParameters,
)
LAWS: Final[tuple[GovernorLaw, ...]] = (NONE, ATTITUDE, TURNING, STORED, PLANNED)
