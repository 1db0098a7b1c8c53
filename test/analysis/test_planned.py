"""Planned flights: what is measured of them, and what their figures and reports show."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from analysis.flights import at_rest

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.governors.planned.report import Phase
from spacecraft_gnc.scenario import load
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.metrics.rows import summary_rows
from spacecraft_gnc.vehicles.rigid_body.pictures.figures import flight_makers, record_makers
from spacecraft_gnc.vehicles.rigid_body.planner import series as plan_series
from spacecraft_gnc.vehicles.rigid_body.planner.recorded import RecordedPlan, as_flown
from spacecraft_gnc.vehicles.rigid_body.report import REPORT
from spacecraft_gnc.vehicles.rigid_body.telemetry import computed

COST = 20965.95496  # [N^2 m^2] of figure 4
OTHER_BODY = (
    "nmpc_controller.inertia=[800.0, 0.0, 0.0, 0.0, 1200.0, 0.0, 0.0, 0.0, 1000.0]",
    "plant.inertia=[880.0, 0.0, 0.0, 0.0, 1320.0, 0.0, 0.0, 0.0, 900.0]",
    "nmpc_controller.plan.replan_error_deg=0.5",
    "nmpc_controller.plan.torque_reserve=0.1",
    "nmpc_controller.plan.momentum_reserve=0.2",
    "nmpc_controller.plan.duration=23.0",
    "plant.duration=30.0",
)
"""A body that is another than believed, so that the flight needs further plans."""


@pytest.fixture(scope="module")
def scenario():
    return load("phogat_figure4")


@pytest.fixture(scope="module")
def flight(scenario):
    return scenario.build().run()


@pytest.fixture(scope="module")
def other():
    return load("phogat_figure4", OTHER_BODY)


@pytest.fixture(scope="module")
def replanned(other):
    return other.build().run()


def run_of(flight, scenario, plans=(), name="run"):
    """Return a run as figures and reports take it."""
    return SimpleNamespace(
        name=name,
        times=series.state_times(flight),
        trajectory=flight,
        scenario=scenario,
        telemetry=replace(computed(flight, scenario), plans=plans),
        metrics=summarize(flight, scenario) | {"missed_deadlines": None},
    )


def _recorded(n=5, first_step=2):
    rng = np.random.default_rng(3)
    return RecordedPlan(
        number=0,
        first_step=first_step,
        cause=0,
        cost=1.0,
        torque=rng.normal(size=(n, 3)),
        momentum=rng.normal(size=(n + 1, 3)),
        co_momentum=rng.normal(size=(n, 3)),
        torque_multipliers=np.zeros((n, 3)),
        momentum_multipliers=rng.normal(size=(n + 1, 3)),
    )


def test_a_flight_on_its_plan_costs_what_was_planned(flight, scenario):
    m = summarize(flight, scenario)
    assert m["plan_cost"] == pytest.approx(COST, abs=1e-5)
    assert m["flown_cost"] == pytest.approx(m["plan_cost"], rel=1e-12)
    assert (m["replans"], m["plan_not_found_steps"], m["plan_end_time"]) == (0, 0, 19.0)
    assert m["max_plan_error_deg"] < 1e-11
    assert m["max_plan_momentum_error"] < 1e-9
    assert m["cost"] is None  # a sum of stage costs to the target would be none of the tracking's
    use = m["bound_use"]
    assert set(use) == {f"{what} {axis}" for what in ("torque", "momentum") for axis in "xyz"}
    for saturated in ("torque y", "torque z", "momentum y", "momentum z"):
        assert use[saturated] == pytest.approx(1.0, abs=1e-9)
    assert use["torque x"] == pytest.approx(np.abs(flight.torque[:, 0]).max() / 20.0)
    assert m["max_bound_use"] == max(use.values())
    assert m["limits_exceeded"] == []


def test_the_summary_holds_components_against_their_bounds(flight, scenario):
    """The norm has no bound: a plan within 20 N m on each axis reaches 28 N m."""
    m = summarize(flight, scenario)
    assert m["max_components"]["momentum"] == pytest.approx(
        np.abs(flight.momentum).max(axis=0).tolist(), abs=1e-9
    )
    assert m["upper_bounds"] == {"torque": [20.0] * 3, "momentum": [70.0] * 3}
    rows = dict(summary_rows(m))
    assert rows["largest torque"] == "16.626 20 20 N m, bounds +-20"
    assert rows["largest momentum"] == "58.38 70 70 N m s, bounds +-70"
    assert rows["use of torque bounds"] == "x 83.13 %, y 100 %, z 100 %"
    assert rows["largest torque norm"] == "28.288641 N m"
    assert max(len(text) for text in rows.values()) + 26 <= 80
    unknown = dict(summary_rows(summarize(flight)))
    assert unknown["largest torque"] == "16.626 20 20 N m"
    assert "use of torque bounds" not in unknown


def test_rounding_off_the_plan_is_not_drawn(flight, scenario):
    drawn = plan_series.drawn_error_deg(flight)
    assert (drawn == 1e-6).all()
    error = flight_makers(flight, scenario)["plan"]().axes[2]
    assert error.get_title(loc="left").endswith("none, less than 1e-06 deg")


def test_further_plans_are_counted_and_marked(replanned, other):
    m = summarize(replanned, other)
    taken = np.flatnonzero(np.diff(replanned.plan) > 0) + 1
    assert m["replans"] == len(taken) >= 1
    marks = plan_series.plan_marks(replanned)
    times = [0.0, *replanned.time[taken]]
    assert [mark.time for mark in marks if mark.text != "plan ends"] == times
    assert [mark.text for mark in marks][:2] == ["first plan", "second plan"]
    assert marks[-1].text == "plan ends"
    assert marks[-1].time == m["plan_end_time"]
    assert m["max_plan_error_deg"] == pytest.approx(np.degrees(np.nanmax(replanned.plan_error)))
    assert m["max_plan_error_deg"] > 0.5  # what makes another plan due
    words = dict(summary_rows(m))
    times = "once" if m["replans"] == 1 else f"{m['replans']} times"
    assert f"replanned {times}" in words["plan"]
    assert words["use of torque bounds"].startswith("x ")


def test_a_flight_without_a_plan_has_none_of_these_metrics():
    flight = at_rest()
    m = summarize(flight)
    assert {m[key] for key in m if "plan" in key or "bound" in key or key == "flown_cost"} == {None}
    assert not plan_series.is_planned(flight)
    assert "plan" not in dict(summary_rows(m))
    assert "plan" not in flight_makers(flight)


def test_the_error_off_the_plan_is_the_angle_to_what_was_planned(replanned):
    """Rolled out from the first plan's torque, as long as it is flown."""
    first = load("phogat_figure4", OTHER_BODY)
    from spacecraft_gnc.ocp.transfer import TransferSolver
    from spacecraft_gnc.vehicles.rigid_body.planner.transfer import transfer_of

    plan = TransferSolver().solve(transfer_of(first))
    n = int(np.argmax(replanned.plan > 0))
    angle = lie.angles_between(plan.attitude[:n], replanned.attitude[:n])
    np.testing.assert_allclose(replanned.plan_error[:n], angle, atol=1e-12)
    np.testing.assert_allclose(replanned.plan_momentum[:n], plan.momentum[:n], atol=1e-9)


def test_the_use_of_one_sided_bounds():
    torque = np.zeros((20, 3))
    torque[3] = [1.0, -3.0, 2.0]
    flight = replace(at_rest(), torque=torque)
    real = np.array([[-np.inf, -6.0, -1.0], [2.0, 4.0, np.inf], [-np.inf] * 3, [np.inf] * 3])
    use = plan_series.bound_use(flight, real)
    assert use == {"torque x": 0.5, "torque y": 0.5, "torque z": 0.0}


def test_bounds_are_drawn_once(scenario, other):
    from spacecraft_gnc.drawing.style import Unit

    unit = Unit("mN m", 1000.0)
    drawn = plan_series.drawn_bounds(plan_series.bounds_of(scenario), 0, unit)
    assert [tuple(each) for each in drawn] == [
        (20000.0, "bound ±20000 mN m", True), (-20000.0, "", True)
    ]  # fmt: skip
    assert len(plan_series.drawn_bounds(plan_series.bounds_of(other), 0, unit)) == 4
    limits = np.array([[-1.0, -np.inf, -1.0], [2.0, 2.0, 1.0], [-1.0] * 3, [1.0] * 3])
    texts = [
        each.text
        for each in plan_series.drawn_bounds(
            plan_series.Bounds(limits, limits), 0, Unit("N m", 1.0)
        )
    ]
    assert texts == ["bound 2 N m, xy", "bound 1 N m, z", "bound -1 N m, xz"]


def test_bounds_without_a_plan_are_none(scenario):
    assert plan_series.bounds_of(None) is None
    assert plan_series.bounds_of(load("gupta2015_case1")) is None
    assert plan_series.bounds_of(scenario) is not None


def test_no_plan_found_is_told(flight, scenario):
    phase = flight.plan_phase.copy()
    phase[40:55] = Phase.NOT_FOUND
    lost = replace(flight, plan_phase=phase)
    m = summarize(lost, scenario)
    assert m["plan_not_found_steps"] == 15
    assert "no plan found at 15 steps" in dict(summary_rows(m))["plan"]
    assert [mark.text for mark in plan_series.plan_marks(lost)] == ["no plan found", "plan ends"]
    warnings = list(REPORT.warnings(run_of(lost, scenario)))
    assert "steps flown on an old plan, as no new one was found: 15" in warnings
    stretches = plan_series.phase_stretches(lost, series.state_times(lost))
    assert [(s.source, s.steps) for s in stretches] == [
        (Phase.FLYING, 40), (Phase.NOT_FOUND, 15), (Phase.FLYING, 135), (Phase.ARRIVED, 60)
    ]  # fmt: skip
    assert stretches[-1].end == pytest.approx(25.0)


def test_steps_that_were_lost_are_passed_over(replanned, other):
    plan, phase = replanned.plan.copy(), replanned.plan_phase.copy()
    lost = slice(plan.argmax() - 3, plan.argmax() + 3)
    plan[lost], phase[lost], plan[-5:-2], phase[-5:-2] = -1, -1, -1, -1
    gaps = replace(replanned, plan=plan, plan_phase=phase)
    assert len(plan_series.plan_marks(gaps)) == len(plan_series.plan_marks(replanned))
    told, whole = summarize(gaps, other), summarize(replanned, other)
    for key in ("replans", "plan_end_time", "max_plan_error_deg"):
        assert told[key] == whole[key]
    names = {s.source for s in plan_series.phase_stretches(gaps, series.state_times(gaps))}
    assert -1 in names
    assert plan_series.phase_name(-1) == "no plan"


def test_the_figures_show_plan_and_bounds(replanned, other):
    makers = flight_makers(replanned, other)
    torque, momentum, error = makers["plan"]().axes
    for axes, values, flown in (
        (torque, replanned.plan_torque, replanned.torque),
        (momentum, replanned.plan_momentum, replanned.momentum),
    ):
        n = len(values)
        drawn = [line.get_ydata() for line in axes.lines]
        for i in range(3):
            assert any(len(y) == n + 1 and np.array_equal(y[:n], values[:, i]) for y in drawn)
            assert any(len(y) == n + 1 and np.array_equal(y[:n], flown[:, i]) for y in drawn)
    assert {y[0] for y in (line.get_ydata() for line in torque.lines) if len(y) == 2} >= {
        20.0, -20.0, 18.0, -18.0
    }  # fmt: skip
    named = [text.get_text() for text in torque.get_legend().texts]
    assert named == ["planned", "planned bound"]
    assert not {"second plan", "plan ends"} & {text.get_text() for text in torque.texts}
    texts = [text.get_text() for text in error.texts]
    assert texts[:2] == ["first plan", "second plan"]
    assert texts[-1] == "plan ends"


def test_costates_are_drawn_where_plans_were_recorded(flight, scenario):
    plan = _recorded()
    run = run_of(flight, scenario, (plan,))
    assert "costates" not in record_makers(flight, computed(flight, scenario), scenario)
    axes = record_makers(flight, run.telemetry, scenario)["costates"]().axes
    np.testing.assert_array_equal(axes[0].lines[1].get_ydata()[:5], plan.co_momentum[:, 1])
    np.testing.assert_allclose(axes[2].lines[0].get_xdata()[:6], 0.1 * np.arange(2, 8))
    charts = {chart.name: chart for chart in REPORT.charts([run], 1000)}
    variants = [variant.name for variant in charts["costates"].variants]
    assert variants == ["co_momentum", "momentum_multipliers"]  # no bound on the torque acts


def test_a_plan_is_drawn_as_long_as_it_was_flown():
    first, second = _recorded(), _recorded(first_step=5)._replace(number=1)
    steps, values = as_flown([first, second], "momentum")
    np.testing.assert_array_equal(steps, [2, 3, 4, 5, *range(5, 12)])
    np.testing.assert_array_equal(values[:3], first.momentum[:3])
    np.testing.assert_array_equal(values[4:10], second.momentum)
    assert np.isnan(values[[3, 10]]).all()
    assert as_flown([], "momentum")[1].shape == (0, 3)


def test_the_page_of_one_run_shows_the_plan(replanned, other):
    charts = {chart.name: chart for chart in REPORT.charts([run_of(replanned, other)], 1000)}
    assert {"plan_error", "phases"} < set(charts)
    assert "costates" not in charts
    names = [trace["name"] for trace in charts["torque"].figure["data"]]
    assert names[:3] == ["x, planned", "y, planned", "z, planned"]
    assert "bound ±20 N m" in names
    marks = charts["torque"].figure["layout"]["annotations"]
    assert [mark["text"] for mark in marks][-1] == "plan ends"
    assert "annotations" not in charts["phases"].figure["layout"]
    assert "annotations" not in charts["solve_time"].figure["layout"]  # that is not over time


def test_the_page_of_two_runs_compares_them(flight, replanned, scenario, other):
    runs = [run_of(flight, scenario), run_of(replanned, other, name="other")]
    charts = {chart.name: chart for chart in REPORT.charts(runs, 1000)}
    assert len(charts["plan_error"].figure["data"]) == 2
    assert "annotations" not in charts["torque"].figure["layout"]
    norm = charts["torque_norm"]
    assert norm.title == "Torque norm"
    assert "bounds of a plan are on components" in norm.note
    rows = {row.label: row.value(runs[1]) for row in REPORT.rows if row.is_shown(runs)}
    assert rows["Torque limit"] == "on components"
    assert rows["Largest torque x, y, z"].endswith(" N m, bounds +-20")
    assert rows["Plans taken after the first"] == str(summarize(replanned, other)["replans"])


def test_costates_of_two_runs_have_a_diagram_for_each_component(flight, scenario):
    runs = [run_of(flight, scenario, (_recorded(),), name) for name in ("one", "two")]
    charts = {chart.name: chart for chart in REPORT.charts(runs, 1000)}
    assert charts["costates"].tall
    figure = charts["costates"].variants[0].figure
    assert [figure["layout"][f"yaxis{k}"]["title"]["text"] for k in ("", 2, 3)] == [
        "x [N m]", "y [N m]", "z [N m]"
    ]  # fmt: skip
    data = figure["data"]
    assert [trace["name"] for trace in data] == ["one"] * 3 + ["two"] * 3
    assert [trace.get("yaxis", "y") for trace in data[:3]] == ["y", "y2", "y3"]
    rows = {row.label for row in REPORT.rows if row.is_shown([run_of(at_rest(), None)])}
    assert "Largest torque x, y, z" not in rows
