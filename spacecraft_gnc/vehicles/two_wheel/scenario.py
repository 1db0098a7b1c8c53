"""Protocol of a scenario, as this vehicle reads it."""

from __future__ import annotations

from typing import Any, Protocol

from spacecraft_gnc.loop.protocols import Controller
from spacecraft_gnc.parameters.attitude import TargetParameters
from spacecraft_gnc.vehicles.two_wheel.controllers.methods import ControllerParameters
from spacecraft_gnc.vehicles.two_wheel.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.vehicle import Method


class Scenario(Protocol):
    """A checked scenario of a spacecraft with wheels (`scenario.Scenario`)."""

    @property
    def path(self) -> str:
        """Where it comes from."""

    @property
    def plant(self) -> PlantParameters:
        """Section ``plant``."""

    @property
    def controller(self) -> ControllerParameters:
        """Section ``nmpc_controller``."""

    @property
    def governor(self) -> TargetParameters:
        """Section ``reference_governor``."""

    @property
    def method(self) -> Method:
        """Method of the controller."""

    @property
    def period(self) -> float:
        """Control period [s]."""

    @property
    def substeps(self) -> int:
        """Integrator steps in one control period."""

    @property
    def n_steps(self) -> int:
        """Whole control steps in the duration."""

    def build_plant(self) -> Any:
        """Return the plant of the scenario."""

    def build_controller(self) -> Controller[Any, Any]:
        """Return a controller of the scenario."""
