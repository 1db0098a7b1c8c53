"""Figures, moving picture and geometry of docking flights."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from docked import START, TURNED, aborted, flight, run, scenario
from matplotlib.colors import to_rgb

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import solids, style
from spacecraft_gnc.drawing.sphere import View
from spacecraft_gnc.vehicles.docking import flown as series
from spacecraft_gnc.vehicles.docking.animation import Scene, _news
from spacecraft_gnc.vehicles.docking.geometry import Cuboid, clearance, line_of_sight_margin
from spacecraft_gnc.vehicles.docking.pictures import FIGURES

NAMES = {
    "overview", "offset", "attitude", "wrench", "reference", "constraints", "governor", "approach",
    "snapshots",
}  # fmt: skip


def lines_of(axes):
    return {line.get_label(): line for line in axes.lines}


def test_faces_look_outward_and_share_the_corners():
    for face, (axis, sign) in zip(
        solids.FACES, [(i, s) for i in range(3) for s in (-1.0, 1.0)], strict=True
    ):
        corners = solids.CORNERS[list(face)]
        assert (corners[:, axis] == sign).all()
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[1])
        np.testing.assert_array_equal(normal, 4.0 * sign * np.eye(3)[axis])
    assert len(solids.EDGES) == 12
    lengths = [np.abs(solids.CORNERS[a] - solids.CORNERS[b]).sum() for a, b in solids.EDGES]
    assert lengths == [2.0] * 12


@pytest.mark.parametrize("seed", range(5))
def test_the_outline_holds_every_corner_and_has_no_other_points(seed):
    rng = np.random.default_rng(seed)
    corners = solids.cuboid(
        rng.uniform(0.5, 2.0, 3), rng.normal(size=3), lie.exp(rng.normal(size=3))
    )
    shape = solids.outline(corners, (0, 2))
    np.testing.assert_array_equal(shape[0], shape[-1])
    flat = {tuple(point) for point in corners[:, [0, 2]]}
    assert {tuple(point) for point in shape} <= flat
    for (ax, ay), (bx, by) in pairwise(shape):
        sides = [(bx - ax) * (y - ay) - (by - ay) * (x - ax) for x, y in flat]
        assert min(sides) > -1e-12  # every corner lies to the left of every side


def test_the_drawn_bodies_meet_at_their_ports_when_docked():
    shown = run(flown=flight())
    chief, deputy = series.bodies(shown)
    np.testing.assert_allclose(chief.port_at(0), [0.52, 0.0, 0.2])
    np.testing.assert_allclose(deputy.port_at(-1), chief.port_at(-1), atol=1e-15)
    np.testing.assert_allclose(deputy.port_at(0) - chief.port_at(0), START, rtol=1e-13)
    np.testing.assert_array_equal(series.port_path(shown)[0], deputy.port_at(0))


def test_drawn_corners_and_pyramid_are_those_of_the_constraints():
    """The clearance is the x of the nearest drawn corner; the pyramid is where the margin is 0."""
    shown, plant = run(flown=flight()), scenario().plant
    deputy_box, chief_box = (
        Cuboid(plant.deputy_size, plant.deputy_port), Cuboid(plant.chief_size, plant.chief_port)
    )  # fmt: skip
    nearest = series.bodies(shown)[1].corners(0)[:, 0].min() - 0.52
    assert nearest == pytest.approx(
        float(clearance(START, lie.exp(TURNED), deputy_box, chief_box)), abs=1e-12
    )
    offsets = series.sight(plant, 7.0) - plant.chief_port
    tangent = math.tan(math.radians(30.0))
    np.testing.assert_allclose(line_of_sight_margin(offsets, tangent, 0.05), 0.0, atol=1e-14)
    assert set(np.round(offsets[:, 0], 12)) == {0.0, 7.0}


def test_events_of_one_time_are_told_together():
    told = [(event.time, event.text, event.is_bad) for event in series.events(aborted())]
    assert told == [
        (100.0, "+x lost", True), (110.0, "noticed, aborting", False), (235.0, "holding", False)
    ]  # fmt: skip
    status = np.zeros(60, dtype=int)
    status[[4, 5, 9]] = 1
    found = series.events(flight(status=status))
    assert [(event.time, event.text) for event in found] == [
        (20.0, "no admissible reference"), (45.0, "no admissible reference")
    ]  # fmt: skip
    assert series.events(flight()) == []


def test_snapshots_are_every_150_seconds_and_the_end():
    assert series.snapshot_rows(run(flown=flight())) == [0, 30, 60]
    assert series.snapshot_rows(run(flown=flight(70))) == [0, 30, 60, 70]


def test_the_chief_turns_in_hills_frame():
    axis, start = np.array([0.6, 0.0, 0.8]), np.array([0.3, -0.2, 0.1])
    tilted = {"chief_spin_axis": axis.tolist(), "chief_initial_rotation_vector": start.tolist()}
    turn = series.chief_attitudes(run(flown=flight(), known=scenario(plant=tilted)))
    rate = 2.0 * math.pi / 1000.0
    for row in (0, 7, 60):
        expected = lie.exp(axis * rate * 5.0 * row) @ lie.exp(start)
        np.testing.assert_allclose(turn[row], expected, atol=1e-14)


def test_every_figure_is_drawn():
    makers = FIGURES.flight(run(flown=aborted()), title="abort")
    assert set(makers) == NAMES
    figures = {name: make() for name, make in makers.items() if name != "overview"}
    for figure in figures.values():
        figure.draw_without_rendering()
    force = figures["wrench"].axes[0]
    np.testing.assert_array_equal(lines_of(force)["x"].get_ydata()[:-1], aborted().force[:, 0])
    assert lines_of(force)["x"].get_drawstyle() == "steps-post"
    limits = [line.get_ydata()[0] for line in force.lines if line.get_color() == style.LIMIT_COLOR]
    assert {-1.0, 1.0} <= set(limits)
    asked = figures["reference"].axes[0].lines[1]
    np.testing.assert_array_equal(asked.get_ydata()[:-1], aborted().reference[:, 0])
    assert len(figures["snapshots"].axes) == 4
    assert [text.get_text() for text in force.texts] == ["+x lost", "noticed, aborting", "holding"]


def test_without_a_scenario_what_is_known_is_drawn():
    makers = FIGURES.flight(run(flown=flight(), known=None))
    assert set(makers) == NAMES - {"snapshots"}
    makers["approach"]().draw_without_rendering()
    without = flight(residual=np.full(60, math.nan))
    assert "governor" not in FIGURES.flight(run(flown=without))


def test_flights_are_compared():
    runs = [run("governed", flight()), run("aborted", aborted())]
    makers = FIGURES.comparison(runs)
    assert set(makers) == {"comparison_error", "comparison_wrench", "comparison_constraints"}
    clear = makers["comparison_constraints"]().axes[1]
    assert {0.0, -0.02} & {line.get_ydata()[0] for line in clear.lines} == {-0.02}
    (key,) = makers["comparison_error"]().legends
    assert [text.get_text() for text in key.get_texts()] == ["governed", "aborted"]


def test_the_moving_picture_shows_both_bodies_closer_the_closer_they_are():
    colors = [np.array(to_rgb(color)) for color in (series.CHIEF_COLOR, series.DEPUTY_COLOR)]
    with style.applied():
        scene = Scene([run(flown=flight())])
        pictures = [scene.frame(time)[:380].astype(float) / 255.0 for time in (0.0, 150.0, 300.0)]
    for color in colors:
        shades = color / np.linalg.norm(color)
        areas = [
            int(((picture @ shades) / np.linalg.norm(picture, axis=2).clip(1e-9) > 0.9999)[
                picture.sum(axis=2) < 2.6].sum())
            for picture in pictures
        ]  # fmt: skip
        assert 0 < areas[0] < areas[1] < areas[2]


def test_the_moving_picture_tells_what_is_broken_or_happened_last():
    margin, clear = flight().line_of_sight_margin.copy(), flight().clearance.copy()
    margin[10:20], clear[15:20] = -0.1, -0.03
    shown = run(flown=flight(line_of_sight_margin=margin, clearance=clear))
    assert [_news(shown, row) for row in (9, 10, 15, 20)] == [
        "", "out of the line of sight", "out of the line of sight, beyond the docking face", "",
    ]  # fmt: skip
    lost = run(flown=aborted())
    assert [_news(lost, row) for row in (19, 20, 60)] == ["", "100 s: +x lost", "235 s: holding"]


def test_a_state_that_was_not_recorded_is_said():
    offset = flight().port_offset.copy()
    offset[30] = math.nan
    shown = run(flown=flight(port_offset=offset))
    assert not series.bodies(shown)[1].is_known(30)
    with style.applied():
        Scene([shown]).frame(150.0)
    FIGURES.flight(shown)["snapshots"]().draw_without_rendering()


def test_the_nearer_body_covers_the_other():
    from matplotlib.figure import Figure

    axes = Figure().subplots()
    cubes = [solids.cuboid(np.ones(3), np.array([x, 0.0, 0.0]), np.eye(3)) for x in (4.0, 0.0)]
    solids.draw_bodies(axes, View(0.0, 0.0), [(cubes[0], "red"), (cubes[1], "blue")])
    first, last = sorted(axes.collections, key=lambda drawn: drawn.get_zorder())
    assert first.get_facecolor()[0][2] > 0.9  # blue is behind
    assert last.get_facecolor()[0][0] > 0.9
    assert len(last.get_paths()) == 1  # face on, one face of six is seen
