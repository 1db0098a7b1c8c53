"""Every parameter of every node, declared once: type, default, unit, range, description.

What carries units has a formula as its default: it follows from the inertia, the torque limit and
the wanted settling time (`defaults`). Angles are in radians unless the name ends in ``_deg``;
matrices are row-major; vectors are in the body frame unless the name says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.parameters.parameter import (
    ANGLES,
    LARGEST,
    LONGEST,
    SHORTEST,
    WITHIN,
    Kind,
    MatrixRule,
    NodeParameters,
    parameter,
)
from spacecraft_gnc.types import Matrix3, Vector3
from spacecraft_gnc.vehicles.rigid_body.parameters.controller import ControllerParameters
from spacecraft_gnc.vehicles.rigid_body.parameters.cost import WeightParameters, ZoneParameters

__all__ = [
    "NODE_NAMES",
    "SECTIONS",
    "ControllerParameters",
    "GovernorParameters",
    "LauncherParameters",
    "PlantParameters",
    "RecorderParameters",
    "WeightParameters",
    "ZoneParameters",
]

NODE_NAMES: Final = ("plant", "nmpc_controller", "reference_governor", "recorder")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlantParameters(NodeParameters):
    """Section ``plant``: the simulated vehicle and the pace of the simulation."""

    vehicle: str = parameter(
        Kind.STRING, "rigid_body", "vehicle that is simulated", plugins="plants"
    )
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
    mode: str = parameter(
        Kind.STRING,
        "lockstep",
        "lockstep: the plant waits for each torque, so nothing depends on machine speed; "
        "free_run: it steps on wall time",
        choices=("lockstep", "free_run"),
    )
    real_time_factor: float = parameter(
        Kind.DOUBLE,
        1.0,
        "simulated seconds per wall second (free_run only)",
        minimum=1.0e-6,
        maximum=1.0e6,
    )
    command_timeout: float = parameter(
        Kind.DOUBLE,
        5.0,
        "wall time that the plant waits for a torque before it falls back (lockstep only)",
        unit="s",
        above=0.0,
        maximum=LONGEST,
    )
    max_held_steps: int = parameter(
        Kind.INTEGER,
        5,
        "consecutive steps for which the last torque is held when a command is late; "
        "zero torque after that (free_run only)",
        minimum=0,
    )
    peers: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        ["nmpc_controller", "reference_governor", "recorder"],
        "nodes to wait for before step 0; the launcher sets it to the nodes it started",
        shape=(-1,),
        may_be_empty=True,
        unique=True,
    )
    pose_every: int = parameter(
        Kind.INTEGER, 1, "publish a PoseStamped every n-th control step; 0: never", minimum=0
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GovernorParameters(NodeParameters):
    """Section ``reference_governor``: the target, and how the reference gets there."""

    governor: str = parameter(
        Kind.STRING,
        "none",
        "law that shapes the reference; none: the target is the reference",
        plugins="governors",
    )
    target_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "target attitude exp(hat(.)), body to inertial",
        unit="rad",
        shape=(3,),
        **ANGLES,
    )
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
    slew_tolerance_deg: float = parameter(
        Kind.DOUBLE,
        0.1,
        "attitude error under which a slew has arrived",
        unit="deg",
        above=0.0,
        maximum=180.0,
    )
    slew_rate_tolerance: float = parameter(
        Kind.DOUBLE,
        1.0,
        "body rate under which a slew has arrived",
        unit="rad/s",
        above=0.0,
        formula="slew_tolerance_deg pi / 180 omega",
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecorderParameters(NodeParameters):
    """Section ``recorder``: what goes into the bag, and how."""

    topics: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        [],
        "topics to record, of the graph or any other; empty: all of the graph; '*': these too",
        shape=(-1,),
        may_be_empty=True,
        unique=True,
    )
    storage_folder: str = parameter(
        Kind.STRING,
        "",
        "folder of the bag; empty: the launcher chooses it, a node alone uses ./bags/<time stamp>",
    )
    compression: str = parameter(
        Kind.STRING, "zstd", "compression of the chunks", choices=("none", "zstd")
    )
    chunk_size: int = parameter(
        Kind.INTEGER,
        262144,
        "size at which a chunk is closed",
        unit="bytes",
        minimum=1024,
        maximum=1 << 30,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LauncherParameters:
    """Section ``launcher``: what ``gnc launch`` starts (it is no node)."""

    nodes: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        list(NODE_NAMES),
        "nodes to start",
        shape=(-1,),
        unique=True,
        choices=NODE_NAMES,
    )
    on_node_death: str = parameter(
        Kind.STRING,
        "stop",
        "what a dead node leads to: the run ends, or the node is restarted",
        choices=("stop", "restart"),
    )
    domain_id: int = parameter(
        Kind.INTEGER,
        -1,
        "ROS_DOMAIN_ID; -1: a free one. On Linux 0 to 101 keeps clear of the ephemeral ports",
        minimum=-1,
        maximum=232,
    )
    composed: bool = parameter(Kind.BOOL, False, "run all nodes in one process")
    cut_short: bool = parameter(
        Kind.BOOL,
        False,
        "fly although plant.duration ends before the target is in reach; gnc launch sets it in the "
        "file it saves where the duration was replaced",
    )


SECTIONS: Final[Mapping[str, type]] = {
    "plant": PlantParameters,
    "nmpc_controller": ControllerParameters,
    "reference_governor": GovernorParameters,
    "recorder": RecorderParameters,
    "launcher": LauncherParameters,
}
