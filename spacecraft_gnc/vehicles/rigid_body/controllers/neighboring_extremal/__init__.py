"""``method: neighboring_extremal``: on line, or along a stored nominal run as in the paper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import ANGLES, WITHIN, Kind, parameter
from spacecraft_gnc.types import Vector3
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import NewtonParameters
from spacecraft_gnc.vehicles.vehicle import Method


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class NeighboringParameters(NewtonParameters):
    """Parameters of ``method: neighboring_extremal``."""

    nominal_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "neighboring_extremal: initial attitude exp(hat(.)) of the stored nominal run; "
        "empty: no nominal run, on-line method",
        unit="rad",
        shape=(3,),
        may_be_empty=True,
        **ANGLES,
    )
    nominal_momentum: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "neighboring_extremal: initial angular momentum of the stored nominal run, body frame",
        unit="N m s",
        shape=(3,),
        **WITHIN,
    )
    exact_every: int = parameter(
        Kind.INTEGER,
        0,
        "neighboring_extremal along a nominal run: an exact solve every that many steps; 0: never",
        unit="steps",
        minimum=0,
    )
    ne_tolerance: float = parameter(
        Kind.DOUBLE,
        1.0e-3,
        "neighboring_extremal on-line: largest bound of the error of the planned torques, as a "
        "share of max_torque (without a limit, of the largest torque of the last exact plan)",
        above=0.0,
    )
    ne_max_age: int = parameter(
        Kind.INTEGER,
        10,
        "neighboring_extremal on-line: steps after which an exact solve is made anyway",
        unit="steps",
        minimum=1,
    )


METHOD: Final = Method(
    name="neighboring_extremal",
    build=Lazy(f"{__name__}.controller:from_scenario"),
    parameters=NeighboringParameters,
    certifier=Lazy("spacecraft_gnc.vehicles.rigid_body.audit.plans:of_corrections"),
)
