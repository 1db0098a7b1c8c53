"""The parameters of ``nmpc_controller``: torque law, horizon and limits."""

from __future__ import annotations

from dataclasses import dataclass, field

from spacecraft_gnc.parameters.parameter import (
    ANGLES,
    LARGEST,
    LARGEST_WEIGHT,
    LONGEST,
    SHORTEST,
    WITHIN,
    Kind,
    MatrixRule,
    NodeParameters,
    parameter,
)
from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.rigid_body.parameters.cost import WeightParameters, ZoneParameters


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ControllerParameters(NodeParameters):
    """Section ``nmpc_controller``: the torque law and its optimal control problem."""

    method: str = parameter(
        Kind.STRING, "shooting", "method that finds the torque", plugins="controllers"
    )
    variant: str = parameter(Kind.STRING, "exact", "variant of the method")
    time_step: float = parameter(
        Kind.DOUBLE,
        0.0,
        "control period and prediction step, a multiple of plant.time_step; 0: plant.time_step",
        unit="s",
        minimum=0.0,
    )
    inertia: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "inertia matrix that the controller believes; empty: the plant's",
        unit="kg m^2",
        shape=(3, 3),
        matrix=MatrixRule.INERTIA,
        may_be_empty=True,
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
    horizon: int = parameter(
        Kind.INTEGER,
        5,
        "prediction horizon",
        unit="steps",
        minimum=1,
        maximum=10_000,
        formula="settling_time / (4 h), 5 to 60",
    )
    actuators: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "actuator matrix B, torque = B u with one column an actuator, body frame; "
        "empty: the identity",
        shape=(3, -1),
        may_be_empty=True,
        **WITHIN,
    )
    max_torque: float = parameter(
        Kind.DOUBLE,
        0.0,
        "largest norm of the actuator commands u (of the torque, without actuators); 0: no limit",
        unit="N m",
        minimum=0.0,
        maximum=LARGEST,
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
    zone_names: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        [],
        "names of the pointing zones, each defined under zones",
        shape=(-1,),
        may_be_empty=True,
        unique=True,
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
    standstill_error_deg: float = parameter(
        Kind.DOUBLE,
        0.1,
        "attitude error above which a standstill is examined; 0: never",
        unit="deg",
        minimum=0.0,
    )
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
    feedback_attitude_gain: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "feedback: gain A on the attitude error",
        unit="N m",
        shape=(3, 3),
        matrix=MatrixRule.DEFINITE,
        maximum=LARGEST,
        may_be_empty=True,
        formula="omega^2 (0.501 tr(J) I - J)",
    )
    feedback_momentum_gain: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "feedback: gain K on the angular momentum",
        unit="1/s",
        shape=(3, 3),
        matrix=MatrixRule.DEFINITE,
        maximum=LARGEST,
        may_be_empty=True,
        formula="2 omega I",
    )
    terminal_set: str = parameter(
        Kind.STRING,
        "true",
        "terminal_set: terminal constraint; without_kappa: without the torque limit of the "
        "terminal controller",
        choices=("true", "false", "without_kappa"),
    )
    stage_cost_scale: float = parameter(
        Kind.DOUBLE,
        0.1,
        "terminal_set: factor lambda of the stage cost",
        above=0.0,
        below=1.0,
    )
    weights: WeightParameters = field(default_factory=WeightParameters)
    zones: tuple[ZoneParameters, ...] = ()
    """In the order of ``zone_names``."""
