"""The set in which a prediction may end, and the number of steps that lead into it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from kalabic_loop import BODY, FEEDBACK, INERTIA, LIMIT, REFERENCES, H, predictor

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.governors.tail import Limits, Loop, ball, border, kronecker, tail_of
from spacecraft_gnc.loop import State

HOME = np.eye(3)
NONE = Limits(math.inf, math.inf, 0.588, math.inf)


def form_of(tail, state):
    """Return x . P x of a state for the reference I."""
    x = np.concatenate([lie.log(state.attitude), state.momentum])
    return x @ tail.form @ x


def random_states(tail, n, seed=1):
    """Return states inside the tail set, most of them near its border."""
    generator = np.random.default_rng(seed)
    x = generator.normal(size=(n, 6))
    size = np.sqrt(np.einsum("ni,ij,nj->n", x, tail.form, x))
    x *= (math.sqrt(tail.level) * generator.uniform(0.0, 1.0, n) ** 0.1 / size)[:, None]
    return [State(0, lie.exp(row[:3]), row[3:]) for row in x]


@pytest.mark.parametrize("substeps", [1, 3])
def test_the_linear_loop_is_the_derivative_of_the_true_one(substeps):
    skew = np.array([[10.0, 0.4, -0.3], [0.4, 8.0, 0.2], [-0.3, 0.2, 7.0]])
    feedback, body = AttitudeFeedback(0.1 * skew, 0.3, skew), RigidBody(skew, H)
    matrix, step = Loop(feedback, H, substeps).matrix(), 1e-5

    def after(x):
        state = State(0, lie.exp(x[:3]), x[3:])
        attitude, momentum = body.step(*state[1:], feedback.torque(state, HOME), substeps)
        return np.concatenate([lie.log(attitude), momentum])

    columns = [(after(step * e) - after(-step * e)) / (2.0 * step) for e in np.eye(6)]
    assert np.abs(np.transpose(columns) - matrix).max() < 1e-9


@pytest.mark.parametrize(("mass", "time"), [(1e-7, 1.0), (1e7, 1.0), (1.0, 1e4), (1e-9, 1e-3)])
def test_the_tail_set_is_the_same_in_other_units(mass, time):
    torque, momentum = mass / time**2, mass / time
    limits = NONE._replace(torque=LIMIT, momentum=0.05)
    plain = tail_of(Loop(FEEDBACK, H, 2), limits)
    law = AttitudeFeedback(torque * np.diag([0.1, 0.2, 0.3]), 0.2 / time, mass * INERTIA)
    scaled = Limits(torque * LIMIT, momentum * 0.05, torque * NONE.level, math.inf)
    tail = tail_of(Loop(law, H * time, 2), scaled)
    units = np.repeat([1.0, momentum], 3)
    assert tail.form * np.outer(units, units) / torque == pytest.approx(plain.form, rel=1e-9)
    assert tail.level / torque == pytest.approx(plain.level, rel=1e-9)
    assert tail.radius == pytest.approx(plain.radius, rel=1e-12)
    assert tail.growth == pytest.approx(plain.growth, rel=1e-9)  # of the same samples


@pytest.mark.parametrize(
    "limits", [NONE, NONE._replace(torque=LIMIT), NONE._replace(momentum=0.01)]
)
def test_inside_nothing_is_violated_and_the_set_is_not_left(limits):
    """2000 random states, other than those it was certified with."""
    tail = tail_of(Loop(FEEDBACK, H, 1), limits)
    assert tail.growth < 1.0
    for state in random_states(tail, 2000):
        torque = FEEDBACK.torque(state, HOME)
        after = State(1, *BODY.step(*state[1:], torque))
        assert form_of(tail, after) < form_of(tail, state) <= tail.level * (1 + 1e-12)
        assert np.linalg.norm(torque) < limits.torque
        assert np.linalg.norm(state.momentum) < limits.momentum
        assert FEEDBACK.lyapunov(state, HOME) < limits.level
        assert lie.angle_between(state.attitude, HOME) <= tail.widest * math.sqrt(tail.level)


def test_the_form_solves_its_equation():
    loop = Loop(FEEDBACK, H, 1)
    tail, matrix = tail_of(loop, NONE), loop.matrix()
    decrease = tail.radius * tail.form - matrix.T @ tail.form @ matrix
    energy = np.diag([0.5, 0.4, 0.3, 0.1, 0.125, 0.125])
    assert np.abs(decrease - tail.radius * energy).max() < 1e-9
    assert tail.radius == pytest.approx(np.abs(np.linalg.eigvals(matrix)).max())


def test_every_flight_from_the_border_of_the_invariant_set_arrives_in_time():
    tested = predictor(max_torque=0.0)
    states = border(FEEDBACK, tested.limits.level, 203)[3:]  # not those it was computed with
    least, kept = tested.tail.level_within(REFERENCES.steady_margin), 0
    for x in states:
        state = State(0, lie.exp(x[:3]), x[3:])
        assert FEEDBACK.lyapunov(state, HOME) == pytest.approx(tested.limits.level)
        for _ in range(tested.horizon):
            if form_of(tested.tail, state) <= least:
                kept += 1
                break
            state = State(0, *BODY.step(*state[1:], FEEDBACK.torque(state, HOME)))
    assert kept == len(states)


def test_the_horizon_suffices_where_fifty_steps_do_not():
    """The paper's figures: 60 steps or more are needed, which 50 are not."""
    assert predictor().horizon > 60
    assert predictor(horizon=50).horizon == 50
    assert predictor(horizon=50).tail is None


def test_a_narrow_steady_margin_takes_longer():
    narrow = ReferenceSet(REFERENCES.zones, 1e-4)
    assert predictor(narrow).horizon > predictor().horizon > predictor(ReferenceSet()).horizon


def test_near_a_zone_the_prediction_goes_on_until_the_loop_cannot_reach_it():
    """A reference 0.1 deg from the border: the tail set around it is that narrow."""
    reference = lie.exp(np.array([math.radians(59.9), 0.0, 0.0]))
    aside = State(0, reference @ lie.exp(np.array([0.0, 0.0, 0.02])), np.array([0.06, 0.0, 0.0]))
    found = predictor().predict(aside, reference)
    assert (found.admissible, found.constraint) == (False, "earth")
    inward = aside._replace(momentum=np.array([-0.06, 0.0, 0.0]))
    assert predictor().predict(inward, reference).violation_step > found.violation_step
    still = aside._replace(momentum=np.zeros(3))
    assert predictor().predict(still, reference).admissible


def test_points_fill_their_space_evenly():
    points = kronecker(1000, 3)
    assert np.histogramdd(points, bins=4, range=[(0, 1)] * 3)[0].min() >= 8  # 15.6 on average
    shells = ball(1000, 6, 4)
    assert np.allclose(np.unique(np.linalg.norm(shells, axis=1).round(12)), [0.25, 0.5, 0.75, 1.0])
    assert np.abs(shells.mean(axis=0)).max() < 0.02


def test_the_border_reaches_from_rest_to_pure_spin():
    states = border(FEEDBACK, 0.5, 500)
    kinetic = 0.5 * np.einsum("ni,ij,nj->n", states[:, 3:], np.linalg.inv(INERTIA), states[:, 3:])
    assert kinetic.min() < 0.01
    assert kinetic.max() > 0.49
