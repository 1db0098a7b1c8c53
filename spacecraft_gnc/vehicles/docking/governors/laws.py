"""Governor laws of the docking vehicle."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.docking.parameters.governor import NoLawParameters, SetParameters
from spacecraft_gnc.vehicles.vehicle import GovernorLaw

_BUILD: Final = f"{__package__}.build"

LAWS: Final[tuple[GovernorLaw, ...]] = (
    GovernorLaw(
        name="none",
        build=Lazy(f"{_BUILD}:pass_through"),
        parameters=NoLawParameters,
        looks_ahead=False,
    ),
    GovernorLaw(name="periodic", build=Lazy(f"{_BUILD}:periodic"), parameters=SetParameters),
    GovernorLaw(
        name="time_invariant", build=Lazy(f"{_BUILD}:time_invariant"), parameters=SetParameters
    ),
)
