"""The parameters of a cost: its weights, and the pointing zones of ``nmpc_controller``."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import (
    LARGEST_WEIGHT,
    WITHIN,
    Kind,
    MatrixRule,
    parameter,
)
from spacecraft_gnc.types import Matrix3, Vector3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WeightParameters:
    """Weights of the cost; (3, 3) each, a scalar s in the file stands for s I."""

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
    stage_rate: Matrix3 = parameter(
        Kind.DYNAMIC,
        0.0,
        "terminal_set: stage weight on the rotation of one step, Q_2 of tr(Q_2 (I - F)) / h^2",
        unit="s^2/rad^2",
        shape=(3, 3),
        matrix=MatrixRule.SEMIDEFINITE,
        minimum=0.0,
        maximum=LARGEST_WEIGHT,
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ZoneParameters:
    """One pointing zone: a cone that a body axis must stay out of, or inside."""

    name: str
    kind: str = parameter(
        Kind.STRING,
        "exclusion",
        "exclusion: stay out of the cone; inclusion: stay inside",
        choices=("exclusion", "inclusion"),
    )
    body_axis: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "axis of the instrument, body frame (normalised)",
        shape=(3,),
        nonzero=True,
        required=True,
        may_be_empty=True,
        **WITHIN,
    )
    inertial_axis: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "axis of the cone, inertial frame (normalised)",
        shape=(3,),
        nonzero=True,
        required=True,
        may_be_empty=True,
        **WITHIN,
    )
    half_angle_deg: float = parameter(
        Kind.DOUBLE,
        0.0,
        "half-angle of the cone",
        unit="deg",
        above=0.0,
        below=180.0,
        required=True,
    )
    penalty: float = parameter(
        Kind.DOUBLE,
        1.0,
        "weight of the soft constraint in the cost",
        above=0.0,
        maximum=LARGEST_WEIGHT,
        formula="1e5 max(stage_attitude, terminal_attitude / (N h)), largest eigenvalues",
    )
