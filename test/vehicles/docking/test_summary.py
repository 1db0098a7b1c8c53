"""Summary of a docking flight, in numbers and in words."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from docked import START, TURNED, aborted, flight, scenario

from spacecraft_gnc.cli.simulate import summary_rows
from spacecraft_gnc.vehicles.docking.decision import Answer
from spacecraft_gnc.vehicles.docking.flight import DockingFlight
from spacecraft_gnc.vehicles.docking.summary import counts, lines, metrics

WIDTH = 80  # columns


def texts(m):
    return dict(lines(m))


def test_the_metrics_are_those_of_the_arrays():
    m = metrics(flight(), scenario())
    json.dumps(m, allow_nan=False)
    # (1 - k / 60)^2 |START| <= 0.02 m from k = 59 on; the angle is under 1 deg long before
    assert (
        (1.0 / 60.0) ** 2 * np.linalg.norm(START) < 0.02 < (2.0 / 60.0) ** 2 * np.linalg.norm(START)
    )
    assert math.degrees((2.0 / 60.0) ** 2 * np.linalg.norm(TURNED)) < 1.0
    assert m["docked_at"] == 295.0
    assert (m["steps"], m["missing_steps"], m["duration"]) == (60, 0, 300.0)
    assert m["final_offset"] == m["final_angle_deg"] == 0.0
    assert m["max_force"] == pytest.approx(0.8)
    assert m["max_moment"] == pytest.approx(0.03)
    assert m["min_line_of_sight_margin"] == pytest.approx(0.05)
    assert m["min_clearance"] == 0.0
    assert m["reference_settled_at"] == 225.0
    assert m["governed_share"] == pytest.approx(45.0 / 60.0)
    assert m["constraints_kept"] is True
    assert m["sources"] == {"METHOD": 60}
    assert counts(m["answers"]) == "optimal 60"
    shape = np.linalg.norm([0.8, 0.2, 0.1])
    size = 5.0 * shape * np.abs(np.cos(np.pi * np.arange(60) / 60.0)).sum()
    assert m["impulse"] == pytest.approx(size)
    assert m["delta_v"] == pytest.approx(size / 130.0)
    assert m["solve_time_median"] == pytest.approx(2e-3)
    assert m["solve_time_max"] == pytest.approx(3e-3)


def test_the_least_margin_may_be_that_of_the_last_step():
    m = metrics(flight(final_line_of_sight_margin=np.array(-0.3)), scenario())
    assert m["min_line_of_sight_margin"] == -0.3
    assert m["constraints_kept"] is False


def test_without_a_scenario_limits_are_not_known():
    m = metrics(flight())
    assert m["constraints_kept"] is None
    assert m["max_force_limit"] is None
    assert m["delta_v"] is None
    assert m["limits_exceeded"] == []
    assert texts(m)["constraints"] == "not known without a scenario"
    assert texts(m)["largest force"] == "0.8 N"


def test_broken_constraints_are_said_loudly():
    force = flight().force.copy()
    force[3] = [-1.7, 0.0, 0.0]
    free = scenario(plant={"saturates": False})
    m = metrics(flight(force=force, final_clearance=np.array(-0.5)), free) | {"scenario_hash": None}
    assert texts(m)["constraints"] == "BROKEN: force; clearance"
    told = dict(summary_rows(m, free))
    assert told["warning"] == (
        "limits exceeded: force 1.7 times (1.7 N, limit 1 N); clearance by 0.48 m"
    )


def test_an_abort_is_told_with_its_loss_and_the_distance_to_the_hold_point():
    m = metrics(aborted(), scenario())
    assert (m["thruster_lost"], m["thruster_lost_at"]) == ("+x", 100.0)
    assert m["thruster_loss_detected_at"] == 110.0
    assert m["phases"] == {"docking": 22, "aborting": 25, "holding": 13}
    assert m["hold_distance"] == pytest.approx(0.0, abs=1e-12)
    told = texts(m)
    assert told["docked"] == "no"
    assert told["thruster lost"] == "+x at 100 s, noticed at 110 s"
    assert told["given up"] == "holding at the end, 0 m from the hold point"
    assert "reference" not in told


def test_steps_without_an_admissible_reference_are_counted():
    status = np.zeros(60, dtype=int)
    status[:3] = [Answer.INFEASIBLE, Answer.NOT_SOLVED, Answer.LEAST_VIOLATION]
    m = metrics(flight(status=status), scenario())
    assert m["inadmissible_steps"] == 3
    assert m["answers"] == {
        "optimal": 57, "infeasible": 1, "not_solved": 1, "least_violation": 1, "passed": 0
    }  # fmt: skip


def test_decisions_without_a_program_take_time_too():
    taken, residual = np.full(60, 1e-3), np.full(60, math.nan)
    taken[40], taken[50] = 0.03, math.nan
    m = metrics(flight(solve_time=taken, residual=residual), scenario())
    assert (m["solve_time_median"], m["solve_time_max"]) == (1e-3, 0.03)


def test_a_flight_that_never_docks_says_so():
    flown = flight(final_port_offset=np.array([0.5, 0.0, 0.0]))
    assert texts(metrics(flown, scenario()))["docked"] == "NO"


@pytest.mark.parametrize("made", [flight, aborted])
def test_the_lines_fit_into_a_terminal(made):
    rows = lines(metrics(made(), scenario()))
    label = max(len(name) for name, _ in rows)
    assert max(2 + label + 2 + len(text) for _, text in rows) <= WIDTH


def test_a_flight_of_which_nothing_was_recorded_has_no_metrics():
    flown, n = flight(), 60
    gone = {
        name: np.full_like(getattr(flown, name), math.nan)
        for name, column in DockingFlight.columns()
        if column.type is np.float64
    }
    blank = {name: np.full(n, -1) for name in ("status", "source", "phase")}
    m = metrics(flight(**(gone | blank)), scenario())
    json.dumps(m, allow_nan=False)
    assert m["missing_steps"] == n
    for name in ("docked_at", "final_offset", "max_force", "min_clearance", "governed_share"):
        assert m[name] is None
    assert m["phase"] == "unknown"
    assert texts(m)["at the end"] == "not known"
