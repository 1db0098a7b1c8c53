"""Methods of the formation: one linear law for every craft."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.formation.parameters.controller import ControllerParameters
from spacecraft_gnc.vehicles.vehicle import Method

METHODS: Final[tuple[Method, ...]] = (
    Method(
        name="lqr",
        build=Lazy(f"{__package__}.lqr:lqr"),
        parameters=ControllerParameters,
        memoryless=True,
    ),
)
