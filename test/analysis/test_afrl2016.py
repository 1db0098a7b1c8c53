"""The two wheels of the AFRL report: its laws, its region of attraction, its figures, its parts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc.campaign.results import Campaign
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.drawing.figures import save_figures
from spacecraft_gnc.errors import ParameterError, RecordingError
from spacecraft_gnc.studies import PARTS, afrl2016_laws, reproduce
from spacecraft_gnc.studies import afrl2016_two_wheel_figures as pictures
from spacecraft_gnc.studies.afrl2016_laws import Circle, Plane
from spacecraft_gnc.studies.afrl2016_region import Region, region_of
from spacecraft_gnc.studies.afrl2016_solves import Comparison
from spacecraft_gnc.studies.campaigns import flown_campaign
from spacecraft_gnc.studies.flights import quiet
from spacecraft_gnc.studies.options import Options


def made_circle(n=24, hole=True):
    """A law with a jump at 90 deg; a plan is missing from 60 deg on, if there is a hole."""
    angle = np.arange(n) * (2.0 * np.pi / n)
    law = np.where(np.cos(angle) < 0.0, 5.0, -5.0) * np.abs(np.sin(angle))
    cost = 1.0 + np.sin(angle) ** 2
    missing = hole & (np.abs(np.abs(np.sin(angle)) - 1.0) < 0.2)
    return Circle(0.5, angle, np.where(missing, np.nan, law), np.where(missing, np.nan, cost))


def made_region(n=300):
    random = np.random.default_rng(4)
    euler = random.uniform(-np.pi, np.pi, (n, 3))
    settled = np.where(np.arange(n) % 20 == 7, np.nan, random.uniform(300.0, 900.0, n))
    return Region(euler, settled, random.uniform(0.0, 0.5, n), ["passed"] * n)


def refusal(*arguments, capsys):
    """Run ``gnc reproduce`` with arguments that it refuses; return its one line."""
    with pytest.raises(SystemExit) as ended:
        main(["reproduce", *map(str, arguments)])
    captured = capsys.readouterr()
    assert ended.value.code == 2
    assert captured.out == ""
    (line,) = captured.err.splitlines()
    return line


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["gupta2015", "--only", "two_wheel"], ["gupta2015, which has no parts", "leave --only"]),
        (["--only", "two_wheel"], ["without a paper", "afrl2016"]),
        (["afrl2016", "--only", "two_wheels"], ["did you mean two_wheel?"]),
        (["afrl2016", "--only", "x"], ["required a part of afrl2016: two_wheel", "choose one"]),
    ],
)
def test_a_part_that_there_is_not_is_refused(arguments, words, tmp_path, capsys):
    line = refusal(*arguments, "--out", tmp_path, capsys=capsys)
    assert line.startswith("error: --only: received ")
    assert all(word in line for word in words)
    assert list(tmp_path.iterdir()) == []


def test_a_part_is_refused_by_the_function_too():
    with pytest.raises(ParameterError, match="has no parts"):
        reproduce("kalabic2014", Options(only="two_wheel"))


def test_each_part_has_a_module_and_its_figures():
    import importlib

    for paper, parts in PARTS.items():
        for part in parts:
            module = importlib.import_module(f"spacecraft_gnc.studies.{paper}_{part}")
            assert f"{paper}_{part}" == module.NAME
            assert callable(importlib.import_module(f"{module.__name__}_figures").figures)


def test_the_law_jumps_across_zero_roll():
    before, behind = afrl2016_laws.jump(afrl2016_laws.solver_of(), 0.25)
    assert (before, behind) == pytest.approx((5.0, -5.0), abs=1e-6)


def test_the_law_over_a_circle_is_odd_in_roll_and_even_in_yaw():
    found = afrl2016_laws.circle(afrl2016_laws.solver_of(), 0.25, 12, quiet)
    assert found.infeasible == 0
    assert afrl2016_laws.asymmetry(found) < 1e-6
    law = np.delete(found.acceleration, [3, 9])  # where it jumps
    mirrored = np.delete(found.acceleration[(6 - np.arange(12)) % 12], [3, 9])
    np.testing.assert_allclose(law, -mirrored, atol=1e-4)


def test_the_plane_holds_the_values_of_single_solves():
    solver = afrl2016_laws.solver_of()
    found = afrl2016_laws.plane(solver, 0.3, 2, quiet)
    assert found.roll == pytest.approx([-0.225, -0.075, 0.075, 0.225])
    for row, column in ((0, 3), (2, 1), (1, 0)):
        point = np.array([found.roll[column], found.yaw[row]])
        single = afrl2016_laws.solve(solver, point)
        assert found.acceleration[row, column] == pytest.approx(
            single.accelerations[0, 0], abs=1e-4
        )
        assert found.cost[row, column] == pytest.approx(single.cost, rel=1e-6)


def test_asymmetry_tells_another_cost_and_a_lost_plan():
    circle = made_circle()
    assert afrl2016_laws.asymmetry(circle) < 1e-12
    cost = circle.cost.copy()
    cost[1] *= 1.01
    assert afrl2016_laws.asymmetry(circle._replace(cost=cost)) == pytest.approx(0.01, rel=0.02)
    cost[1] = np.nan
    assert math.isnan(afrl2016_laws.asymmetry(circle._replace(cost=cost)))


def test_no_largest_yaw_is_told_where_the_bounds_do_not_hold_it():
    assert math.isnan(afrl2016_laws.largest_yaw(30, 0.1, 0.2))
    assert math.isnan(afrl2016_laws.largest_yaw(30, 0.6, 0.7))


def test_a_region_knows_what_converges():
    region = made_region()
    assert int(region.converged.sum()) == 285
    assert region.share == pytest.approx(0.95)
    assert np.abs(region.of(region.near).euler).max() <= 1.0
    assert region.of(~region.converged).share == 0.0
    assert math.isnan(region.of(np.zeros(300, bool)).share)
    half = Region(np.array([[0.0, 0.0, np.pi / 2]]), np.ones(1), np.ones(1), ["passed"])
    assert half.angle_deg == pytest.approx([90.0])


def test_the_excess_is_of_problems_that_both_solve():
    found = Comparison(
        np.array([1.0, 2.0, 1.0]),
        np.array([4.0, 6.0, 9.0]),
        np.array([1.25, np.nan, 2.0]),
        np.array([1.0, 3.0, 1.0]),
        np.array([0.5, 0.0, 0.25]),
    )
    assert found.speed_up == 4.0
    np.testing.assert_array_equal(found.excess, [0.0, np.nan, 0.75])


def test_the_figures_of_laws_and_region_are_drawn(tmp_path):
    circle, n = made_circle(72), 12
    angles = (np.arange(2 * n) + 0.5) * (0.5 / n) - 0.5
    law = 5.0 * np.sign(-angles) * np.ones((2 * n, 1))
    law[:3] = law[-3:] = np.nan
    plane = Plane(angles, angles, law, np.abs(law))
    drawn = {
        "circle": pictures.circle_figure((circle, circle)),
        "plane": pictures.plane_figure(plane),
        "region": pictures.region_figure(made_region()),
    }
    first, _ = drawn["circle"].axes
    values = first.lines[0].get_ydata()
    steps = np.abs(np.diff(values[np.isfinite(values)]))
    assert steps.max() > 5.0  # the law jumps ...
    assert np.nanmax(np.abs(np.diff(values))) < 2.0  # ... and no line joins the two sides
    spans = [patch for patch in first.patches if patch.get_width() < 90.0]
    assert len(spans) == circle.infeasible > 0
    for path in save_figures(drawn.items(), tmp_path):
        assert path.stat().st_size > 40_000


CAMPAIGN = """\
runs: 6
vary:
  plant.initial_euler_321: {distribution: uniform, from: -1.0, to: 1.0}
  plant.duration: {distribution: constant, value: 2000.0}
pass: settle_time <= 1000
"""


def test_a_campaign_is_flown_once_and_read_again(tmp_path):
    variations, told = tmp_path / "variations.yaml", []
    variations.write_text(CAMPAIGN, encoding="utf-8")
    arguments = ("three_wheel_slew", str(variations), tmp_path / "campaign", 4)
    flown = flown_campaign(*arguments, lambda *step: told.append(step))
    assert told[-1][0] == "campaign"
    assert Campaign.open(tmp_path / "campaign").is_complete
    region = region_of(flown)
    assert region.euler.shape == (4, 3)
    assert region.near.all()
    assert region.converged.all()
    assert np.nanmax(region.settled_at) <= 2000.0

    told.clear()
    again = region_of(flown_campaign(*arguments, lambda *step: told.append(step)))
    assert told == []
    np.testing.assert_array_equal(again.settled_at, region.settled_at)
    with pytest.raises(RecordingError, match="runs 4 instead of 6"):
        flown_campaign(*arguments[:3], None, quiet)
