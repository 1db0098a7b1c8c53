"""Parameters of ``reference_governor`` of vehicles that turn to a target attitude."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import ANGLES, Kind, parameter
from spacecraft_gnc.parameters.sections import GovernorHost
from spacecraft_gnc.types import Vector3


@dataclass(frozen=True, kw_only=True, eq=False)
class TargetParameters(GovernorHost):
    """What every governor reads: the target, and when a slew has arrived."""

    target_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "target attitude exp(hat(.)), body to inertial",
        unit="rad",
        shape=(3,),
        **ANGLES,
    )
    slew_tolerance_deg: float = parameter(
        Kind.DOUBLE,
        0.1,
        "attitude error under which a slew has arrived",
        unit="deg",
        above=0.0,
        maximum=180.0,
    )
    slew_rate_tolerance: float = parameter(
        Kind.DOUBLE,
        1.0,
        "body rate under which a slew has arrived",
        unit="rad/s",
        above=0.0,
        formula="slew_tolerance_deg pi / 180 omega",
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class NoLawParameters:
    """What ``governor: none`` reads: nothing beside the target."""
