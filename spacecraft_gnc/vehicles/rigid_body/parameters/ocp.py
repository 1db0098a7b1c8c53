"""Parameters that methods share: horizon, weights, limits as penalties, Newton's method."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import (
    LARGEST_WEIGHT,
    WITHIN,
    Kind,
    MatrixRule,
    group,
    parameter,
)
from spacecraft_gnc.types import Array, Matrix3


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class OcpWeights:
    """Weights of every cost; (3, 3) each, a scalar s in the file stands for s I."""

    stage_attitude: Matrix3 = parameter(
        Kind.DYNAMIC,
        1.0,
        "stage weight on the attitude error",
        shape=(3, 3),
        matrix=MatrixRule.SEMIDEFINITE,
        minimum=0.0,
        maximum=LARGEST_WEIGHT,
        formula="omega^4 E(J W J)",
    )
    stage_torque: Matrix3 = parameter(
        Kind.DYNAMIC,
        1.0,
        "stage weight on the torque",
        unit="(N m)^-2",
        shape=(3, 3),
        matrix=MatrixRule.DEFINITE,
        above=0.0,
        maximum=LARGEST_WEIGHT,
        formula="1 / u_0^2; where another weight is given, what stands to it in the ratio of the "
        "formulas",
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class PenalizedWeights(OcpWeights):
    """Weights of the cost of Gupta et al. 2015, (27)-(28)."""

    stage_momentum: Matrix3 = parameter(
        Kind.DYNAMIC,
        1.0,
        "stage weight on the angular momentum",
        unit="(N m s)^-2",
        shape=(3, 3),
        matrix=MatrixRule.SEMIDEFINITE,
        minimum=0.0,
        maximum=LARGEST_WEIGHT,
        formula="2 omega^2 E(W)",
    )
    terminal_attitude: Matrix3 = parameter(
        Kind.DYNAMIC,
        1.0,
        "terminal weight on the attitude error",
        shape=(3, 3),
        matrix=MatrixRule.SEMIDEFINITE,
        minimum=0.0,
        maximum=LARGEST_WEIGHT,
        formula="omega^2 sqrt(1 / T^2 + 4 omega^2) E(J W J)",
    )
    terminal_momentum: Matrix3 = parameter(
        Kind.DYNAMIC,
        1.0,
        "terminal weight on the angular momentum",
        unit="(N m s)^-2",
        shape=(3, 3),
        matrix=MatrixRule.SEMIDEFINITE,
        minimum=0.0,
        maximum=LARGEST_WEIGHT,
        formula="2 omega E(W)",
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class OcpParameters:
    """What every method reads that minimizes a cost over a horizon."""

    horizon: int = parameter(
        Kind.INTEGER,
        5,
        "prediction horizon",
        unit="steps",
        minimum=1,
        maximum=10_000,
        formula="settling_time / (4 h), 5 to 60",
    )
    residual_tolerance: float = parameter(
        Kind.DOUBLE,
        1.0e-12,
        "largest residual of the optimality conditions that counts as solved, relative to the "
        "largest multiplier",
        above=0.0,
    )
    max_iterations: int = parameter(
        Kind.INTEGER, 50, "Newton steps after which one solve gives up", minimum=1
    )
    weights: OcpWeights = group(OcpWeights)


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class PenalizedParameters(OcpParameters):
    """What the problem with penalties for its limits is made of."""

    actuators: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "actuator matrix B, torque = B u with one column an actuator, body frame; "
        "empty: the identity",
        shape=(3, -1),
        may_be_empty=True,
        **WITHIN,
    )
    torque_penalty: float = parameter(
        Kind.DOUBLE,
        1.0e10,
        "weight of the torque limit in the cost",
        unit="(N m)^-4",
        above=0.0,
        maximum=LARGEST_WEIGHT,
        formula="1e6 S / U^2 max(1, J_max omega^2 / (4 U)), U = u_0 without a limit",
    )
    standstill_error_deg: float = parameter(
        Kind.DOUBLE,
        0.1,
        "attitude error above which a standstill is examined; 0: never",
        unit="deg",
        minimum=0.0,
    )
    weights: PenalizedWeights = group(PenalizedWeights)


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class NewtonParameters(PenalizedParameters):
    """Options of Newton's method."""

    formulation: str = parameter(
        Kind.STRING,
        "auto",
        "how the linear systems of Newton's method are formed and solved",
        choices=("auto", "backward_sweep", "single_shooting"),
    )
    step_rule: str = parameter(
        Kind.STRING,
        "backtracking",
        "length of Newton's steps; chord keeps the Jacobian while it contracts",
        choices=("backtracking", "full", "damped", "chord"),
    )
    damping: float = parameter(
        Kind.DOUBLE, 0.5, "length of the steps of step_rule damped", above=0.0, maximum=1.0
    )
    continuation: str = parameter(
        Kind.STRING,
        "auto",
        "what is tried where a solve fails; auto: several starts, also where one takes more than 4 "
        "Newton steps, and the cheapest solution",
        choices=("none", "auto", "penalty", "state", "horizon", "effort"),
    )
