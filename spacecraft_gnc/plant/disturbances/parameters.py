"""The disturbances of this package, and the parameters that they add to the section of a plant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from spacecraft_gnc.parameters.parameter import Kind, parameter
from spacecraft_gnc.plant.disturbances.constant import ConstantParameters, ConstantTorque
from spacecraft_gnc.plant.disturbances.gravity_gradient import (
    GravityGradient,
    GravityGradientParameters,
)
from spacecraft_gnc.plant.disturbances.noise import NoiseParameters, NoiseTorque
from spacecraft_gnc.plant.disturbances.push import Push, PushParameters

BUILT_IN: Final[Mapping[str, Any]] = {
    "constant": ConstantTorque,
    "gravity_gradient": GravityGradient,
    "noise": NoiseTorque,
    "push": Push,
}
"""Classes with a class method ``from_parameters(parameters, inertia)``."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DisturbanceParameters(
    PushParameters, NoiseParameters, GravityGradientParameters, ConstantParameters
):
    """What the section of a plant with disturbances adds to it."""

    disturbances: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        [],
        f"external torques on the body, which the controller does not know: {', '.join(BUILT_IN)}, "
        "or those of another package",
        shape=(-1,),
        may_be_empty=True,
        unique=True,
        is_neutral=True,
    )
