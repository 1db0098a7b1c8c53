"""The parameters of the disturbances, in the section of the plant."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import WITHIN, Kind, NodeParameters, parameter
from spacecraft_gnc.types import Vector3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DisturbanceParameters(NodeParameters):
    """What the sections of plants with disturbances share."""

    disturbances: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        [],
        "external torques on the body, which the controller does not know: constant, "
        "gravity_gradient, noise, or those of another package",
        shape=(-1,),
        may_be_empty=True,
        unique=True,
    )
    constant_torque: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "constant: torque, body frame",
        unit="N m",
        shape=(3,),
        may_be_empty=True,
        **WITHIN,
    )
    orbit_rate: float = parameter(
        Kind.DOUBLE,
        0.0,
        "gravity_gradient: rate sqrt(mu / a^3) of the circular orbit",
        unit="rad/s",
        minimum=0.0,
        maximum=1e3,
    )
    orbit_normal: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 1.0],
        "gravity_gradient: direction of the orbital angular momentum, inertial frame",
        shape=(3,),
        nonzero=True,
        **WITHIN,
    )
    orbit_position: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [1.0, 0.0, 0.0],
        "gravity_gradient: direction from the attracting center to the spacecraft at time 0, "
        "inertial frame, perpendicular to orbit_normal",
        shape=(3,),
        nonzero=True,
        **WITHIN,
    )
    noise_torque: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "noise: standard deviation about each body axis of the torque held over a control step",
        unit="N m",
        shape=(3,),
        may_be_empty=True,
        minimum=0.0,
        maximum=WITHIN["maximum"],
    )
    seed: int = parameter(Kind.INTEGER, 0, "master seed of all random numbers", minimum=0)
    run: int = parameter(
        Kind.INTEGER, 0, "run of a campaign: other random numbers of the same seed", minimum=0
    )
