"""Parameters of ``nmpc_controller`` that concern every method: what it believes of the spacecraft.

What is left out is what the plant has.
"""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import (
    LARGEST,
    LONGEST,
    SHORTEST,
    WITHIN,
    Kind,
    MatrixRule,
    parameter,
)
from spacecraft_gnc.parameters.sections import ControllerHost
from spacecraft_gnc.types import Array, Matrix3


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class CommonParameters(ControllerHost):
    """What is known of bus and wheels, whatever the method."""

    method: str = parameter(
        Kind.STRING,
        "feedback",
        "method that finds the accelerations of the wheels",
        plugins="controllers",
    )
    inertia: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "inertia matrix, wheels locked, that the controller believes; empty: the plant's",
        unit="kg m^2",
        shape=(3, 3),
        matrix=MatrixRule.INERTIA,
        may_be_empty=True,
        otherwise="plant.inertia",
    )
    wheel_axes: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "wheel axes that the controller believes; empty: the plant's",
        shape=(3, -1),
        may_be_empty=True,
        otherwise="plant.wheel_axes",
        **WITHIN,
    )
    wheel_inertias: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "axial inertias of the wheels that the controller believes; empty: the plant's",
        unit="kg m^2",
        shape=(-1,),
        may_be_empty=True,
        otherwise="plant.wheel_inertias",
        above=0.0,
        maximum=LARGEST,
    )
    max_wheel_speed: float = parameter(
        Kind.DOUBLE,
        0.0,
        "largest size of a wheel's speed that is planned and commanded; 0: the plant's limit",
        unit="rad/s",
        minimum=0.0,
        maximum=LARGEST,
        otherwise="plant.max_wheel_speed",
        is_neutral=True,
    )
    max_wheel_acceleration: float = parameter(
        Kind.DOUBLE,
        0.0,
        "largest size of a wheel's acceleration that is commanded; 0: the plant's limit",
        unit="rad/s^2",
        minimum=0.0,
        maximum=LARGEST,
        otherwise="plant.max_wheel_acceleration",
    )
    settling_time: float = parameter(
        Kind.DOUBLE,
        1.0,
        "time in which a turn of 30 deg is to settle to 0.1 deg; what is not given of gains and "
        "steps follows from it",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
        formula="8 / min(sqrt(s U / J_1), 2 s N / J_1), at least 40 periods h that are given; "
        "without limits 80 h, and 60 s where no h is given",
    )
