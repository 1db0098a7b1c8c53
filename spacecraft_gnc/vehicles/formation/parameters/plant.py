"""Parameters of ``plant``: orbit, craft, natural trajectory, constraints and start.

Lists hold one number for each craft, in the order of ``spacecraft``, or three, craft by craft.
Vectors are in Hill's frame: x radial and outward, y along the track, z along the orbit normal.
"""

from __future__ import annotations

from dataclasses import dataclass

from spacecraft_gnc.parameters.parameter import (
    LARGEST,
    LONGEST,
    SHORTEST,
    WITHIN,
    Kind,
    parameter,
)
from spacecraft_gnc.parameters.sections import PlantHost
from spacecraft_gnc.types import Array

TRUTHS = ("hill", "two_body", "two_body_j2")
"""Motions that the plant can fly."""


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class OrbitParameters(PlantHost):
    """Craft, their orbit, and the constraints between them."""

    spacecraft: tuple[str, ...] = parameter(
        Kind.STRING_ARRAY,
        ["sc1", "sc2", "sc3"],
        "the craft, two or more: each name is the namespace of the craft's controller",
        shape=(-1,),
        unique=True,
    )
    altitude: float = parameter(
        Kind.DOUBLE,
        350.0e3,
        "height of the circular reference orbit above the equatorial radius",
        unit="m",
        minimum=100.0e3,
        maximum=1.0e9,
    )
    motion: str = parameter(
        Kind.STRING,
        "hill",
        "relative motion that is flown: the linear equations of Hill, of which the laws know, "
        "the exact one of two bodies, or that with J2",
        choices=TRUTHS,
    )
    inclination_deg: float = parameter(
        Kind.DOUBLE,
        51.6,
        "inclination of the reference orbit at the start (motion two_body_j2 only)",
        unit="deg",
        minimum=0.0,
        maximum=180.0,
    )
    argument_of_latitude_deg: float = parameter(
        Kind.DOUBLE,
        0.0,
        "argument of latitude of the reference orbit at the start, likewise",
        unit="deg",
        minimum=-360.0,
        maximum=360.0,
    )
    radial_semi_axis: float = parameter(
        Kind.DOUBLE,
        1000.0,
        "semi-axis in x of the natural ellipse on which the craft form up; in y it is twice that",
        unit="m",
        minimum=1.0,
        maximum=1.0e6,
    )
    max_delta_v: float = parameter(
        Kind.DOUBLE,
        1.0,
        "largest change of velocity in one control step (Euclidean norm)",
        unit="m/s",
        above=0.0,
        maximum=LARGEST,
    )
    saturates: bool = parameter(
        Kind.BOOL,
        True,
        "no craft changes its velocity by more than max_delta_v, in the direction asked for; "
        "false: it does what is asked for, so that what a law asks for can be compared with the "
        "limit",
    )
    min_separation: float = parameter(
        Kind.DOUBLE,
        1000.0,
        "least distance between two craft",
        unit="m",
        minimum=1e-3,
        maximum=1.0e6,
    )
    max_communication_angle_deg: float = parameter(
        Kind.DOUBLE,
        60.0,
        "largest angle of a pair, between where the other craft is and where it should be; 180: "
        "no constraint",
        unit="deg",
        above=0.0,
        maximum=180.0,
    )


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class StartParameters(OrbitParameters):
    """Start of each craft, by a natural trajectory of its own or by its state."""

    initial_phase: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [45.0, 21.0, 10.0],
        "where each craft is on its own ellipse at the start, counted along the natural motion",
        unit="control steps",
        shape=(-1,),
        may_be_empty=True,
        minimum=-1e6,
        maximum=1e6,
    )
    initial_along_track_offset: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [0.0, 0.0, 0.0],
        "by how much the center of that ellipse is shifted along the track",
        unit="m",
        shape=(-1,),
        may_be_empty=True,
        minimum=-1e7,
        maximum=1e7,
    )
    initial_amplitude: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [1.0, 1.0, 1.0],
        "its size, as a share of the nominal ellipse",
        shape=(-1,),
        may_be_empty=True,
        minimum=0.0,
        maximum=1e4,
    )
    initial_position: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "positions at the start, craft by craft, which count instead of phases, offsets and "
        "amplitudes; empty: by these",
        unit="m",
        shape=(-1, 3),
        may_be_empty=True,
        **WITHIN,
    )
    initial_velocity: Array = parameter(
        Kind.DOUBLE_ARRAY,
        [],
        "velocities at the start, likewise; given where initial_position is",
        unit="m/s",
        shape=(-1, 3),
        may_be_empty=True,
        **WITHIN,
    )
    spacecraft_lost: str = parameter(
        Kind.STRING,
        "",
        "craft that cannot change its velocity from spacecraft_lost_at on; empty: none",
    )
    spacecraft_lost_at: float = parameter(
        Kind.DOUBLE,
        0.0,
        "time from which on that craft is lost: it takes effect at the first control step that "
        "does not start before it",
        unit="s",
        minimum=0.0,
        maximum=LONGEST,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantParameters(StartParameters):
    """Section ``plant``: orbit, craft and their start, and the pace of the simulation."""

    time_step: float = parameter(
        Kind.DOUBLE,
        100.0,
        "step of the simulation, which is the control period",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
        formula="nmpc_controller.time_step, where that is given; else a fiftieth of the period of "
        "the reference orbit",
    )
    duration: float = parameter(
        Kind.DOUBLE,
        16000.0,
        "simulated time; a last fraction of a control period is not flown",
        unit="s",
        minimum=SHORTEST,
        maximum=LONGEST,
        formula="three periods of the reference orbit",
    )
