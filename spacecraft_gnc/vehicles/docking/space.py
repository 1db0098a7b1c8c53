"""Docking flights in space, as the report's 3-D view draws them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from spacecraft_gnc.drawing import bodies_view
from spacecraft_gnc.drawing.bodies_view import Motion, Region
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.drawing.view import Readout, View, Words
from spacecraft_gnc.vehicles.docking import flown as series
from spacecraft_gnc.vehicles.docking.flown import Flown
from spacecraft_gnc.vehicles.docking.limits import clearances, margins
from spacecraft_gnc.vehicles.docking.summary import phase_name, velocities

_WORDS: Final = Words(
    "Approach in 3-D",
    "Approach in the chief frame",
    "Chief and deputy as cuboids, the line-of-sight pyramid and the path of the deputy's port",
    "Gray: chief; blue: deputy, thin at other times; dots: docking ports; line: path of the "
    "deputy's port; green: pyramid in which it has to stay; diamond: {diamonds}. Drag to turn, "
    "scroll to zoom.",
)
_FRAMES: Final = {
    "the chief frame": ("x", "y", "z"),
    "Hill's frame: the chief turns": ("x outward", "y along track", "z orbit normal"),
}


def view_of(runs: Sequence[Flown], points: int) -> View:
    """Return the view of flights."""
    return bodies_view.scene([_motion(run) for run in runs], points, _WORDS, _FRAMES)


def _motion(run: Flown) -> Motion:
    plant = None if run.scenario is None else run.scenario.plant
    port = np.zeros(3) if plant is None else plant.chief_port
    region = None
    if plant is not None:
        corners = series.sight(plant, series.reach(run))
        region = Region("line of sight", series.SIGHT_COLOR, corners)
    return Motion(
        name=run.name,
        times=run.times,
        bodies=series.bodies(run),
        trail=series.port_path(run),
        reference=port + series.reference_offset(run.trajectory),
        turn=series.chief_attitudes(run),
        told=_told(run),
        readout=list(_readout(run)),
        region=region,
        snapshots=series.snapshot_rows(run),
    )


def _told(run: Flown) -> list[str]:
    pairs = zip(series.distance(run.trajectory), series.angle_deg(run.trajectory), strict=True)
    return [f"ports {apart:.3g} m apart, {angle:.3g} degrees" for apart, angle in pairs]


def _readout(run: Flown) -> Iterator[Readout]:
    flight = run.trajectory
    phases = [phase_name(phase) for phase in held(flight.phase).tolist()]
    yield Readout("distance of the ports [m]", series.distance(flight), phases)
    yield Readout("angle [deg]", series.angle_deg(flight))
    yield Readout("port offset [m]", series.offset(flight))
    yield Readout("port velocity [m/s]", velocities(flight))
    yield Readout("force [N]", series.force(flight))
    yield Readout("moment [N m]", series.moment(flight))
    yield Readout("line-of-sight margin [m]", margins(flight))
    yield Readout("clearance [m]", clearances(flight))
    if np.isfinite(flight.slack).any():
        active = run.telemetry.active
        notes = [names or "nothing active" for names in (*active, *active[-1:])]
        yield Readout("slack [% of a row's room]", held(series.slack_percent(flight)), notes)
