"""Parameters of ``plant``: bus, wheels, start and duration.

Angles are in radians; matrices are row-major; vectors are in the body frame unless the name says
otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import (
    ANGLES,
    LARGEST,
    LONGEST,
    SHORTEST,
    WITHIN,
    Kind,
    MatrixRule,
    parameter,
)
from spacecraft_gnc.parameters.sections import PlantHost
from spacecraft_gnc.types import Array, Matrix3, Vector3


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class WheelParameters(PlantHost):
    """Bus and wheels."""

    inertia: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "inertia matrix of the bus with all wheels locked, about the common center of mass, body "
        "frame; principal moments of 1e-12 to 1e15",
        unit="kg m^2",
        shape=(3, 3),
        matrix=MatrixRule.INERTIA,
        required=True,
        may_be_empty=True,
    )
    wheel_axes: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "spin axis of each of the m wheels in the body frame, one column each, of any length: all "
        "x first, then all y, then all z",
        shape=(3, -1),
        required=True,
        may_be_empty=True,
        **WITHIN,
    )
    wheel_inertias: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "m inertias of the wheels about their spin axes; contained in the inertia",
        unit="kg m^2",
        shape=(-1,),
        required=True,
        may_be_empty=True,
        above=0.0,
        maximum=LARGEST,
    )
    max_wheel_speed: float = parameter(
        Kind.DOUBLE,
        0.0,
        "largest size of a wheel's speed relative to the bus, at which it saturates; 0: no limit",
        unit="rad/s",
        minimum=0.0,
        maximum=LARGEST,
    )
    max_wheel_acceleration: float = parameter(
        Kind.DOUBLE,
        0.0,
        "largest size of a wheel's acceleration relative to the bus, likewise; 0: no limit",
        unit="rad/s^2",
        minimum=0.0,
        maximum=LARGEST,
    )
    wheel_viscous_friction: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "m coefficients of viscous friction of the wheels' bearings; empty: none",
        unit="N m s",
        shape=(-1,),
        may_be_empty=True,
        minimum=0.0,
        maximum=LARGEST,
        is_neutral=True,
    )
    wheel_coulomb_friction: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "m torques of Coulomb friction of the wheels' bearings; empty: none",
        unit="N m",
        shape=(-1,),
        may_be_empty=True,
        minimum=0.0,
        maximum=LARGEST,
        is_neutral=True,
    )
    wheel_lost_at: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "m times from which on a wheel is lost as wheel_loss says, within the flight; negative: "
        "never; empty: none is lost",
        unit="s",
        shape=(-1,),
        may_be_empty=True,
        minimum=-1.0,
        maximum=LONGEST,
    )
    wheel_loss: str = parameter(
        Kind.STRING,
        "friction",
        "what a lost wheel does: friction (its motor is dead, and it brakes to rest by "
        "lost_wheel_friction beside that of its bearing), spinning (dead, and only its bearing "
        "brakes it, if at all), partial (it answers lost_wheel_share of each command)",
        choices=("friction", "spinning", "partial"),
        is_neutral=True,
    )
    lost_wheel_friction: float = parameter(
        Kind.DOUBLE,
        0.0,
        "wheel_loss friction: Coulomb friction that brakes a lost wheel",
        unit="N m",
        minimum=0.0,
        maximum=LARGEST,
        formula="Js U / 10 with the largest Js and the limit U of acceleration; without it, what "
        "stops the largest Js from 10 rad/s in a settling_time; 0 where no wheel is lost so",
        is_neutral=True,
    )
    lost_wheel_share: float = parameter(
        Kind.DOUBLE,
        0.5,
        "wheel_loss partial: share of the commanded acceleration, within its limit, that a lost "
        "wheel gives",
        minimum=0.0,
        maximum=1.0,
        is_neutral=True,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantParameters(WheelParameters):
    """Section ``plant``: bus and wheels, their start, and the pace of the simulation."""

    time_step: float = parameter(
        Kind.DOUBLE,
        1.0,
        "step of the integrator",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
        formula="nmpc_controller.time_step, where that is given; else settling_time / 80, at most "
        "0.2 rad / |omega_0|, in whole ns",
    )
    duration: float = parameter(
        Kind.DOUBLE,
        3.0,
        "simulated time; a last fraction of a control period is not flown",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
        formula="3 settling_time",
    )
    initial_euler_321: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "initial attitude as roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll), body to inertial; "
        "empty: initial_rotation_vector",
        unit="rad",
        shape=(3,),
        may_be_empty=True,
        **ANGLES,
    )
    initial_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "initial attitude R_0 = exp(hat(.)), body to inertial, where no Euler angles are given",
        unit="rad",
        shape=(3,),
        **ANGLES,
    )
    initial_angular_velocity: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "initial rate of the bus relative to the inertial frame, body frame",
        unit="rad/s",
        shape=(3,),
        **WITHIN,
    )
    initial_total_momentum: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "initial momentum of bus and wheels, inertial frame, which sets the initial rate; empty: "
        "it follows from initial_angular_velocity",
        unit="N m s",
        shape=(3,),
        may_be_empty=True,
        is_neutral=True,
        **WITHIN,
    )
    initial_wheel_speed: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "m initial speeds of the wheels relative to the bus; empty: none turns",
        unit="rad/s",
        shape=(-1,),
        may_be_empty=True,
        **WITHIN,
    )
    pose_every: int = parameter(
        Kind.INTEGER, 1, "publish a PoseStamped every n-th control step; 0: never", minimum=0
    )
