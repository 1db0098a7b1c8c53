"""Protocol of a scenario, as this vehicle reads it."""

from __future__ import annotations

from typing import Any, Protocol

from spacecraft_gnc.vehicles.formation.parameters.controller import ControllerParameters
from spacecraft_gnc.vehicles.formation.parameters.governor import GovernorParameters
from spacecraft_gnc.vehicles.formation.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.vehicle import VehicleScenario


class Scenario(VehicleScenario, Protocol):
    """A checked formation scenario (`scenario.Scenario`)."""

    @property
    def plant(self) -> PlantParameters:
        """Section ``plant``."""

    @property
    def controller(self) -> ControllerParameters:
        """Section ``nmpc_controller``."""

    @property
    def governor(self) -> GovernorParameters:
        """Section ``reference_governor``."""

    def build_plant(self) -> Any:
        """Return the plant of the scenario."""
