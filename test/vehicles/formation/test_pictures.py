"""Figures of flights in formation, and what they are drawn from."""

from __future__ import annotations

import math

import numpy as np
import pytest
from formation_flights import (
    NATURAL,
    OFFSETS,
    PERIOD,
    PHASES,
    deadlocked,
    flight,
    lost,
    missing,
    run,
    scenario,
)

from spacecraft_gnc.drawing import style
from spacecraft_gnc.vehicles.formation import events, flown
from spacecraft_gnc.vehicles.formation.animation import Scene, _news, reach
from spacecraft_gnc.vehicles.formation.pictures import FIGURES

NAMES = {"overview", "constraints", "paths", "error", "shifts", "governor"}
DECAY = np.exp(-np.arange(101) / 10.0)


def lines_of(axes):
    return {line.get_label(): line for line in axes.lines}


def test_places_go_on_along_the_natural_motion_after_the_last_step():
    places = flown.places(run())
    expected = NATURAL[(100 + np.array(PHASES) + 7) % 50, :3]
    np.testing.assert_allclose(places[-1], expected, rtol=0.0, atol=1e-6)
    assert np.isnan(flown.places(run(known=None))[-1]).all()
    np.testing.assert_allclose(flown.errors(run()), np.outer(DECAY, np.abs(OFFSETS)), rtol=1e-5)


def test_the_ellipse_is_closed_and_two_to_one():
    ring = flown.ellipse(scenario())
    np.testing.assert_array_equal(ring[0], ring[-1])
    np.testing.assert_allclose(np.abs(ring).max(axis=0), [1000.0, 2000.0, 0.0], rtol=1e-12)
    assert flown.ellipse(None).shape == (0, 3)


def test_delta_v_is_summed_up_within_the_limit_of_the_plant():
    spent = flown.spent(run())
    np.testing.assert_array_equal(spent[0], np.zeros(3))
    np.testing.assert_allclose(spent[-1], 0.8 * DECAY[:100].sum(), rtol=1e-12)
    cut = scenario(plant={"max_delta_v": 0.5})
    np.testing.assert_allclose(flown.spent(run(known=cut))[2, 0], 1.0, rtol=1e-12)
    asked = scenario(plant={"max_delta_v": 0.5, "saturates": False})
    np.testing.assert_allclose(flown.spent(run(known=asked))[1, 0], 0.8, rtol=1e-12)


def test_a_lost_craft_gives_no_delta_v_no_angle_and_no_place():
    shown = run(flown=lost())
    assert np.isnan(flown.delta_v(shown.trajectory)[40:, 1]).all()
    assert np.isfinite(flown.delta_v(shown.trajectory)[:, [0, 2]]).all()
    angles = flown.angles_deg(shown)
    assert np.isnan(angles[40:, [0, 2]]).all()
    assert np.isfinite(angles[:, 1]).all()
    places = flown.held_places(shown)
    assert np.isfinite(places[:43]).all()
    assert np.isnan(places[43:, 1]).all()
    np.testing.assert_allclose(flown.farthest(shown)[50], OFFSETS[0] * DECAY[50], rtol=1e-9)


def test_a_pair_is_kept_where_neither_of_its_constraints_is_broken():
    kept = flown.pairs_kept(run())
    apart, angle = flown.all_separations(flight()), flown.angles_deg(run())
    np.testing.assert_array_equal(kept, (apart >= 1000.0) & (angle <= 60.0))
    assert not kept[0].all()
    assert kept[-1].all()
    free = scenario(plant={"max_communication_angle_deg": 180.0})
    np.testing.assert_array_equal(flown.pairs_kept(run(known=free)), apart >= 1000.0)
    assert flown.pairs_kept(run(known=None)).all()


def test_events_tell_losses_and_when_it_was_formed():
    told = [(e.time, e.text, e.is_bad) for e in events.events(run(flown=lost()))]
    assert told == [
        (40 * PERIOD, "sc2 lost", True),
        (43 * PERIOD, "sc2 found lost", False),
        (64 * PERIOD, "formed, step 64", False),
    ]
    wrong = np.zeros((100, 3), dtype=bool)
    wrong[50:, 2] = True
    status = np.zeros(100, dtype=int)
    status[[4, 5, 9]] = 1
    found = events.events(run(flown=flight(lost=wrong, status=status)))
    assert [e.text for e in found] == [
        "no admissible shifts", "no admissible shifts", "false alarm sc3", "formed, step 64"
    ]  # fmt: skip
    assert events.events(run(known=None)) == []


def test_deadlocks_and_passages_are_stretches_of_time():
    told = [(s.begin, s.end, s.text) for s in events.spans(run(flown=deadlocked()))]
    assert told == [
        (35 * PERIOD, 50 * PERIOD, "deadlock"), (50 * PERIOD, 55 * PERIOD, "passage 1"),
        (55 * PERIOD, 60 * PERIOD, "passage 2"),
    ]  # fmt: skip
    standing = events.standing(deadlocked())
    assert [int(standing[k]) for k in (0, 35, 55, 65, 80)] == [0, 1, 2, 0, 3]
    assert events.standing(missing(flight(), 80))[80] == -1


@pytest.mark.parametrize(
    "shown",
    [
        run(flown=flight(n_craft=2)),
        run(flown=lost()),
        run(flown=missing(deadlocked(), 20), known=None),
    ],
    ids=["two", "lost", "missing"],
)
def test_every_figure_is_drawn(shown):
    makers = FIGURES.flight(shown, title="formation")
    assert set(makers) == NAMES
    for name in NAMES - {"constraints", "error"}:  # whose diagrams the overview has
        makers[name]().draw_without_rendering()


def test_the_constraints_are_drawn_with_their_limits_and_what_happened():
    shown = run(flown=lost())
    separation, delta_v, angle = FIGURES.flight(shown)["constraints"]().axes
    np.testing.assert_allclose(
        lines_of(separation)["sc1-sc3"].get_ydata()[:100], 1e-3 * lost().separation[:, 1]
    )
    assert lines_of(delta_v)["sc2"].get_drawstyle() == "steps-post"
    for axes, side in ((separation, 1.0), (delta_v, 1.0), (angle, 60.0)):
        limits = {
            line.get_ydata()[0] for line in axes.lines if line.get_color() == style.LIMIT_COLOR
        }
        assert side in limits
        assert {"sc2 lost", "sc2 found lost", "formed, step 64"} <= {
            text.get_text() for text in axes.texts
        }
    assert "at least 1 km" in {text.get_text() for text in separation.texts}
    assert {line.get_label() for line in separation.lines}.isdisjoint({"sc1", "sc2"})


def test_the_paths_run_along_the_track_and_outward():
    whole, close = FIGURES.flight(run())["paths"]().axes
    path = lines_of(whole)["sc1"]
    np.testing.assert_allclose(path.get_xdata()[:-1], 1e-3 * flight().position[:, 0, 1])
    np.testing.assert_allclose(path.get_ydata()[:-1], 1e-3 * flight().position[:, 0, 0])
    assert close.get_xlim() == pytest.approx((-2.9, 2.9))
    assert len(FIGURES.flight(run(known=None))["paths"]().axes) == 1
    crossed = FIGURES.flight(run(flown=lost()))["paths"]().axes[0]
    assert "sc2 lost" in {text.get_text() for text in crossed.texts}


def test_an_ungoverned_flight_has_no_figures_of_a_governor():
    nothing = np.full(100, math.nan)
    plain = flight(cost=nothing, lost=np.zeros((100, 0), dtype=bool))
    makers = FIGURES.flight(run(flown=plain))
    assert set(makers) == NAMES - {"shifts", "governor"}
    makers["overview"]().draw_without_rendering()


def test_flights_are_compared():
    runs = [run("three", flight()), run("two", flight(60, 2)), run("lost", lost())]
    makers = FIGURES.comparison(runs)
    assert set(makers) == {"comparison_error", "comparison_constraints"}
    separation, delta_v, _ = makers["comparison_constraints"]().axes
    (three, two, _) = separation.lines[:3]
    np.testing.assert_allclose(three.get_ydata()[:-1], 1e-3 * flight().separation.min(axis=1))
    assert len(two.get_xdata()) == 61
    assert 1.0 in {line.get_ydata()[0] for line in delta_v.lines}
    (key,) = makers["comparison_error"]().legends
    assert [text.get_text() for text in key.get_texts()] == ["three", "two", "lost"]


def test_the_moving_picture_shows_every_craft_that_is_not_lost():
    low, high = reach([run()])
    positions = 1e-3 * flown.positions(flight())
    assert (low <= positions.min(axis=(0, 1))).all()
    assert (high >= positions.max(axis=(0, 1))).all()
    gone = flight().position.copy()
    gone[60:, 1] += 1e6
    away = lost().lost
    _, high = reach([run(flown=flight(position=gone, lost=away))])
    assert high.max() < 10.0
    with style.applied():
        scene = Scene([run(flown=missing(lost(), 20)), run(known=None)])
        pictures = [scene.frame(PERIOD * k) for k in (0, 20, 60)]
    assert pictures[0].shape == (640, 800, 3)
    assert (pictures[0] != pictures[2]).any()


def test_the_moving_picture_tells_what_is_broken_or_happened_last():
    assert [_news(run(flown=deadlocked()), row) for row in (0, 20, 40, 55, 100)] == [
        "too close, angle too large", "", f"{35 * PERIOD:.0f} s: deadlock",
        f"{50 * PERIOD:.0f} s: passage", f"{64 * PERIOD:.0f} s: formed, step 64",
    ]  # fmt: skip
    fast = flight().delta_v.copy()
    fast[30, 0] = [1.1, 0.0, 0.0]
    assert _news(run(flown=flight(delta_v=fast)), 30) == "delta-v too large"
    assert _news(run(known=None), 0) == ""
