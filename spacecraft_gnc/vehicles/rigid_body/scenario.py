"""Protocol of a scenario, as this vehicle reads it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from spacecraft_gnc.parameters.problems import InvalidScenario, Problem
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.rigid_body.controllers.methods import ControllerParameters
from spacecraft_gnc.vehicles.rigid_body.parameters.governor import GovernorParameters
from spacecraft_gnc.vehicles.rigid_body.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.vehicle import GovernorLaw, VehicleScenario


class Scenario(VehicleScenario, Protocol):
    """A checked scenario of a rigid body (`scenario.Scenario`)."""

    @property
    def plant(self) -> PlantParameters:
        """Section ``plant``."""

    @property
    def controller(self) -> ControllerParameters:
        """Section ``nmpc_controller``."""

    @property
    def governor(self) -> GovernorParameters:
        """Section ``reference_governor``."""

    @property
    def sections(self) -> Mapping[str, Mapping[str, Any]]:
        """What was given, by section."""

    @property
    def law(self) -> GovernorLaw:
        """Law of the governor."""


def known_inertia(scenario: Scenario, section: str, inertia: Matrix3) -> Matrix3:
    """Return an inertia (3, 3) of a section; NaN stands for one that was not given.

    Raises
    ------
    InvalidScenario
        If it was not given.
    """
    if np.isnan(inertia).any():
        key, need = f"{section}.inertia", "9 numbers (3x3, row-major) [kg m^2]"
        raise InvalidScenario([Problem(scenario.path, None, key, "nothing", need, "add it")])
    return inertia


def reservation(scenario: Scenario) -> str:
    """Return what the guarantee of a governor rests on; empty where nothing is to be said.

    What flies on board predicts with the inertia that the controller believes, and does not know of
    disturbances.
    """
    believed, plant = scenario.controller.inertia, scenario.plant
    rests = (
        ("for the believed inertia", not np.array_equal(believed, plant.inertia)),
        ("without the disturbances", bool(plant.disturbances)),
    )
    told = " and ".join(text for text, holds in rests if holds)
    return f"limits are sure {told} only" if told and scenario.law.looks_ahead else ""
