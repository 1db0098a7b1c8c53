"""Governor laws of the formation."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.formation.parameters.governor import NoLawParameters, ShiftParameters
from spacecraft_gnc.vehicles.vehicle import GovernorLaw

_BUILD: Final = f"{__package__}.build"

LAWS: Final[tuple[GovernorLaw, ...]] = (
    GovernorLaw(
        name="none",
        build=Lazy(f"{_BUILD}:pass_through"),
        parameters=NoLawParameters,
        looks_ahead=False,
    ),
    GovernorLaw(name="time_shift", build=Lazy(f"{_BUILD}:time_shift"), parameters=ShiftParameters),
)
