"""Parameters of ``nmpc_controller``: what it believes of the deputy, and the weights of its law."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import (
    LARGEST,
    LARGEST_WEIGHT,
    LONGEST,
    SHORTEST,
    Kind,
    MatrixRule,
    group,
    parameter,
)
from spacecraft_gnc.parameters.sections import ControllerHost
from spacecraft_gnc.types import Matrix3


def _weight(default: float, of: str, unit: str, *, positive: bool = False) -> float:
    """Return the field of a weight of the cost (9)."""
    least = {"above": 0.0} if positive else {"minimum": 0.0}
    weight: float = parameter(
        Kind.DOUBLE, default, f"weight of {of}", unit=unit, maximum=LARGEST_WEIGHT, **least
    )
    return weight


@dataclass(frozen=True, kw_only=True, eq=False)
class WeightParameters:
    """Diagonals of Q and R in the cost (9) of the report, one number for three components."""

    port_offset: float = _weight(0.01, "the port offset", "1/m^2")
    port_velocity: float = _weight(1.0, "the port velocity", "s^2/m^2")
    attitude: float = _weight(0.1, "the rotation vector", "1/rad^2")
    angular_velocity: float = _weight(10.0, "the angular velocity", "s^2/rad^2")
    force: float = _weight(1.0, "the force", "1/N^2", positive=True)
    moment: float = _weight(100.0, "the moment", "1/(N m)^2", positive=True)


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllerParameters(ControllerHost):
    """Section ``nmpc_controller``, which both methods read whole."""

    method: str = parameter(
        Kind.STRING, "periodic_lqr", "method that finds the wrench", plugins="controllers"
    )
    time_step: float = parameter(
        Kind.DOUBLE,
        5.0,
        "control period, a multiple of plant.time_step, over which the wrench is held",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
    )
    mass: float = parameter(
        Kind.DOUBLE,
        0.0,
        "mass of the deputy that the laws believe; 0: the plant's",
        unit="kg",
        minimum=0.0,
        maximum=LARGEST,
        otherwise="plant.mass",
    )
    inertia: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "inertia matrix of the deputy that the laws believe; empty: the plant's",
        unit="kg m^2",
        shape=(3, 3),
        matrix=MatrixRule.INERTIA,
        may_be_empty=True,
        otherwise="plant.inertia",
    )
    weights: WeightParameters = group(WeightParameters)
