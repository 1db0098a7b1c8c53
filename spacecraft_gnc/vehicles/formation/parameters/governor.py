"""Parameters of ``reference_governor``: desired formation, candidates, constraints, deadlocks."""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import LARGEST, LARGEST_WEIGHT, Kind, parameter
from spacecraft_gnc.parameters.sections import GovernorHost


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class FormationParameters(GovernorHost):
    """What every law reads: the desired formation."""

    governor: str = parameter(
        Kind.STRING,
        "time_shift",
        "law that shapes the reference; none: no shifts",
        plugins="governors",
    )
    phase: tuple[int, ...] = parameter(
        Kind.INTEGER_ARRAY,
        [16, 0, 33],
        "desired place of each craft on the natural ellipse, all different",
        unit="control steps",
        shape=(-1,),
        minimum=0,
        maximum=1_000_000,
    )
    formed_error: float = parameter(
        Kind.DOUBLE,
        10.0,
        "position error below which the craft count as formed, with all shifts equal",
        unit="m",
        above=0.0,
        maximum=LARGEST,
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class ShiftParameters:
    """What the law ``time_shift`` reads."""

    horizon: int = parameter(
        Kind.INTEGER,
        100,
        "steps over which each candidate is predicted",
        unit="control steps",
        minimum=1,
        maximum=10_000,
    )
    shift_weight: float = parameter(
        Kind.DOUBLE,
        1.0,
        "weight of the shifts' own cost, the squares of the pairs' differences, beside that of "
        "state errors and delta-v, which has the weights of nmpc_controller",
        unit="1/control steps^2",
        above=0.0,
        maximum=LARGEST_WEIGHT,
    )
    delta_v_margin: float = parameter(
        Kind.DOUBLE,
        0.0,
        "by how much the limit of the change of velocity is tightened, for what the linear model "
        "leaves out",
        unit="m/s",
        minimum=0.0,
        maximum=LARGEST,
    )
    separation_margin: float = parameter(
        Kind.DOUBLE,
        0.0,
        "likewise of the separation",
        unit="m",
        minimum=0.0,
        maximum=LARGEST,
    )
    communication_angle_margin_deg: float = parameter(
        Kind.DOUBLE,
        0.0,
        "likewise of the communication angle",
        unit="deg",
        minimum=0.0,
        maximum=180.0,
    )
    prediction_substeps: int = parameter(
        Kind.INTEGER,
        1,
        "instants of each predicted step at which separation and angle are checked; 1: its start",
        minimum=1,
        maximum=100,
    )
    resolves_deadlocks: bool = parameter(
        Kind.BOOL,
        True,
        "craft parked in a formation that is not the desired one pass to it by way of others, each "
        "passage within every constraint",
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class GovernorParameters(ShiftParameters, FormationParameters):
    """Section ``reference_governor``."""


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class NoLawParameters:
    """What ``governor: none`` reads: nothing beside the desired formation."""
