"""Parameters of a pointing zone."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import LARGEST_WEIGHT, WITHIN, Kind, parameter
from spacecraft_gnc.types import Vector3


@dataclass(frozen=True, kw_only=True, eq=False)
class ZoneParameters:
    """One pointing zone: a cone that a body axis must stay out of, or inside."""

    name: str
    kind: str = parameter(
        Kind.STRING,
        "exclusion",
        "exclusion: stay out of the cone; inclusion: stay inside",
        choices=("exclusion", "inclusion"),
    )
    body_axis: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "axis of the instrument, body frame (normalized)",
        shape=(3,),
        nonzero=True,
        required=True,
        may_be_empty=True,
        **WITHIN,
    )
    inertial_axis: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "axis of the cone, inertial frame (normalized)",
        shape=(3,),
        nonzero=True,
        required=True,
        may_be_empty=True,
        **WITHIN,
    )
    half_angle_deg: float = parameter(
        Kind.DOUBLE,
        0.0,
        "half-angle of the cone",
        unit="deg",
        above=0.0,
        below=180.0,
        required=True,
    )
    penalty: float = parameter(
        Kind.DOUBLE,
        1.0,
        "weight of the soft constraint in the cost",
        above=0.0,
        maximum=LARGEST_WEIGHT,
        formula="1e5 max(stage_attitude, terminal_attitude / (N h)), largest eigenvalues",
    )
