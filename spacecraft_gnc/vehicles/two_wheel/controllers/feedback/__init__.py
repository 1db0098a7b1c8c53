"""``method: feedback``: attitude feedback for three or more wheels (`law`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import Kind, parameter
from spacecraft_gnc.vehicles.vehicle import Method


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class FeedbackParameters:
    """Parameters of ``method: feedback``."""

    feedback_bandwidth: float = parameter(
        Kind.DOUBLE,
        0.1,
        "feedback: natural frequency w of the loop near the target",
        unit="rad/s",
        above=0.0,
        maximum=1e6,
        formula="8 / settling_time",
    )
    feedback_damping_ratio: float = parameter(
        Kind.DOUBLE,
        1.0,
        "feedback: damping ratio zeta of the loop near the target",
        above=0.0,
        maximum=1e3,
    )


METHOD: Final = Method(
    name="feedback",
    build=Lazy(f"{__name__}.controller:FeedbackController.from_scenario"),
    parameters=FeedbackParameters,
    memoryless=True,
)
