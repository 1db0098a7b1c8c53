"""Governor laws of a spacecraft with wheels."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.attitude import NoLawParameters
from spacecraft_gnc.vehicles.vehicle import GovernorLaw

LAWS: Final[tuple[GovernorLaw, ...]] = (
    GovernorLaw(
        name="none",
        build=Lazy(f"{__package__}.build:pass_through"),
        parameters=NoLawParameters,
        looks_ahead=False,
    ),
)
