"""``method: fault_tolerant``: NMPC that survives the loss of a wheel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import LARGEST, Kind, parameter
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.controllers.shooting import ShootingParameters
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated import UnderactuatedParameters
from spacecraft_gnc.vehicles.vehicle import Method


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class FaultTolerantParameters(ShootingParameters, UnderactuatedParameters):
    """Parameters of ``method: fault_tolerant``."""

    wheel_viscous_friction: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "fault_tolerant: largest viscous friction of each healthy wheel; empty: the plant's",
        unit="N m s",
        shape=(-1,),
        may_be_empty=True,
        otherwise="plant.wheel_viscous_friction",
        minimum=0.0,
        maximum=LARGEST,
        is_neutral=True,
    )
    wheel_coulomb_friction: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "fault_tolerant: largest Coulomb friction of each healthy wheel; empty: the plant's",
        unit="N m",
        shape=(-1,),
        may_be_empty=True,
        otherwise="plant.wheel_coulomb_friction",
        minimum=0.0,
        maximum=LARGEST,
        is_neutral=True,
    )


METHOD: Final = Method(
    name="fault_tolerant",
    build=Lazy(f"{__name__}.controller:FaultTolerantController.from_scenario"),
    parameters=FaultTolerantParameters,
)
