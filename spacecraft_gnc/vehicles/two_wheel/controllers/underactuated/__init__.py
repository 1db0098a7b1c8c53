"""``method: underactuated``: NMPC of the attitude with two wheels (`planner`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import LARGEST_WEIGHT, Kind, parameter
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.vehicle import Method

_WEIGHT: Final = {"above": 0.0, "maximum": LARGEST_WEIGHT}


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class UnderactuatedParameters:
    """Parameters of ``method: underactuated``."""

    prediction_model: str = parameter(
        Kind.STRING,
        "so3",
        "underactuated: model of the attitude; so3: exact, on rotations; euler_321: exact, in "
        "3-2-1 angles; simplified: for small angles",
        choices=("simplified", "euler_321", "so3"),
        is_neutral=True,
    )
    solver: str = parameter(
        Kind.STRING,
        "sqp",
        "underactuated: solver of the problem; ipopt needs CasADi",
        choices=("sqp", "ipopt"),
        is_neutral=True,
    )
    horizon: int = parameter(
        Kind.INTEGER,
        30,
        "underactuated: horizon N over which the accelerations are planned",
        unit="steps",
        minimum=2,
        maximum=1000,
        is_neutral=True,
    )
    attitude_weights: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "underactuated: weights of the attitude error about the first wheel's direction, the "
        "second one in the plane of both, and the third; empty: 1, 1, 30 with so3, else 1, 1, 10",
        unit="rad^-2",
        shape=(3,),
        may_be_empty=True,
        **_WEIGHT,
        is_neutral=True,
    )
    speed_weight: float = parameter(
        Kind.DOUBLE,
        1e-6,
        "underactuated: weight of the wheel speeds",
        unit="(s/rad)^2",
        is_neutral=True,
        **_WEIGHT,
    )
    acceleration_weight: float = parameter(
        Kind.DOUBLE,
        1e-3,
        "underactuated: weight of the wheel accelerations",
        unit="(s^2/rad)^2",
        **_WEIGHT,
        is_neutral=True,
    )
    terminal: str = parameter(
        Kind.STRING,
        "shaped",
        "underactuated: end of a plan where the reference is out of reach; shaped: at rest at a "
        "place that is nearer on a path of turns to it; soft: at rest, near it by terminal_weight; "
        "hard: nowhere, so that it has to be within reach from the start",
        choices=("shaped", "soft", "hard"),
        is_neutral=True,
    )
    terminal_weight: float = parameter(
        Kind.DOUBLE,
        1e4,
        "underactuated: weight of the attitude error at the end of a plan that does not reach it",
        unit="rad^-2",
        **_WEIGHT,
        is_neutral=True,
    )
    restarts: int = parameter(
        Kind.INTEGER,
        3,
        "underactuated: random starts of a solve where no other start leads to a plan",
        minimum=0,
        maximum=1000,
        is_neutral=True,
    )
    seed: int = parameter(
        Kind.INTEGER,
        0,
        "underactuated: seed of the random starts",
        minimum=0,
        maximum=2**31 - 1,
        is_neutral=True,
    )
    chord: bool = parameter(
        Kind.BOOL,
        False,
        "underactuated: whether a solve with sqp keeps the Hessian of its first step",
        is_neutral=True,
    )


METHOD: Final = Method(
    name="underactuated",
    build=Lazy(f"{__name__}.controller:UnderactuatedController.from_scenario"),
    parameters=UnderactuatedParameters,
)


def weights_of(model: str, given: Array) -> Array:
    """Return the attitude weights (3,) of a prediction model: those given, if any."""
    known = given.size and np.isfinite(given).all()  # all NaN: none were given
    return given if known else np.array([1.0, 1.0, 30.0 if model == "so3" else 10.0])
