"""What another controller would have commanded along a flight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from analysis.flights import DATA, case1

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.scenario import load, revise
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of
from spacecraft_gnc.vehicles.rigid_body.resolve.comparison import compare
from spacecraft_gnc.vehicles.rigid_body.resolve.figure import figure
from spacecraft_gnc.vehicles.rigid_body.resolve.replay import resolve

CONFIG = DATA.parents[1] / "config"
SHORT = {"plant.duration": 16.0, "launcher.cut_short": True}
CASE1 = CONFIG / "gupta2015_case1.yaml"


def flown(name="gupta2015_case1", **overrides):
    scenario = load(CONFIG / f"{name}.yaml", SHORT | overrides)
    return scenario, scenario.build().run()


def answered(scenario, flight, method=None, overrides=(), **options):
    revised, _ = revise(scenario, overrides, method)
    return resolve(flight, scenario, revised, **options)


@pytest.mark.parametrize(
    "name",
    [
        "gupta2015_case1",
        "bagherzadeh2023_estimated_du",  # a Jacobian estimated along the way
        "bagherzadeh2023_ne",  # the last optimum, corrected
        "bagherzadeh2023_ne_exact10",  # a nominal run
        "kalabic2014_nmpc",
        "kalabic2014_ungoverned",
        "governed_nmpc",
    ],
)
def test_the_controller_that_flew_commands_the_same_bit_for_bit(name):
    scenario, flight = flown(name)
    again = resolve(flight, scenario, scenario)
    assert again.first_difference is None
    assert not again.torque_difference.any()
    assert not np.nan_to_num(again.cost_difference).any()
    assert len(again.steps) == flight.n_steps
    assert np.array_equal(again.replayed.iterations, flight.iterations)
    assert np.array_equal(again.replayed.status, flight.status)
    assert np.array_equal(again.replayed.source, flight.source)


def test_an_escape_from_a_standstill_is_repeated():
    scenario = load(CONFIG / "gupta2015_case2.yaml")
    flight = scenario.build().run()
    again = resolve(flight, scenario, scenario)
    assert compare(again, scenario, scenario)["replayed"]["escaping_steps"] > 0
    assert again.first_difference is None


def test_the_optimum_of_casadi_and_ipopt_is_found_at_every_step():
    scenario = load(CASE1)
    again = resolve(case1(), scenario, scenario, cold=True)
    assert again.torque_difference.max() < 1e-9
    assert len(again.steps) == 375


def test_no_plan_is_cheaper_than_the_recorded_optimum():
    scenario, flight = flown()
    for method, overrides in [
        ("slsqp", {}),
        ("neighboring_extremal", {}),
        (None, {"nmpc_controller.weights.stage_torque": 3.0}),
        (None, {"nmpc_controller.max_torque": 0.005}),
    ]:
        again = answered(scenario, flight, method, overrides, steps=(0, 12))
        assert again.first_difference is not None
        assert again.cost_difference.min() > -1e-15  # rounding of a cost of 0.02
        assert again.cost_difference.max() > 1e-15


def test_other_solvers_of_the_same_problem_agree():
    scenario, flight = flown()
    assert answered(scenario, flight, "fsolve").torque_difference.max() < 1e-10
    assert answered(scenario, flight, "slsqp", steps=(0, 10)).torque_difference.max() < 1e-6
    assert answered(scenario, flight, "neighboring_extremal").torque_difference.max() < 1e-4


def test_a_law_without_a_plan_has_no_cost():
    scenario, flight = flown()
    again = answered(scenario, flight, "feedback")
    assert np.isnan(again.cost_difference).all()
    assert (again.replayed.source == Source.METHOD).all()
    assert (again.replayed.iterations == 0).all()
    numbers = compare(again, scenario, scenario)
    assert numbers["cost_difference_max"] is None
    assert numbers["replayed"]["solve_time_median"] is None
    assert numbers["recorded"]["sources"] == {"OPTIMAL": 40}


@pytest.mark.parametrize("flew", ["shooting", "slsqp"])
def test_methods_that_pay_for_limits_in_different_ways_compare_by_what_both_pay(flew):
    """Out of the zone of Case II slsqp finds no plan at some steps: one of those cost 4e18."""
    scenario, flight = flown("gupta2015_case2", **{"nmpc_controller.method": flew})
    other = "slsqp" if flew == "shooting" else "shooting"
    again = answered(scenario, flight, other, steps=(0, 12))
    numbers = compare(again, scenario, scenario)
    assert 0.0 < abs(numbers["cost_difference_max"]) < 1e-3
    assert 0.0 < abs(numbers["plain_cost_difference_max"]) < 1e-3
    paid = [[price.penalty for price in pair] for pair in again.prices]
    if flew == "slsqp":  # its cost counts no penalty
        assert np.nanmax(paid) == 0.0
        return
    assert series.unconverged(again.replayed).any()
    assert numbers["penalty_max"] == np.nanmax(paid) > 1e-5
    assert numbers["penalty_side"] == "recorded"  # a penalty lets its plans into the zone
    assert 0.0 < numbers["penalty_zone_excess_deg"] < 1.0


def test_a_looser_limit_is_priced_with_its_penalty():
    scenario, flight = flown()
    again = answered(scenario, flight, overrides={"nmpc_controller.max_torque": 0.02}, steps=(0, 8))
    old, new = again.prices[0]
    ocp = problem_of(scenario)
    solution = load(CASE1, SHORT | {"nmpc_controller.max_torque": 0.02}).build_controller().solver
    plan = solution.solve(flight.attitude[0], flight.momentum[0], flight.reference[0]).torques
    over = np.maximum(0.0, (plan**2).sum(axis=1) - 0.01**2)
    assert new.penalty == pytest.approx(ocp.torque_penalty * ocp.time_step * (over**2).sum())
    assert new.torque_excess == pytest.approx(np.linalg.norm(plan, axis=1).max() - 0.01)
    assert new.plain < old.plain < new.cost
    assert old.cost == pytest.approx(flight.cost[0], rel=1e-12)


def test_the_plan_of_a_failed_solve_is_not_priced():
    scenario, flight = flown()
    changes = {"nmpc_controller.max_iterations": 1, "nmpc_controller.continuation": "none"}
    again = answered(scenario, flight, overrides=changes, steps=(0, 8))
    failed = again.replayed.status != 0
    assert failed.any()
    assert np.isnan(again.cost_difference[failed]).all()


def test_plans_of_another_length_are_not_priced():
    scenario, flight = flown()
    longer = answered(scenario, flight, overrides={"nmpc_controller.horizon": 8})
    assert np.isnan(longer.cost_difference).all()
    assert longer.torque_difference.max() > 0.0


def test_history_begins_at_the_first_step_solved():
    scenario, flight = flown()
    part = resolve(flight, scenario, scenario, steps=(10, 30))
    assert part.steps.tolist() == list(range(10, 30))
    assert 0.0 < part.torque_difference[0] < 1e-10  # another start of the same solve
    assert np.array_equal(part.replayed.attitude, flight.attitude[10:30])
    assert np.array_equal(part.recorded.final_attitude, flight.attitude[30])
    assert part.recorded.time[0] == flight.time[10]


def test_a_cold_start_takes_more_iterations():
    scenario = load(CASE1, SHORT | {"nmpc_controller.horizon": 20})
    flight = scenario.build().run()
    cold = resolve(flight, scenario, scenario, cold=True)
    assert cold.replayed.iterations.sum() > 1.2 * flight.iterations.sum()
    assert cold.torque_difference.max() < 1e-10


def test_steps_that_lack_a_message_are_left_out():
    scenario, flight = flown()
    attitude, torque = flight.attitude.copy(), flight.torque.copy()
    attitude[3], torque[7] = np.nan, np.nan
    again = resolve(replace(flight, attitude=attitude, torque=torque), scenario, scenario)
    assert again.steps.tolist() == [k for k in range(40) if k not in (3, 7)]
    assert again.torque_difference.max() < 1e-10


@pytest.mark.parametrize("steps", [(-1, 5), (5, 5), (6, 5), (0, 41)])
def test_steps_outside_the_flight_are_refused(steps):
    scenario, flight = flown()
    with pytest.raises(ParameterError, match="0 <= A < B <= 40"):
        resolve(flight, scenario, scenario, steps=steps)


def test_a_flight_without_a_complete_step_is_refused():
    scenario, flight = flown()
    empty = replace(flight, momentum=np.full_like(flight.momentum, np.nan))
    with pytest.raises(ParameterError, match="at least one complete step"):
        resolve(empty, scenario, scenario)


def test_another_control_period_is_refused():
    scenario, flight = flown()
    with pytest.raises(ParameterError, match=r"required the period of the flight, 0\.4 s"):
        answered(scenario, flight, overrides={"nmpc_controller.time_step": 0.8})


def test_a_failed_step_is_counted():
    scenario, flight = flown()
    few = {"nmpc_controller.max_iterations": 1, "nmpc_controller.continuation": "none"}
    revised, _ = revise(scenario, few)
    again = resolve(flight, scenario, revised)
    assert compare(again, scenario, revised)["replayed"]["unconverged_steps"] > 0


def test_the_numbers_say_where_the_torques_differ_most():
    scenario, flight = flown()
    again = resolve(flight, scenario, scenario)
    torque = flight.torque.copy()
    torque[11] += [3e-3, 0.0, 4e-3]
    again = resolve(replace(flight, torque=torque), scenario, scenario)
    numbers = compare(again, scenario, scenario)
    assert numbers["torque_difference_max"] == pytest.approx(5e-3)
    assert numbers["torque_difference_rms"] == pytest.approx(5e-3 / np.sqrt(40))
    assert numbers["torque_difference_max_step"] == numbers["first_difference"] == 11
    assert numbers["identical_steps"] == 39


@pytest.mark.parametrize("method", ["shooting", "feedback", "fsolve"])
def test_the_figure_shows_both(method):
    scenario, flight = flown()
    drawn = figure(answered(scenario, flight, method), ("shooting", method))
    torque, difference, iterations, time = drawn.axes
    assert len(torque.lines) == 6
    assert f"shooting as flown (wide), {method} (thin)" in torque.get_title(loc="left")
    same = method == "shooting"
    assert [text.get_text() for text in difference.texts] == (
        ["zero in every step, bit for bit"] if same else []
    )
    assert len(iterations.lines) == len(time.lines) == (1 if method == "feedback" else 2)
