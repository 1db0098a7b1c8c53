"""Figures of what was recorded beside the motion."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from analysis.flights import at_rest, case1, scenario
from matplotlib.colors import to_hex

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.figures import save_figures
from spacecraft_gnc.drawing.sources import NOT_RECORDED, stretches
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.pictures.comparison import comparison_makers
from spacecraft_gnc.vehicles.rigid_body.pictures.figures import record_makers
from spacecraft_gnc.vehicles.rigid_body.telemetry import computed

FLOWN = case1()
SOURCES = np.array([0] * 5 + [3] * 4 + [NOT_RECORDED] * 2 + [4] * 9)


@pytest.fixture(scope="module")
def drawn():
    """Return the figures of a recording in which everything happened."""
    n = FLOWN.n_steps
    telemetry = replace(
        computed(FLOWN, scenario()),
        min_curvature=np.linspace(0.7, 0.8, n),
        closed_loop_radius=np.where(np.arange(n) == 7, 1.2, np.nan),
    )
    flown = replace(FLOWN, governor_margin=np.ones(n))
    return {name: make() for name, make in record_makers(flown, telemetry, scenario()).items()}


def test_there_is_a_figure_for_everything(drawn):
    assert set(drawn) == {
        "quaternion", "roll_pitch_yaw", "rotation_vector", "sources", "invariants", "residual",
        "solve_times", "curvature", "radius", "governor_margin",
    }  # fmt: skip


def test_every_axis_has_a_unit(drawn):
    for name, figure in drawn.items():
        for axes in figure.axes:
            assert name == "sources" or axes.get_ylabel().endswith("]"), name
        assert figure.axes[-1].get_xlabel().endswith("]")


def test_figures_without_content_are_left_out():
    unsolved = at_rest(residual=np.full(20, np.nan), solve_time=np.full(20, np.nan))
    makers = record_makers(unsolved, computed(unsolved))
    assert not set(makers) & {"residual", "solve_times", "curvature", "radius", "governor_margin"}


def test_the_histogram_counts_every_solve(drawn):
    (axes,) = drawn["solve_times"].axes
    counted = sum(bar.get_height() for bar in axes.patches)
    assert counted == FLOWN.n_steps


def test_the_figures_are_written(tmp_path, drawn):
    files = save_figures(drawn.items(), tmp_path, ["svg", "png", "pdf"])
    assert len(files) == 3 * len(drawn)


def test_stretches_cover_the_flight_without_a_gap():
    flight = at_rest(source=SOURCES)
    found = stretches(SOURCES, series.state_times(flight))
    assert [(s.source, s.steps) for s in found] == [(0, 5), (3, 4), (NOT_RECORDED, 2), (4, 9)]
    assert found[0].begin == 0.0
    assert all(a.end == b.begin for a, b in itertools.pairwise(found))
    assert found[-1].end == series.state_times(flight)[-1]


def test_any_fallback_of_an_interval_hides_the_method_itself():
    own, zero = 5, 4
    found = stretches(np.array([own, own, own, zero, own, own]), np.arange(7.0), 2)
    assert [(s.source, s.steps) for s in found] == [(own, 2), (zero, 2), (own, 2)]


@pytest.mark.parametrize("width", [2, 3, 7, 100])
def test_steps_taken_together_show_their_lowest_rung(width):
    found = stretches(SOURCES, np.arange(len(SOURCES) + 1.0), width)
    assert sum(s.steps for s in found) == len(SOURCES)
    ranked = np.where(SOURCES == NOT_RECORDED, 9, SOURCES)  # it has none of the method's own
    worst = {int(ranked[k : k + width].max()) for k in range(0, len(SOURCES), width)}
    assert {9 if s.source == NOT_RECORDED else s.source for s in found} == worst


def test_the_band_has_the_colors_of_the_ladder():
    flight = at_rest(24, source=np.repeat(np.arange(6), 4))
    (axes,) = record_makers(flight, computed(flight))["sources"]().axes
    colors = [to_hex(bar.get_facecolor()).upper() for bar in axes.patches]
    assert colors == list(style.SOURCE_COLORS)


def test_flights_over_each_other_keep_their_names_and_numbers():
    runs = {"a": (FLOWN, scenario()), "b": (at_rest(), None)}
    figure = comparison_makers(runs)["attitude_error"]()
    lines = {line.get_label(): line.get_ydata() for line in figure.axes[0].lines}
    assert list(lines) == ["a", "b"]
    np.testing.assert_array_equal(lines["a"], series.settling_error_deg(FLOWN))
