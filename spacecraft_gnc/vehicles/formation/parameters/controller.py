"""Parameters of ``nmpc_controller``: the weights of the law that every craft flies by."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import LARGEST_WEIGHT, LONGEST, Kind, group, parameter
from spacecraft_gnc.parameters.sections import ControllerHost


@dataclass(frozen=True, kw_only=True, eq=False)
class WeightParameters:
    """Diagonals of Q and R, one number for three components; the report's Table 1 in SI units."""

    position: float = parameter(
        Kind.DOUBLE,
        1e-6,
        "weight of the position error; 1 1/km^2 in the report",
        unit="1/m^2",
        above=0.0,
        maximum=LARGEST_WEIGHT,
    )
    velocity: float = parameter(
        Kind.DOUBLE,
        1e-9,
        "weight of the velocity error; 1e-3 s^2/km^2 in the report",
        unit="s^2/m^2",
        minimum=0.0,
        maximum=LARGEST_WEIGHT,
    )
    delta_v: float = parameter(
        Kind.DOUBLE,
        100.0,
        "weight of the change of velocity; 1e8 s^2/km^2 in the report",
        unit="s^2/m^2",
        above=0.0,
        maximum=LARGEST_WEIGHT,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllerParameters(ControllerHost):
    """Section ``nmpc_controller``, which holds for every craft."""

    method: str = parameter(
        Kind.STRING, "lqr", "method that finds the change of velocity", plugins="controllers"
    )
    time_step: float = parameter(
        Kind.DOUBLE,
        0.0,
        "control period, of which the orbital period is a whole multiple; 0: plant.time_step",
        unit="s",
        minimum=0.0,
        maximum=LONGEST,
        otherwise="plant.time_step",
    )
    weights: WeightParameters = group(WeightParameters)
