"""Metrics against the reference flight of Case I, and against flights worked out by hand."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from analysis.flights import PERIOD, at_rest, case1, scenario, trajectory, zone
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.ocp import ShootingSolver, Status, TerminalSetSolver
from spacecraft_gnc.scenario import from_sections, load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of
from spacecraft_gnc.vehicles.rigid_body.controllers.terminal_set.controller import (
    TerminalSetController,
)
from spacecraft_gnc.vehicles.rigid_body.metrics.summary import settle_time


def about_z(degrees):
    return lie.exp(np.array([0.0, 0.0, np.radians(degrees)]))


def test_case_1_of_gupta_2015():
    metrics = summarize(case1(), scenario())
    assert metrics["steps"] == 375
    assert metrics["duration"] == pytest.approx(150.0)
    assert metrics["final_error_deg"] == pytest.approx(0.21364, abs=1e-5)
    assert metrics["final_momentum"] == pytest.approx(4.14e-4, abs=5e-7)
    assert metrics["settle_time_5deg"] == pytest.approx(55.2)
    assert metrics["settle_time_1deg"] == pytest.approx(105.2)
    assert metrics["settle_time_0.1deg"] is None
    assert metrics["max_torque"] == pytest.approx(0.01, abs=1e-8)
    assert metrics["torque_limit"] == 0.01
    assert metrics["saturated_steps"] == 32
    assert metrics["cost"] == pytest.approx(0.0550925764, abs=1e-10)


def test_a_feedback_law_has_no_stage_costs():
    """It minimizes none: the weights that a scenario has by default are not its own."""
    assert summarize(case1(), scenario(method="feedback"))["cost"] is None


def test_metrics_are_json():
    metrics = summarize(case1(), scenario({"star": zone([0.9276, 0.3736, 0.0], 4.9965)}))
    assert json.loads(json.dumps(metrics, allow_nan=False)) == metrics


def test_without_a_scenario_what_needs_it_is_none():
    metrics = summarize(case1())
    unknown = ("cost", "torque_limit", "saturated_steps", "min_zone_margin_deg")
    assert [metrics[name] for name in unknown] == [None] * 4
    assert metrics["zone_margin_deg"] == {}


def test_without_a_torque_limit_no_step_is_saturated():
    metrics = summarize(case1(), scenario(max_torque=0.0))
    assert metrics["torque_limit"] is None
    assert metrics["saturated_steps"] is None
    assert metrics["cost"] is not None


def test_the_error_is_taken_from_the_reference_not_from_the_identity():
    reference = np.tile(about_z(30.0), (20, 1, 1))
    flight = at_rest(reference=reference, final_reference=reference[0])
    metrics = summarize(flight, scenario())
    assert metrics["final_error_deg"] == pytest.approx(30.0)
    # 20 steps of h/2 * 0.01 |I - R_ref|_F^2, and |I - R|_F^2 = 4 (1 - cos 30 deg)
    per_step = 0.5 * PERIOD * 0.01 * 4.0 * (1.0 - np.cos(np.radians(30.0)))
    assert metrics["cost"] == pytest.approx(20 * per_step)


def test_full_weight_matrices_act_on_their_axes():
    weights = scenario(weights={"stage_momentum": [1.0, 0, 0, 0, 2.0, 0, 0, 0, 3.0]})
    momentum = np.zeros((2, 3))
    momentum[0] = [0.0, 0.0, 1.0]
    flight = trajectory(np.tile(np.eye(3), (2, 1, 1)), momentum, np.zeros((1, 3)))
    # hat(e_z) has entries in its first two rows: |W^(1/2) hat(e_z)|_F^2 = 1 + 2
    (cost,) = series.stage_costs(flight, weights.controller.weights)
    assert cost == pytest.approx(0.5 * PERIOD * 3.0)


def plan_as_flight(solution):
    """The predicted horizon of a solve, as if it had been flown."""
    reference = np.tile(solution.reference, (len(solution.torques), 1, 1))
    flight = trajectory(solution.attitudes, solution.momenta, solution.torques)
    return replace(flight, reference=reference, period=solution.ocp.time_step)


@pytest.mark.parametrize("m", [0, 2, 3, 4])
def test_stage_costs_are_those_that_the_solver_counts(m):
    B = np.array([[1.0, 0.2, 0.1, 0.5], [0.0, 0.9, -0.3, 0.5], [0.1, 0.3, 1.1, 0.5]])[:, :m]
    weights = {"stage_momentum": 0.05, "terminal_attitude": 0.0, "terminal_momentum": 0.0}
    loaded = scenario(weights=weights, max_torque=0.0, actuators=B.ravel().tolist())
    ocp = problem_of(loaded)
    start, target = lie.exp(np.array([0.3, -0.2, 0.4])), lie.exp(np.array([0.1, 0.2, 0.0]))
    solution = ShootingSolver(ocp).solve(start, np.array([0.01, 0.02, -0.01]), target)
    flight = plan_as_flight(solution)
    costs = series.stage_costs(flight, loaded.controller.weights, loaded.controller.actuators)
    assert costs.sum() == pytest.approx(solution.cost, rel=1e-12)
    assert summarize(flight, loaded)["cost"] == pytest.approx(solution.cost, rel=1e-12)


def test_the_terminal_set_method_has_stage_costs_of_its_own():
    """(24) and (25) of Kalabic et al. 2014: neither h nor a weight of the momentum."""
    loaded = load(shipped("kalabic2014_nmpc"))
    ocp = TerminalSetController.problem(loaded)
    start, target = lie.exp(np.array([0.3, -0.2, 0.4])), lie.exp(np.array([0.1, 0.2, 0.0]))
    solution = TerminalSetSolver(ocp).solve(start, np.array([0.05, 0.02, -0.01]), target)
    ends = 0.5 * ocp.level_of(ocp.terminal_state(solution.attitudes, solution.momenta, target))
    cost = summarize(plan_as_flight(solution), loaded)["cost"]
    assert cost == pytest.approx(solution.cost - ends, rel=1e-10)


@pytest.mark.parametrize(
    ("kind", "half_angle", "margin"),
    [("exclusion", 50.0, 65.0 - 50.0), ("inclusion", 92.0, 92.0 - 95.0)],
)
def test_zone_margins_are_signed_angles(kind, half_angle, margin):
    attitude = np.array([about_z(0.0), about_z(25.0), about_z(-5.0)])
    flight = trajectory(attitude, np.zeros((3, 3)), np.zeros((2, 3)))
    metrics = summarize(flight, scenario({"a": zone([0.0, 1.0, 0.0], half_angle, kind)}))
    # the x axis comes within 65 deg of y, and is 95 deg away at the most
    assert metrics["zone_margin_deg"] == {"a": pytest.approx(margin)}
    assert metrics["min_zone_margin_deg"] == pytest.approx(margin)


def test_the_least_margin_of_several_zones_counts():
    zones = {"near": zone([1.0, 0.1, 0.0], 2.0), "far": zone([0.0, 0.0, 1.0], 2.0)}
    metrics = summarize(at_rest(), scenario(zones))
    assert metrics["min_zone_margin_deg"] == metrics["zone_margin_deg"]["near"]


def test_solver_metrics_leave_out_steps_without_a_solve():
    n = 4
    flight = at_rest(
        n,
        iterations=np.array([2, 9, 4, 0]),
        status=np.array([0, 1, 0, -1]),
        source=np.array([0, 2, 1, 4]),
        solve_time=np.array([1e-3, 5e-3, 3e-3, np.nan]),
    )
    metrics = summarize(flight)
    assert (metrics["iterations_median"], metrics["iterations_max"]) == (4.0, 9)
    assert metrics["unconverged_steps"] == 1
    assert (metrics["solve_time_median"], metrics["solve_time_max"]) == (3e-3, 5e-3)
    assert metrics["sources"] == {
        "OPTIMAL": 1,
        "NEIGHBORING_EXTREMAL": 1,
        "SHIFTED_PLAN": 1,
        "ZERO": 1,
    }
    assert metrics["fallback_steps"] == 2


def test_a_standstill_is_no_failed_solve():
    status = np.array([0, 5, Status.STALLED, Status.STALLED, Status.ESCAPING, -1])
    metrics = summarize(at_rest(6, status=status))
    counts = ("unconverged_steps", "stalled_steps", "escaping_steps")
    assert [metrics[name] for name in counts] == [1, 2, 1]


def test_a_flight_without_a_solver_has_no_solver_metrics():
    nothing = np.full(20, np.nan)
    metrics = summarize(at_rest(status=np.full(20, -1), solve_time=nothing))
    names = ("iterations_median", "iterations_max", "solve_time_median", "solve_time_p99")
    counts = ("unconverged_steps", "stalled_steps", "escaping_steps")
    assert [metrics[name] for name in names + counts] == [None] * 7


def governed(references, alpha, **replaced):
    """Return a flight whose attitude is the reference of the step before, in degrees about z."""
    reference = np.array([about_z(degrees) for degrees in references])
    attitude = np.concatenate([reference[:1], reference])
    zero = np.zeros((len(attitude), 3))
    fields = {"reference": reference, "final_reference": reference[-1], "alpha": np.array(alpha)}
    fields["governor_margin"] = np.linspace(0.02, 0.01, len(reference))
    return trajectory(attitude, zero, zero[:-1], **fields | replaced)


def test_a_governed_flight_is_judged_by_its_target():
    flight = governed([8.0, 4.0, 2.0, 0.5, 0.0, 0.0], [0.5, 0.5, 0.75, 0.75, 1.0, 1.0])
    metrics = summarize(flight, scenario())
    assert metrics["error_to"] == "target"
    assert metrics["final_error_deg"] == pytest.approx(0.0, abs=1e-9)
    assert metrics["settle_time_5deg"] == pytest.approx(2 * PERIOD)
    assert metrics["settle_time_1deg"] == pytest.approx(4 * PERIOD)
    assert metrics["alpha_one_time"] == pytest.approx(4 * PERIOD)
    assert metrics["min_governor_margin"] == pytest.approx(0.01)


def test_a_reference_on_its_way_is_no_target():
    flight = governed([8.0, 4.0, 2.0, 2.0], [0.5, 1.0, 0.5, 0.0])  # 1: of an intermediate one
    metrics = summarize(flight, scenario())
    assert (metrics["error_to"], metrics["alpha_one_time"]) == ("target", None)
    assert metrics["final_error_deg"] == pytest.approx(2.0)
    assert metrics["settle_time_5deg"] == pytest.approx(2 * PERIOD)
    assert metrics["final_reference_error_deg"] == pytest.approx(2.0)
    unknown = summarize(replace(flight, target=np.full((4, 3, 3), np.nan)))
    assert unknown["final_reference_error_deg"] is None
    assert (unknown["error_to"], unknown["alpha_one_time"]) == ("reference", None)
    assert unknown["min_governor_margin"] == pytest.approx(0.01)


def test_steps_at_which_not_even_the_held_reference_is_admissible_are_counted():
    margin = np.array([0.02, -1e-9, np.nan, -0.1])
    flight = governed([8.0, 4.0, 2.0, 2.0], [0.5, 0.0, 0.0, 0.0], governor_margin=margin)
    assert summarize(flight, scenario())["inadmissible_steps"] == 2
    assert summarize(at_rest(), scenario())["inadmissible_steps"] == 0


def test_each_step_is_judged_by_the_target_of_its_time():
    target = np.array([about_z(degrees) for degrees in (0.0, 0.0, 0.0, 30.0, 30.0, 30.0)])
    flown = [8.0, 4.0, 0.0, 10.0, 30.0, 30.0], [0.5, 0.5, 1.0, 0.5, 1.0, 1.0]
    flight = governed(*flown, target=target)
    error = series.settling_error_deg(flight)  # the attitude follows a step later
    np.testing.assert_allclose(error, [8.0, 8.0, 4.0, 30.0, 20.0, 0.0, 0.0], atol=1e-6)
    metrics = summarize(flight, scenario())
    assert metrics["settle_time_5deg"] == pytest.approx(5 * PERIOD)
    assert metrics["alpha_one_time"] == pytest.approx(4 * PERIOD)
    assert metrics["final_reference_error_deg"] == pytest.approx(0.0, abs=1e-6)


def test_a_flight_without_a_governor_has_no_governor_metrics():
    metrics = summarize(at_rest(), scenario())
    values = metrics["error_to"], metrics["alpha_one_time"], metrics["min_governor_margin"]
    assert values == ("reference", None, None)


def test_the_torque_limit_may_be_the_governors():
    known = from_sections(
        {
            "plant": {"inertia": [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]},
            "nmpc_controller": {"method": "feedback", "max_torque": 0.0},
            "reference_governor": {"governor": "attitude", "max_torque": 0.02},
        }
    )
    flight = governed([1.0, 0.0], [0.5, 1.0])
    assert summarize(flight, known)["torque_limit"] == 0.02
    assert summarize(at_rest(2), known)["torque_limit"] is None  # no governor flew


def test_the_torque_of_the_feedback_method_is_no_fallback():
    feedback = scenario(method="feedback")
    for own in (3, 5):  # as flights of before `Source.METHOD` call it, and as those of now do
        metrics = summarize(at_rest(3, source=np.array([own, own, 4])), feedback)
        assert metrics["fallback_steps"] == 1
        assert metrics["sources"] == {"ZERO": 1, "METHOD": 2}
    assert summarize(at_rest(3, source=np.array([3, 3, 4])), scenario())["fallback_steps"] == 3


def test_lost_steps_are_counted_and_passed_over():
    flight = case1()
    torque, attitude = flight.torque.copy(), flight.attitude.copy()
    torque[100], attitude[40] = np.nan, np.nan
    source = flight.source.copy()
    source[100] = -1
    lossy = replace(flight, attitude=attitude, torque=torque, source=source)
    metrics = summarize(lossy, scenario())
    assert metrics["missing_steps"] == 2
    assert metrics["settle_time_5deg"] == pytest.approx(55.2)
    assert metrics["max_torque"] == pytest.approx(0.01, abs=1e-8)
    assert metrics["cost"] == pytest.approx(0.0550925764, rel=0.1)
    assert metrics["sources"] == {"OPTIMAL": 374}
    json.dumps(metrics, allow_nan=False)


def test_settle_time_by_hand():
    times = np.arange(6.0)
    error = np.array([9.0, 4.0, 6.0, 5.0, 1.0, 2.0])
    assert settle_time(times, error, 10.0) == 0.0
    assert settle_time(times, error, 5.0) == 4.0  # an error equal to the threshold is not below
    assert settle_time(times, error, 2.0) is None


@given(
    error=st.lists(st.floats(0.0, 10.0) | st.just(float("nan")), min_size=1, max_size=30),
    threshold=st.floats(0.1, 9.0),
)
def test_settle_time_is_the_first_time_after_which_all_is_below(error, threshold):
    times, values = np.arange(float(len(error))), np.array(error)
    settled = settle_time(times, values, threshold)
    known = ~np.isnan(values)
    if settled is None:
        assert not known.any() or values[known][-1] >= threshold
        return
    assert (values[known & (times >= settled)] < threshold).all()
    before = values[known & (times < settled)]
    assert before.size == 0 or before[-1] >= threshold
