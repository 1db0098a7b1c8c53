"""Parameters of ``reference_governor``: the target, and how the reference gets there."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.attitude import TargetParameters
from spacecraft_gnc.parameters.parameter import ANGLES, LARGEST, LONGEST, Kind, group, parameter
from spacecraft_gnc.types import Array, Vector3
from spacecraft_gnc.vehicles.rigid_body.parameters.plan import PlanParameters


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class AttitudeLawParameters:
    """What ``governor: attitude`` reads."""

    initial_reference_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "attitude: reference before the first step, exp(hat(.)); empty: the attitude at that step",
        unit="rad",
        shape=(3,),
        may_be_empty=True,
        **ANGLES,
    )
    max_torque: float = parameter(
        Kind.DOUBLE,
        0.0,
        "attitude: largest norm of the torque that the governed loop may command; 0: no limit",
        unit="N m",
        minimum=0.0,
        maximum=LARGEST,
    )
    max_momentum: float = parameter(
        Kind.DOUBLE,
        0.0,
        "attitude: largest norm of the angular momentum; 0: no limit",
        unit="N m s",
        minimum=0.0,
        maximum=LARGEST,
    )
    steady_margin_deg: float = parameter(
        Kind.DOUBLE,
        0.1,
        "attitude: angle to every zone that a reference keeps at rest",
        unit="deg",
        above=0.0,
        below=90.0,
    )
    lyapunov_level: float = parameter(
        Kind.DOUBLE,
        0.0,
        "attitude, feedback: level of the invariant set around a reference; 0: computed",
        unit="J",
        minimum=0.0,
        maximum=LARGEST,
    )
    prediction_horizon: int = parameter(
        Kind.INTEGER,
        0,
        "attitude: steps of a prediction; 0: computed for the loop",
        unit="steps",
        minimum=0,
        maximum=1_000_000,
    )
    alpha_tolerance: float = parameter(
        Kind.DOUBLE,
        1.0e-6,
        "attitude: interval of alpha at which the bisection ends",
        above=0.0,
        below=1.0,
    )
    cut_point_shift: float = parameter(
        Kind.DOUBLE,
        0.01,
        "attitude: share of half a turn by which a target opposite to the reference is moved",
        above=0.0,
        below=1.0,
    )
    route: bool = parameter(
        Kind.BOOL,
        True,
        "attitude: go round a zone across the way by intermediate references",
    )
    route_clearance_deg: float = parameter(
        Kind.DOUBLE,
        2.0,
        "attitude: angle to every zone that intermediate references keep",
        unit="deg",
        above=0.0,
        below=90.0,
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class TurningParameters:
    """What ``governor: turning_reference`` reads beside the target, its attitude at step 0."""

    reference_rate: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "turning_reference: constant angular velocity, in its own frame, of a reference that "
        "starts at the target",
        unit="rad/s",
        shape=(3,),
        is_neutral=True,
        **ANGLES,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class TrajectoryTable:
    """A stored trajectory, row by row."""

    times: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "stored_trajectory: time of each row, from 0 on, increasing",
        unit="s",
        shape=(-1,),
        may_be_empty=True,
        is_neutral=True,
        minimum=0.0,
        maximum=LONGEST,
    )
    rotation_vectors: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "stored_trajectory: attitude exp(hat(.)) of each row, body to inertial",
        unit="rad",
        shape=(-1, 3),
        may_be_empty=True,
        is_neutral=True,
        **ANGLES,
    )
    angular_velocities: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "stored_trajectory: angular velocity of each row, in the reference's own frame",
        unit="rad/s",
        shape=(-1, 3),
        may_be_empty=True,
        is_neutral=True,
        **ANGLES,
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class TrajectoryParameters:
    """What ``governor: stored_trajectory`` reads."""

    trajectory: TrajectoryTable = group(TrajectoryTable)


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class PlannedLawParameters:
    """What ``governor: planned`` reads beside the target."""

    plan: PlanParameters = group(PlanParameters)


@dataclass(frozen=True, kw_only=True, eq=False)
class GovernorParameters(
    PlannedLawParameters,
    TrajectoryParameters,
    TurningParameters,
    AttitudeLawParameters,
    TargetParameters,
):
    """Section ``reference_governor``."""
