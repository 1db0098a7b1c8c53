"""Parameters of ``plant``: deputy, chief, start, thrusters and navigation.

Angles are in radians unless the name ends in ``_deg``; matrices are row-major; vectors are in the
chief frame unless the description says otherwise.
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
from spacecraft_gnc.plant.random_numbers import SeedParameters
from spacecraft_gnc.types import Matrix3, Vector3
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class BodyParameters(PlantHost):
    """Deputy, chief and the constraints between them."""

    mass: float = parameter(
        Kind.DOUBLE, 130.0, "mass of the deputy", unit="kg", above=0.0, maximum=LARGEST
    )
    inertia: Matrix3 = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "inertia matrix of the deputy about its center of mass, deputy frame",
        unit="kg m^2",
        shape=(3, 3),
        matrix=MatrixRule.INERTIA,
        may_be_empty=True,
        formula="that of a cuboid of deputy_size and constant density",
    )
    deputy_size: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.6, 0.6, 0.8],
        "edges of the deputy, a cuboid about its center of mass, along its axes",
        unit="m",
        shape=(3,),
        above=0.0,
        maximum=LARGEST,
    )
    deputy_port: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [-0.3, 0.0, 0.1],
        "docking port of the deputy on its surface, deputy frame",
        unit="m",
        shape=(3,),
        **WITHIN,
    )
    chief_size: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [1.04, 1.15, 1.57],
        "edges of the chief, a cuboid about its center of mass, along its axes",
        unit="m",
        shape=(3,),
        above=0.0,
        maximum=LARGEST,
    )
    chief_port: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.52, 0.0, 0.2],
        "docking port of the chief on its face +x",
        unit="m",
        shape=(3,),
        **WITHIN,
    )
    mean_motion: float = parameter(
        Kind.DOUBLE,
        0.0012,
        "mean motion of the chief on its circular orbit",
        unit="rad/s",
        minimum=1e-6,
        maximum=0.00125,
    )
    chief_spin_rate: float = parameter(
        Kind.DOUBLE,
        0.006283185307179586,
        "rate at which the chief rotates in Hill's frame; a rotation takes a whole number of "
        "control periods",
        unit="rad/s",
        minimum=0.0,
        maximum=1e3,
    )
    chief_spin_axis: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 1.0],
        "axis of that rotation, of any length, Hill's frame",
        shape=(3,),
        nonzero=True,
        **WITHIN,
    )
    chief_initial_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "attitude exp(hat(.)) of the chief at the start, chief to Hill's frame",
        unit="rad",
        shape=(3,),
        **ANGLES,
    )
    max_force: float = parameter(
        Kind.DOUBLE,
        1.0,
        "limit of each component of the force",
        unit="N",
        above=0.0,
        maximum=LARGEST,
    )
    max_moment: float = parameter(
        Kind.DOUBLE,
        0.05,
        "limit of each component of the moment",
        unit="N m",
        above=0.0,
        maximum=LARGEST,
    )
    saturates: bool = parameter(
        Kind.BOOL,
        True,
        "the thrusters give no more than their limits; false: they give what is asked for, so that "
        "what a law asks for can be compared with the limits",
    )
    line_of_sight_half_angle_deg: float = parameter(
        Kind.DOUBLE,
        30.0,
        "half angle of the pyramid about +x, with its apex at the chief's port, in which the "
        "deputy's port has to stay",
        unit="deg",
        above=0.0,
        below=90.0,
    )
    line_of_sight_slack: float = parameter(
        Kind.DOUBLE,
        0.05,
        "by how much the pyramid is wider on each side",
        unit="m",
        minimum=0.0,
        maximum=LARGEST,
    )
    clearance_tolerance: float = parameter(
        Kind.DOUBLE,
        0.02,
        "by how much a vertex of the deputy may pass the plane of the docking face, on which four "
        "of them lie when docked",
        unit="m",
        minimum=0.0,
        maximum=LARGEST,
    )
    two_body: bool = parameter(
        Kind.BOOL,
        True,
        "relative gravity is the exact difference of two attractions; false: linear, of Clohessy "
        "and Wiltshire",
    )
    gravity_gradient: bool = parameter(Kind.BOOL, False, "the gravity gradient turns the deputy")


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class EquipmentParameters(SeedParameters):
    """What fails of the thrusters, and how well navigation measures."""

    thruster_lost: str = parameter(
        Kind.STRING,
        "",
        "direction of the deputy frame in which no force can be given from thruster_lost_at on; "
        "empty: none",
        choices=("", *DIRECTIONS),
    )
    thruster_lost_at: float = parameter(
        Kind.DOUBLE,
        0.0,
        "time from which on that direction is lost",
        unit="s",
        minimum=0.0,
        maximum=LONGEST,
    )
    position_noise: float = parameter(
        Kind.DOUBLE,
        0.0,
        "standard deviation of each component of the port offset that navigation tells, white",
        unit="m",
        minimum=0.0,
        maximum=LARGEST,
    )
    velocity_noise: float = parameter(
        Kind.DOUBLE,
        0.0,
        "likewise of the port velocity",
        unit="m/s",
        minimum=0.0,
        maximum=LARGEST,
    )
    attitude_noise: float = parameter(
        Kind.DOUBLE,
        0.0,
        "likewise of the rotation vector of the attitude error",
        unit="rad",
        minimum=0.0,
        maximum=3.0,
    )
    rate_noise: float = parameter(
        Kind.DOUBLE,
        0.0,
        "likewise of the relative angular velocity",
        unit="rad/s",
        minimum=0.0,
        maximum=LARGEST,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantParameters(EquipmentParameters, BodyParameters):
    """Section ``plant``: deputy and chief, their start, and the pace of the simulation."""

    time_step: float = parameter(
        Kind.DOUBLE,
        0.25,
        "step of the integrator, on which the constraints are checked",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
    )
    duration: float = parameter(
        Kind.DOUBLE,
        600.0,
        "simulated time; a last fraction of a control period is not flown",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
    )
    initial_port_offset: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [20.0, 4.0, -3.0],
        "port offset at the start: deputy port minus chief port",
        unit="m",
        shape=(3,),
        **WITHIN,
    )
    initial_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "attitude exp(hat(.)) at the start, deputy to chief",
        unit="rad",
        shape=(3,),
        **ANGLES,
    )
    initial_port_velocity: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "rate of change of the port offset at the start, seen in the chief frame",
        unit="m/s",
        shape=(3,),
        **WITHIN,
    )
    initial_angular_velocity: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "angular velocity of the deputy relative to the chief at the start",
        unit="rad/s",
        shape=(3,),
        **WITHIN,
    )
    pose_every: int = parameter(
        Kind.INTEGER, 1, "publish a PoseStamped every n-th control step; 0: never", minimum=0
    )
