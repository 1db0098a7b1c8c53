"""Parameters of ``plant``: body, start and duration.

What carries units has a formula as its default: it follows from the inertia, the torque limit and
the wanted settling time (`defaults`). Angles are in radians unless the name ends in ``_deg``;
matrices are row-major; vectors are in the body frame unless the name says otherwise.
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
from spacecraft_gnc.plant.disturbances.parameters import DisturbanceParameters
from spacecraft_gnc.types import Matrix3, Vector3


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantParameters(DisturbanceParameters, PlantHost):
    """Section ``plant``: the rigid body, its start, and the pace of the simulation."""

    inertia: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "inertia matrix, body frame: J_xx = integral of (y^2 + z^2) dm, "
        "J_xy = -(integral of x y dm); principal moments of 1e-12 to 1e15",
        unit="kg m^2",
        shape=(3, 3),
        matrix=MatrixRule.INERTIA,
        required=True,
        may_be_empty=True,
    )
    time_step: float = parameter(
        Kind.DOUBLE,
        1.0,
        "step of the integrator",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
        formula="nmpc_controller.time_step, where that is given; else settling_time / 80, at most "
        "J_d / (2 (J_1 omega + |Pi_0|)), and that at least settling_time / 80000, in whole ns",
    )
    duration: float = parameter(
        Kind.DOUBLE,
        3.0,
        "simulated time; a last fraction of a control period is not flown",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
        formula="3 settling_time + 2 |Pi_0| / U, the second term with a torque limit only",
    )
    initial_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "initial attitude R_0 = exp(hat(.)), body to inertial",
        unit="rad",
        shape=(3,),
        **ANGLES,
    )
    initial_momentum: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "initial angular momentum, body frame",
        unit="N m s",
        shape=(3,),
        **WITHIN,
    )
    max_torque: float = parameter(
        Kind.DOUBLE,
        0.0,
        "limit of each component of the torque that the actuators give, body frame: what a command "
        "has beyond it is cut; 0: no limit",
        unit="N m",
        minimum=0.0,
        maximum=LARGEST,
        is_neutral=True,
    )
    pose_every: int = parameter(
        Kind.INTEGER, 1, "publish a PoseStamped every n-th control step; 0: never", minimum=0
    )
