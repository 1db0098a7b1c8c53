"""``method: shooting``: NMPC of the bus, its torques allocated to three or more wheels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import Kind, parameter
from spacecraft_gnc.vehicles.two_wheel.controllers.feedback import FeedbackParameters
from spacecraft_gnc.vehicles.vehicle import Method


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class ShootingParameters(FeedbackParameters):
    """Parameters of ``method: shooting``; its weights follow from ``feedback_bandwidth``."""

    torque_horizon: int = parameter(
        Kind.INTEGER,
        20,
        "shooting: horizon over which the torques on the bus are planned",
        unit="steps",
        minimum=2,
        maximum=10_000,
        is_neutral=True,
    )


METHOD: Final = Method(
    name="shooting",
    build=Lazy(f"{__name__}.controller:ShootingController.from_scenario"),
    parameters=ShootingParameters,
)
