"""Sections of a scenario file that are the same for every vehicle, each parameter declared once.

The sections ``plant``, ``nmpc_controller`` and ``reference_governor`` begin with what their host
reads; a vehicle adds its own. ``recorder`` and ``launcher`` know no vehicle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from spacecraft_gnc.parameters.parameter import LONGEST, Kind, NodeParameters, parameter

DEFAULT_VEHICLE: Final = "rigid_body"
NODE_NAMES: Final = ("plant", "nmpc_controller", "reference_governor", "recorder")


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantHost(NodeParameters):
    """Section ``plant``: the vehicle and the pace of the simulation.

    A vehicle adds ``time_step`` and ``duration``, whose defaults follow from it.
    """

    vehicle: str = parameter(
        Kind.STRING, DEFAULT_VEHICLE, "vehicle that is simulated", plugins="vehicles"
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


def method_named(default: str) -> Any:
    """Return the field ``method`` of a vehicle's section, with its own default."""
    return parameter(Kind.STRING, default, "method that finds the command", plugins="controllers")


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllerHost(NodeParameters):
    """Section ``nmpc_controller``: the method and its period.

    A vehicle gives ``method`` its own default, and adds what its methods share and the parameters
    of each.
    """

    method: str = method_named("")
    variant: str = parameter(Kind.STRING, "exact", "variant of the method")
    time_step: float = parameter(
        Kind.DOUBLE,
        0.0,
        "control period and prediction step, a multiple of plant.time_step; 0: plant.time_step",
        unit="s",
        minimum=0.0,
        otherwise="plant.time_step",
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class GovernorHost(NodeParameters):
    """Section ``reference_governor``: the law between the target and the reference."""

    governor: str = parameter(
        Kind.STRING,
        "none",
        "law that shapes the reference; none: the target is the reference",
        plugins="governors",
    )


@dataclass(frozen=True, kw_only=True, eq=False)
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


@dataclass(frozen=True, kw_only=True, eq=False)
class LauncherParameters:
    """Section ``launcher``: what ``gnc launch`` starts (it is no node)."""

    nodes: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        list(NODE_NAMES),
        "nodes to start; with several agents a controller or governor stands for that of each, "
        "sc1/nmpc_controller for one",
        shape=(-1,),
        unique=True,
        choices=NODE_NAMES,
        paths=True,
    )
    on_node_death: str = parameter(
        Kind.STRING,
        "stop",
        "what a dead node leads to: the run ends, or the node is restarted",
        choices=("stop", "restart"),
    )
    on_foreign_transition: str = parameter(
        Kind.STRING,
        "refuse",
        "what a transition leads to that somebody else than the launcher requests: it is refused, "
        "or the node ends the run",
        choices=("refuse", "stop"),
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


SHARED: Final[Mapping[str, type]] = {"recorder": RecorderParameters, "launcher": LauncherParameters}
"""Sections in which no vehicle has a part."""
