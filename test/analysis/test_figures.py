"""Figures: all are drawn and written without a warning, and show what they should."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from analysis.flights import at_rest, case1, scenario, zone
from matplotlib.figure import Figure
from matplotlib.image import imread

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import sphere, style
from spacecraft_gnc.drawing.figures import FORMATS, save_figures
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.vehicles.rigid_body.pictures import motion as panels
from spacecraft_gnc.vehicles.rigid_body.pictures.figures import flight_figures

ZONES = {
    "star": zone([0.9276, 0.3736, 0.0], 4.9965),
    "antenna": zone([0.0, 0.0, 1.0], 120.0, "inclusion"),
}


@pytest.fixture(scope="module")
def drawn():
    """Return the figures of Case I with zones."""
    return dict(flight_figures(case1(), scenario(ZONES), title="Case I"))


@pytest.fixture
def axes():
    with style.applied():
        yield Figure().subplots()


def test_there_is_a_figure_for_everything(drawn):
    assert list(drawn) == [
        "overview",
        "attitude_error",
        "momentum",
        "torque",
        "sphere",
        "zones",
        "solver",
    ]


def test_figures_without_content_are_left_out():
    unsolved = at_rest(status=np.full(20, -1))
    names = [name for name, _ in flight_figures(unsolved)]
    assert names == ["overview", "attitude_error", "momentum", "torque", "sphere"]


@pytest.mark.parametrize("kind", FORMATS)
def test_files_are_written_whole(tmp_path, drawn, kind):
    files = save_figures(drawn.items(), tmp_path / "new" / "folder", [kind])
    assert [file.name for file in files] == [f"{name}.{kind}" for name in drawn]
    assert sorted((tmp_path / "new" / "folder").iterdir()) == sorted(files)  # no temporary ones
    for file in files:
        assert file.stat().st_size > 5000
    if kind == "svg":
        assert ET.parse(files[0]).getroot().tag.endswith("svg")
    if kind == "png":
        image = imread(files[0])
        assert image.shape[:2] == (1720, 2200)
        assert image[..., :3].std() > 0.05


def test_the_same_flight_gives_the_same_bytes(tmp_path):
    for folder in ("one", "two"):
        save_figures(flight_figures(at_rest()), tmp_path / folder, ["svg", "png"])
    for file in sorted((tmp_path / "one").iterdir()):
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()


def test_every_axis_has_a_unit(drawn):
    for name, figure in drawn.items():
        for panel in figure.axes:
            if panel.axison:  # the sphere has no axes
                assert "[" in panel.get_ylabel(), name
        if name != "sphere":
            assert any("time [s]" in panel.get_xlabel() for panel in figure.axes)


def test_an_unwritable_folder_is_one_line(tmp_path, drawn):
    (tmp_path / "file").touch()
    with pytest.raises(RecordingError, match=r"file: figures cannot be written \(File exists\)"):
        save_figures(drawn.items(), tmp_path / "file")


def test_a_full_disk_leaves_no_half_figure(tmp_path, drawn, monkeypatch):
    def fail(self, *args, **options):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Figure, "savefig", fail)
    with pytest.raises(RecordingError, match="No space left on device"):
        save_figures(drawn.items(), tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_settle_times_are_written_into_the_error_diagram(drawn):
    texts = [text.get_text() for text in drawn["attitude_error"].axes[0].texts]
    assert texts == ["below 5° from 55.2 s", "below 1° from 105.2 s"]


def test_the_error_may_be_drawn_linearly(axes):
    panels.attitude_error(axes, case1(), scale="linear")
    assert axes.get_yscale() == "linear"
    assert axes.texts[0].get_text() == "below 5° from 55.2 s\nbelow 1° from 105.2 s"


def test_a_flight_without_error_is_drawn_linearly(axes):
    panels.attitude_error(axes, at_rest())
    assert axes.get_yscale() == "linear"


def test_the_torque_limit_is_drawn_in_the_unit_of_the_axis(axes):
    panels.torque_norm(axes, case1(), limit=0.01)
    assert axes.get_ylabel() == "torque [mN m]"
    (limit,) = [line for line in axes.lines if line.get_label() == "limit 10 mN m"]
    assert set(limit.get_ydata()) == {10.0}


def test_solves_that_failed_are_marked(axes):
    status = np.zeros(20, dtype=np.int64)
    status[[3, 8]] = 1
    panels.iterations(axes, at_rest(status=status))
    (failed,) = [line for line in axes.lines if line.get_label() == "not converged"]
    np.testing.assert_allclose(failed.get_xdata(), [1.2, 3.2])


def test_one_slow_solve_does_not_hide_the_others(axes):
    times = np.full(20, 4e-5)
    times[0] = 0.8
    panels.solve_time(axes, at_rest(solve_time=times))
    assert axes.get_yscale() == "log"


def test_a_flight_with_lost_steps_is_drawn_with_gaps(tmp_path):
    hole = at_rest().attitude.copy()
    hole[[0, 5]] = np.nan
    lossy = replace(
        at_rest(),
        attitude=hole,
        torque=np.full((20, 3), np.nan),
        status=np.full(20, -1),
        solve_time=np.full(20, np.nan),
    )
    assert len(save_figures(flight_figures(lossy, scenario()), tmp_path)) == 5


@pytest.mark.parametrize(
    ("largest", "label", "factor"),
    [
        (0.0, "N m", 1.0),
        (20.0, "N m", 1.0),
        (0.25, "N m", 1.0),
        (0.01, "mN m", 1e3),
        (3e-5, "µN m", 1e6),
        (4000.0, "kN m", 1e-3),
        (1e-15, "nN m", 1e9),
    ],
)
def test_units_take_the_prefix_that_suits_the_numbers(largest, label, factor):
    unit = style.prefixed("N m", np.array([0.0, -largest, np.nan]))
    assert unit.label == label
    assert unit.factor == pytest.approx(factor)


def test_the_view_keeps_distances_and_depth():
    view = sphere.View(azimuth_deg=35.0, elevation_deg=24.0)
    picture, depth = view.project(np.eye(3))
    np.testing.assert_allclose((picture**2).sum(axis=1) + depth**2, np.ones(3))
    front, toward = view.project(
        np.array(
            [
                [
                    np.cos(np.radians(24)) * np.cos(np.radians(35)),
                    np.cos(np.radians(24)) * np.sin(np.radians(35)),
                    np.sin(np.radians(24)),
                ]
            ]
        )
    )
    np.testing.assert_allclose(front, [[0.0, 0.0]], atol=1e-15)
    np.testing.assert_allclose(toward, [1.0])


@pytest.mark.parametrize("half_angle_deg", [5.0, 40.0, 90.0, 130.0, 175.0])
def test_a_cap_covers_the_area_that_its_projection_has(half_angle_deg):
    """Both sides together: the area of each outline equals that of a Monte Carlo projection."""
    view, rng = sphere.View(), np.random.default_rng(0)
    points = rng.uniform(-1.0, 1.0, size=(40_000, 2))
    points = points[(points**2).sum(axis=1) < 1.0]
    height = np.sqrt(1.0 - (points**2).sum(axis=1))
    axes_seen, depths = view.project(np.eye(3))
    for axis in (np.array([0.6, 0.64, 0.48]), np.array([-0.6, 0.64, 0.48])):
        half_angle = np.radians(half_angle_deg)
        for side in (1.0, -1.0):
            world = points @ axes_seen.T + side * np.outer(height, depths)
            share = np.mean(world @ axis >= np.cos(half_angle))
            loops = sphere._cap_outline(view, axis, half_angle, side)
            assert area(loops) == pytest.approx(np.pi * share, abs=0.04)


def area(loops):
    """Return the area within closed loops, by their winding."""
    total = 0.0
    for loop in loops:
        x, y = np.append(loop, loop[:1], axis=0).T
        total += 0.5 * np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])
    return abs(total)


def test_a_governed_flight_shows_alpha_and_the_error_to_its_target():
    alpha = np.where(np.arange(20) % 2, 0.0, 0.4)
    reference = np.array([lie.exp(np.array([0.0, 0.0, angle])) for angle in np.linspace(1, 0, 20)])
    flight = at_rest(alpha=alpha, governor_margin=np.full(20, 0.01), reference=reference)
    figures = dict(flight_figures(flight, scenario()))
    assert "governor" in figures
    (error,) = figures["attitude_error"].axes
    labels = [text.get_text() for text in error.get_legend().get_texts()]
    assert labels == ["to the target", "to the governor's reference"]
    assert np.allclose(error.lines[0].get_ydata(), 0.0)
    (panel,) = figures["governor"].axes
    assert np.array_equal(panel.lines[0].get_ydata(), alpha)
    left = panel.lines[1].get_ydata()
    assert (left[0], left[-1]) == (pytest.approx(1.0), pytest.approx(0.0, abs=1e-7))
    assert "governor" not in dict(flight_figures(at_rest(), scenario()))
