"""Parameters of ``reference_governor``: the target, the sets, their margins and the abort."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import ANGLES, LARGEST, WITHIN, Kind, parameter
from spacecraft_gnc.parameters.sections import GovernorHost
from spacecraft_gnc.types import Vector3


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class TargetParameters(GovernorHost):
    """What every law reads: where the port is to go."""

    governor: str = parameter(
        Kind.STRING,
        "periodic",
        "law that shapes the reference; none: the target is the reference",
        plugins="governors",
    )
    target_port_offset: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "port offset that is finally wanted; zero: docked",
        unit="m",
        shape=(3,),
        **WITHIN,
    )
    target_rotation_vector: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "rotation vector that is finally wanted, deputy to chief; zero: aligned",
        unit="rad",
        shape=(3,),
        **ANGLES,
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class SetParameters:
    """What the laws with admissible sets read."""

    steady_share: float = parameter(
        Kind.DOUBLE,
        0.99,
        "share of each bound that steady states may use",
        above=0.0,
        below=1.0,
    )
    rotation_weight: float = parameter(
        Kind.DOUBLE,
        100.0,
        "weight of the rotation vector in the distance of the reference to the wish, where the "
        "port offset has 1/m^2",
        unit="1/rad^2",
        above=0.0,
        maximum=LARGEST,
    )
    force_margin: float = parameter(
        Kind.DOUBLE,
        0.0,
        "by how much the limit of the force is tightened, for noise and what the linear model "
        "leaves out",
        unit="N",
        minimum=0.0,
        maximum=LARGEST,
    )
    moment_margin: float = parameter(
        Kind.DOUBLE,
        0.0,
        "likewise of the moment",
        unit="N m",
        minimum=0.0,
        maximum=LARGEST,
    )
    distance_margin: float = parameter(
        Kind.DOUBLE,
        0.0,
        "likewise of line of sight and clearance",
        unit="m",
        minimum=0.0,
        maximum=LARGEST,
    )
    aborts: bool = parameter(
        Kind.BOOL,
        True,
        "where a thruster direction is found lost, the deputy goes to the hold point",
    )
    hold_port_offset: Vector3 = parameter(
        Kind.DOUBLE_ARRAY,
        [10.0, 0.0, 0.0],
        "port offset of the hold point of an abort",
        unit="m",
        shape=(3,),
        **WITHIN,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class GovernorParameters(SetParameters, TargetParameters):
    """Section ``reference_governor``."""


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class NoLawParameters:
    """What ``governor: none`` reads: nothing beside the target."""
