"""Parameters of ``nmpc_controller`` that concern every method: body, limits and zones."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import (
    LARGEST,
    LONGEST,
    SHORTEST,
    Kind,
    MatrixRule,
    named_groups,
    parameter,
)
from spacecraft_gnc.parameters.sections import ControllerHost, method_named
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.rigid_body.parameters.zones import ZoneParameters


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class CommonParameters(ControllerHost):
    """What is known of body, limits and zones, whatever the method."""

    method: str = method_named("shooting")
    inertia: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "inertia matrix that the controller believes; empty: the plant's",
        unit="kg m^2",
        shape=(3, 3),
        matrix=MatrixRule.INERTIA,
        may_be_empty=True,
        otherwise="plant.inertia",
    )
    settling_time: float = parameter(
        Kind.DOUBLE,
        1.0,
        "time in which a turn of 30 deg is to settle to 0.1 deg; what is not given of weights and "
        "gains follows from it",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
        formula="4 sqrt(J_max / U), at least 40 periods h that are given; without a torque limit "
        "80 h, and 60 s where no h is given",
    )
    max_torque: float = parameter(
        Kind.DOUBLE,
        0.0,
        "largest norm of the actuator commands u (of the torque, without actuators); 0: no limit",
        unit="N m",
        minimum=0.0,
        maximum=LARGEST,
    )
    zone_names: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        [],
        "names of the pointing zones, each defined under zones",
        shape=(-1,),
        may_be_empty=True,
        unique=True,
    )
    zones: tuple[ZoneParameters, ...] = named_groups(ZoneParameters, "zone_names", "zone")
    """In the order of ``zone_names``."""
