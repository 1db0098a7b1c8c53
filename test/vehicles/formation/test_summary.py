"""Summary of a flight in formation, in numbers and in words."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from formed import PERIOD, PLACES, START, STEPS, flight, loss, parked, scenario

from spacecraft_gnc.cli.simulate import summary_rows
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.flight import FormationFlight
from spacecraft_gnc.vehicles.formation.summary import answer_name, counts, length, lines, metrics

WIDTH = 80  # columns


def texts(m):
    return dict(lines(m))


def _kept(flown):
    return {name: getattr(flown, name) for name in ("status", "deadlocked", "time_shift")}


def test_the_metrics_are_those_of_the_arrays():
    m = metrics(flight(), scenario())
    json.dumps(m, allow_nan=False)
    # (1 - k / 60)^2 3000 m < 10 m from k = 57 on; the shifts are equal from 30 on
    assert (3.0 / 60.0) ** 2 * 3000.0 < 10.0 < (4.0 / 60.0) ** 2 * 3000.0
    assert m["formed_at_step"] == 57
    assert (m["steps"], m["missing_steps"]) == (60, 0)
    assert m["duration"] == pytest.approx(60.0 * PERIOD)
    assert m["final_position_error"] == pytest.approx(3000.0 / 3600.0)
    assert m["max_delta_v"] == pytest.approx(0.9)
    ramp = (1.0 - np.arange(STEPS) / STEPS).sum()
    assert m["craft_delta_v"] == pytest.approx([0.9 * ramp, 0.3 * ramp, 0.0])
    assert m["total_delta_v"] == pytest.approx(1.2 * ramp)
    assert m["craft_max_delta_v"] == pytest.approx([0.9, 0.3, 0.0])
    assert m["craft_final_error"] == pytest.approx((np.abs(START).max(axis=1) / 3600.0).tolist())
    share = ((1.0 - np.arange(STEPS + 1) / STEPS) ** 2)[:, None, None]
    at = PLACES + share * START
    apart = {
        (i, j): np.linalg.norm(at[:, i] - at[:, j], axis=1).min()
        for i in range(3)
        for j in range(3)
        if i != j
    }
    assert m["min_separation"] == pytest.approx(min(apart.values()))
    assert m["craft_min_separation"] == pytest.approx(
        [min(apart[i, j] for j in range(3) if i != j) for i in range(3)]
    )
    assert 0.0 < m["max_communication_angle_deg"] < 60.0
    assert m["constraints_kept"] is True
    assert m["min_margin"] == pytest.approx(0.01)
    assert counts(m["answers"]) == "optimal 60"
    assert m["solve_time_median"] == pytest.approx(2e-3)
    assert m["solve_time_max"] == pytest.approx(3e-3)
    assert (m["deadlocked"], m["deadlocks"], m["passages"]) == (False, 0, 0)


def test_delta_v_in_all_is_what_the_craft_can_make():
    delta_v = np.zeros((STEPS, 3, 3))
    delta_v[:10, 1, 0] = 1.5
    assert metrics(flight(delta_v=delta_v), scenario())["total_delta_v"] == pytest.approx(10.0)
    free = scenario(plant={"saturates": False})
    assert metrics(flight(delta_v=delta_v), free)["total_delta_v"] == pytest.approx(15.0)


def test_without_a_scenario_limits_are_not_known():
    m = metrics(flight())
    assert m["constraints_kept"] is None
    assert m["formed_at_step"] is None
    assert m["max_delta_v_limit"] is None
    assert texts(m)["constraints"] == "not known without a scenario"
    assert texts(m)["largest delta-v"] == "0.9 m/s"
    assert metrics(loss())["spacecraft_lost"] == "3"


def test_broken_constraints_are_said_loudly():
    delta_v = flight().delta_v.copy()
    delta_v[3, 2] = [-1.7, 0.0, 0.0]
    position = np.concatenate([flight().position, flight().final_position[None]])
    position[30, 0] = position[30, 1] + [0.0, 600.0, 0.0]
    m = metrics(flight(delta_v=delta_v, all_positions=position), scenario())
    told = dict(summary_rows(m | {"scenario_hash": None}, scenario()))
    assert told["constraints"].startswith("BROKEN: delta-v; separation")
    assert told["warning"].startswith(
        "limits exceeded: delta-v 1.7 times (1.7 m/s, limit 1 m/s); separation 600 m, at least"
    )


def test_a_loss_is_told_and_the_others_form_up():
    m = metrics(loss(), scenario())
    assert m["spacecraft_lost"] == "sc3"
    assert m["spacecraft_lost_at"] == pytest.approx(20 * PERIOD)
    assert m["spacecraft_loss_detected_at"] == pytest.approx(22 * PERIOD)
    assert m["formed_at_step"] == 57
    assert m["max_delta_v"] == pytest.approx(0.9)
    assert texts(m)["craft lost"] == "sc3 at 2196.9 s, noticed at 2416.6 s"
    unnoticed = metrics(loss(noticed=STEPS), scenario())
    assert texts(unnoticed)["craft lost"] == "sc3 at 2196.9 s, not noticed"


def test_a_deadlock_is_told_with_the_way_out():
    m = metrics(parked(), scenario())
    assert (m["deadlocked"], m["deadlocks"], m["passages"]) == (False, 1, 2)
    assert texts(m)["deadlock"] == "once, resolved by 2 passages"
    away = parked().reference_position + np.array([0.0, 0.0, 50.0])
    m = metrics(flight(**{**_kept(parked()), "reference_position": away}), scenario())
    assert texts(m)["deadlock"] == "once, left by 2 passages"  # the flight ends on the way
    m = metrics(parked(resolved=False), scenario())
    assert (m["deadlocked"], m["deadlocks"], m["formed_at_step"]) == (True, 1, None)
    assert texts(m)["deadlock"] == "once, NOT resolved"
    assert texts(m)["formed"] == "NO"


def test_steps_without_admissible_shifts_are_counted():
    status = np.zeros(STEPS, dtype=int)
    status[:3] = [Answer.HELD, Answer.LEAST_VIOLATING, Answer.PASSED]
    m = metrics(flight(status=status), scenario())
    assert m["inadmissible_steps"] == 2
    assert counts(m["answers"]) == "optimal 57, held 1, least violating 1, passed 1"


@pytest.mark.parametrize("flown", [flight(), loss(), parked(), parked(resolved=False)])
def test_the_lines_fit_into_a_terminal(flown):
    rows = lines(metrics(flown, scenario()))
    label = max(len(name) for name, _ in rows)
    assert max(2 + label + 2 + len(text) for _, text in rows) <= WIDTH


def test_a_flight_of_which_nothing_was_recorded_has_no_metrics():
    flown = flight()
    gone = {
        name: np.full_like(getattr(flown, name), math.nan)
        for name, column in FormationFlight.columns()
        if column.type is np.float64
    }
    blank = {
        "status": np.full(STEPS, -1), "source": np.full(STEPS, -1),
        "time_shift": np.full((STEPS, 3), -1),
    }  # fmt: skip
    m = metrics(flight(**(gone | blank)), scenario())
    json.dumps(m, allow_nan=False)
    assert m["missing_steps"] == STEPS
    for name in ("formed_at_step", "final_position_error", "max_delta_v", "min_separation"):
        assert m[name] is None
    assert texts(m)["at the end"] == "not known"


def test_words_of_answers_and_lengths():
    assert answer_name(Answer.LEAST_VIOLATING) == "least violating"
    assert answer_name(-1) == answer_name(len(Answer)) == "unknown"
    assert [length(x) for x in (1234.5, 3.25, 0.004, 2e-7, 0.0)] == [
        "1.234 km", "3.25 m", "4 mm", "0.2 um", "0 m"
    ]  # fmt: skip
