"""Flights in formation in space, as the report's 3-D view draws them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from spacecraft_gnc.drawing import craft_view
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.drawing.craft_view import Craft, Link, Motion
from spacecraft_gnc.drawing.view import Readout, View, Words
from spacecraft_gnc.vehicles.formation import flown as series
from spacecraft_gnc.vehicles.formation.events import standing, standing_name
from spacecraft_gnc.vehicles.formation.flown import KM, Flown
from spacecraft_gnc.vehicles.formation.geometry import pairs
from spacecraft_gnc.vehicles.formation.limits import all_separations
from spacecraft_gnc.vehicles.formation.summary import length

_WORDS: Final = Words(
    "Paths in 3-D",
    "Paths in Hill's frame",
    "Craft with their paths, the natural ellipse, and lines between the craft",
    "Dots: craft; circles: their starts; diamonds: {diamonds} of each; dashed: natural ellipse on "
    "which they are to form up; lines between two craft: gray where their separation and their "
    "communication angle are within the limits, red where one is not. x outward, y along the "
    "track, z along the orbit normal. Numbers are in the order of the craft, and of the pairs 12, "
    "13, ..., 23. Drag to turn, scroll to zoom.",
)
_AXES: Final = ("x radial [km]", "y along track [km]", "z normal [km]")


def view_of(runs: Sequence[Flown], points: int) -> View:
    """Return the view of flights."""
    return craft_view.scene([_motion(run) for run in runs], points, _WORDS, _AXES)


def _motion(run: Flown) -> Motion:
    return Motion(
        name=run.name,
        times=run.times,
        craft=list(_craft(run)),
        links=list(_links(run)),
        ring=KM * series.ellipse(run.scenario),
        told=_told(run),
        readout=list(_readout(run)),
    )


def _craft(run: Flown) -> Iterator[Craft]:
    flight = run.trajectory
    at, places, answers = series.positions(flight), series.held_places(run), held(flight.healthy)
    for i, name in enumerate(series.craft_names(run)):
        color = series.craft_color(i)
        yield Craft(name, color, KM * at[:, i], KM * places[:, i], answers[:, i].astype(bool))


def _links(run: Flown) -> Iterator[Link]:
    kept = series.pairs_kept(run)
    for i, (first, second) in enumerate(pairs(run.trajectory.n_craft).tolist()):
        yield Link(first, second, kept[:, i])


def _told(run: Flown) -> list[str]:
    apart, away = KM * series.nearest(run.trajectory), series.farthest(run)
    words = _standings(run)
    return [
        f"{word}, at least {least:.3g} km apart, up to {length(error)} from their places"
        for word, least, error in zip(words, apart, away, strict=True)
    ]


def _standings(run: Flown) -> list[str]:
    return [standing_name(value) for value in held(standing(run.trajectory)).tolist()]


def _readout(run: Flown) -> Iterator[Readout]:
    flight = run.trajectory
    yield Readout("separations [km]", KM * all_separations(flight))
    yield Readout("communication angles [deg]", series.angles_deg(run))
    yield Readout("off their places [m]", series.errors(run))
    yield Readout("delta-v [m/s]", series.delta_v(flight))
    yield Readout("delta-v spent [m/s]", series.spent(run))
    if series.governor_chose(flight):
        yield Readout("time shifts [steps]", series.shifts(flight), _standings(run), is_count=True)
        yield Readout("cost W", held(flight.shift_cost), _notes(run.telemetry.refused, "refused: "))
        yield Readout("cost Omega", held(flight.state_cost))
        yield Readout("admissible candidates", held(series.admissible(flight)), is_count=True)
        room = held(series.room_percent(flight))
        yield Readout("least room ahead [%]", room, _notes(run.telemetry.constraint))


def _notes(words: Sequence[str], before: str = "") -> list[str]:
    """Return notes of the states (n + 1,) from words of the steps; nothing where none are known."""
    return [before + word if word else "none" for word in (*words, *words[-1:])]
