"""Animations: written whole or not at all, a frame at a time, with what each frame must show."""

from __future__ import annotations

import errno
import os
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from analysis.flights import at_rest, case1, scenario, trajectory, zone
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import moving, style
from spacecraft_gnc.drawing.spacecraft import draw_spacecraft
from spacecraft_gnc.drawing.sphere import View
from spacecraft_gnc.errors import ParameterError, RecordingError
from spacecraft_gnc.vehicles.rigid_body.pictures import animation
from spacecraft_gnc.vehicles.rigid_body.pictures._animated_run import animated_run
from spacecraft_gnc.vehicles.rigid_body.pictures._scene import Scene

SIZE = (800, 640)  # as README shows it, pixel for pixel
HALF_ANGLE = 10.0  # [deg]
# Seen from REST, where body z points along -y: the first zone is violated by its half angle; the
# second, of the body x axis, is kept.
REST = lie.exp([np.pi / 2, 0.0, 0.0])
ZONES = {
    "hit": {**zone([0.0, -1.0, 0.0], HALF_ANGLE), "body_axis": [0.0, 0.0, 1.0]},
    "kept": zone([0.0, 0.0, 1.0], HALF_ANGLE),
}


def rest(n):
    """Return a flight of n steps that stays at REST."""
    zero = np.zeros((n + 1, 3))
    return trajectory(np.tile(REST, (n + 1, 1, 1)), zero, zero[:-1])


def scene(*runs):
    with style.applied():
        return Scene(runs)


def frame(drawn, time):
    with style.applied():
        return drawn.frame(time)


@pytest.fixture(scope="module")
def resting():
    """Return a flight at rest with both zones."""
    return animated_run("rest", rest(4), scenario(ZONES), 0)


def test_a_short_flight_has_a_frame_for_each_state(tmp_path):
    path = tmp_path / "flight.gif"
    flight = at_rest(5)  # without error and torque: nothing for a logarithmic scale
    animation.save_animation({"one": (flight, None), "two": (flight, None)}, path, title="Two")
    with Image.open(path) as picture:
        assert picture.n_frames == 6
        assert picture.size == SIZE
        assert picture.info["loop"] == 0  # for ever
        assert picture.convert("RGB").getpixel((2, 2)) == (255, 255, 255)
        shown = []
        for i in range(6):
            picture.seek(i)
            picture.load()
            shown.append(picture.info["duration"])
    assert len(set(shown[:-1])) == 1
    assert shown[-1] > 10 * shown[0]  # the end can be read before it starts again
    assert list(tmp_path.iterdir()) == [path]


def test_a_long_flight_is_sampled_from_its_start_to_its_end():
    times = moving.frame_times([animated_run("one", case1(), None, 0)])
    assert len(times) == moving.FRAMES
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(150.0)
    assert max(b - a for a, b in pairwise(times)) == pytest.approx(2.0)  # 376 states in 76 frames


def test_nothing_is_left_of_a_picture_that_cannot_be_written(tmp_path, monkeypatch):
    path = tmp_path / "flight.gif"
    path.write_bytes(b"the one before")

    def fail(image, file, **options):
        file.write_bytes(b"GIF89a")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Image.Image, "save", fail)
    with pytest.raises(RecordingError, match="No space left on device"):
        animation.save_animation({"one": (rest(2), None)}, path)
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == b"the one before"


def test_more_runs_than_fit_are_refused(tmp_path):
    runs = {str(i): (rest(2), None) for i in range(4)}
    with pytest.raises(ParameterError, match="received 4 runs; required 3 at the most"):
        animation.save_animation(runs, tmp_path / "flight.gif")
    assert not list(tmp_path.iterdir())


def test_a_violated_zone_is_told_of_its_instrument_only(resting):
    assert resting.worst(2) == (pytest.approx(-HALF_ANGLE), "hit")
    of = {tuple(axis): row for axis, row in zip(resting.instruments, resting.violated, strict=True)}
    assert of[0.0, 0.0, 1.0].all()
    assert not of[1.0, 0.0, 0.0].any()


def test_a_violation_is_shown_in_red(resting):
    kept = animated_run("rest", rest(4), scenario({"kept": ZONES["kept"]}), 0)
    red = 255.0 * np.array(to_rgb(style.LIMIT_COLOR))

    def red_pixels(run):
        under_the_sphere = frame(scene(run), 1.6)[380:430]
        return int((np.abs(under_the_sphere - red).max(axis=2) < 2.0).sum())

    assert red_pixels(resting) > 50
    assert red_pixels(kept) == 0


def test_a_frame_keeps_nothing_of_the_one_before():
    drawn = scene(animated_run("case 1", case1(), None, 0))
    first, later = frame(drawn, 0.0), frame(drawn, 40.0)
    assert not np.array_equal(first, later)
    assert np.array_equal(frame(drawn, 0.0), first)


def test_a_state_that_was_lost_is_passed_over():
    flight = rest(4)
    attitude = flight.attitude.copy()
    attitude[2] = np.nan
    flight = replace(flight, attitude=attitude)
    picture = frame(scene(animated_run("lost", flight, scenario(ZONES), 0)), 0.8)
    assert picture.shape == (SIZE[1], SIZE[0], 3)


def test_the_spacecraft_is_seen_from_the_observers_side():
    toward = View(azimuth_deg=0.0, elevation_deg=0.0)  # the observer is on the x axis
    axes = Figure().subplots()
    opening = (0.1, 0.1, 0.12)
    for angle, seen in ((0.0, True), (np.pi, False)):
        draw_spacecraft(axes, toward, lie.exp([0.0, 0.0, angle]), np.array([1.0, 0.0, 0.0]))
        colors = axes.collections[-1].get_facecolor()[:, :3]
        assert bool((np.abs(colors - opening).max(axis=1) < 0.05).any()) == seen
