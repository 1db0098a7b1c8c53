"""Predictions of a formation against flights step by step, and between the samples."""

from __future__ import annotations

import math

import formations
import numpy as np
import pytest
from enumerated_shifts import flown

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.time_shift import Constraint, TimeShiftGovernor, fly
from spacecraft_gnc.governors.time_shift.prediction import Predictor

NO_LOSS = np.zeros(3, dtype=bool)
UNSHIFTED = np.zeros(3, dtype=np.int64)


@pytest.fixture(scope="module")
def problem():
    return formations.problem()


def states_off_the_plane(problem):
    states = formations.start(problem.natural)
    states[:, 2] = 300.0, -200.0, 100.0
    states[:, 5] = 0.1, 0.3, -0.2
    return states


@pytest.mark.parametrize("step", [0, 17])
def test_each_craft_is_predicted_under_each_shift(problem, step):
    states = states_off_the_plane(problem)
    predicted = Predictor(problem).predict(step, states, UNSHIFTED, NO_LOSS)
    for i in range(3):
        positions, _, pushes, cost = flown(problem, step, states[i], i)
        lengths = np.linalg.norm(pushes, axis=2)
        np.testing.assert_allclose(predicted.positions[i].transpose(0, 2, 1), positions, atol=1e-6)
        np.testing.assert_allclose(np.sqrt(predicted.delta_v[i]), lengths.max(axis=1), atol=1e-9)
        np.testing.assert_array_equal(predicted.delta_v_ahead[i], lengths.argmax(axis=1))
        np.testing.assert_allclose(predicted.cost[i], cost, rtol=1e-9)


def test_a_lost_craft_drifts(problem):
    states = states_off_the_plane(problem)
    lost = np.array([False, True, False])
    shifts = np.array([3, 7, 11])
    predicted = Predictor(problem).predict(4, states, shifts, lost)
    x = states[1]
    for k in range(problem.horizon + 1):
        np.testing.assert_allclose(predicted.positions[1, 7, :, k], x[:3], atol=1e-6)
        x = problem.state_map @ x
    assert list(np.flatnonzero(predicted.able[1])) == [7]


def test_margins_are_those_of_the_flight(problem):
    start, shifts = states_off_the_plane(problem), np.array([24, 29, 32])
    predictor = Predictor(problem)
    found = predictor.margins(predictor.predict(0, start, UNSHIFTED, NO_LOSS), shifts)
    flights = [flown(problem, 0, start[i], i) for i in range(3)]
    for margin in found:
        if margin.constraint == Constraint.DELTA_V:
            (i,) = margin.craft
            track = np.linalg.norm(flights[i][2][shifts[i]], axis=1)
            assert margin.share == pytest.approx(1.0 - margin.value / problem.max_delta_v)
            expected = track.max()
        else:
            i, j = margin.craft
            apart = flights[i][0][shifts[i]] - flights[j][0][shifts[j]]
            told = flights[i][1][shifts[i]] - flights[j][1][shifts[j]]
            if margin.constraint == Constraint.SEPARATION:
                track = np.linalg.norm(apart, axis=1)
                assert margin.share == pytest.approx(margin.value / 1000.0 - 1.0)
                expected = track.min()
            else:
                track = np.array(list(map(formations.angle_between, apart, told)))
                assert margin.share == pytest.approx(1.0 - margin.value / problem.max_angle)
                expected = track.max()
        assert margin.value == pytest.approx(expected, rel=1e-9)
        assert track[int(margin.ahead)] == pytest.approx(expected, rel=1e-9)
    assert len(found) == 9


def test_substeps_are_flown_between_the_samples():
    problem = formations.problem(substeps=4)
    start, shifts = states_off_the_plane(problem), np.array([24, 29, 32])
    predicted = Predictor(problem).predict(0, start, UNSHIFTED, NO_LOSS)
    part = formations.hill(formations.PERIOD / 50 / 4)
    x = start
    for k in range(problem.horizon):
        kicked = x.copy()
        kicked[:, 3:] += problem.delta_v(k, x, shifts)
        for j in range(4):
            for i in range(3):
                found = predicted.positions[i, shifts[i], :, 4 * k + j]
                np.testing.assert_allclose(found, kicked[i, :3], atol=1e-5)
            kicked = kicked @ part.T
        x = kicked


def test_substeps_keep_the_separation_between_the_samples():
    """The separation between samples is lower than at them; with substeps it is kept too."""
    start = formations.start(formations.ellipse(50))
    limit = 1664.0  # [m], which the flight of the figures keeps at the samples alone
    finest = [
        least_between_samples(formations.problem(min_separation=limit, substeps=m), start)
        for m in (1, 8)
    ]
    assert finest[0] < limit
    assert finest[1] >= limit


def least_between_samples(problem, start):
    """Return the least separation of the governed flight at 40 instants a sample [m]."""
    flight = fly(TimeShiftGovernor(problem, resolves_deadlocks=False), start, 60)
    part = formations.hill(formations.PERIOD / 50 / 40)
    near = math.inf
    for states, pushes in zip(flight.states, flight.delta_v, strict=True):
        x = states.copy()
        x[:, 3:] += pushes
        for _ in range(40):
            near = min(near, *(np.linalg.norm(x[i, :3] - x[j, :3]) for i, j in formations.PAIRS))
            x = x @ part.T
    return near


def test_a_state_map_without_a_root_takes_no_substeps():
    p = 2  # half a period a sample: the root is not unique, and none is real
    problem = formations.problem(p=p, phases=(0, 1), substeps=3, horizon=4, min_separation=0.0)
    with pytest.raises(ParameterError, match=r"substeps: .* give 1"):
        Predictor(problem)
