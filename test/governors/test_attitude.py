"""The reference governor: the published flight, its guarantees, and what it does in trouble."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from kalabic_loop import BODY, EARTH, FEEDBACK, LIMIT, REFERENCES, START, fly, governor, predictor
from strategies import rotations, vectors

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError, ParameterError
from spacecraft_gnc.governors.attitude import AttitudeGovernor
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.loop import State
from spacecraft_gnc.ocp import PointingZone
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.shipped import shipped

HOME = np.eye(3)
SUN = PointingZone("exclusion", [1, 0, 0], [0, 1, 0], math.radians(20.0), 1.0)
STEADY = math.radians(0.1)


def first_for_good(time, error, bound):
    """Return the time from which on ``error`` stays below ``bound``."""
    return time[np.flatnonzero(error >= bound)[-1] + 1]


# --- the published flight ------------------------------------------------------------------


@pytest.fixture(scope="module")
def flight():
    """The shipped scenario."""
    return load(shipped("kalabic2014_governor")).build().run()


def test_the_published_flight(flight):
    error = np.degrees(lie.angles_between(flight.attitude, HOME))
    assert flight.alpha[0] == pytest.approx(0.043, abs=5e-4)
    assert flight.time[np.argmax(flight.alpha == 1.0)] == pytest.approx(60.5, abs=0.3)
    assert first_for_good(flight.time, error, 1.0) == pytest.approx(75.1, abs=0.3)
    assert first_for_good(flight.time, error, 0.1) == pytest.approx(93.3, abs=0.3)
    torque = np.linalg.norm(flight.torque, axis=1)
    assert 0.0199 < torque.max() <= LIMIT
    assert flight.attitude[:, 2, 2].min() == pytest.approx(0.5446, abs=1e-4)
    assert np.all(flight.alpha[np.argmax(flight.alpha == 1.0) :] == 1.0)
    assert flight.governor_margin.min() >= 0.0


def test_without_the_governor_the_torque_is_twenty_times_the_limit():
    torques = load(shipped("kalabic2014_ungoverned")).build().run().torque
    assert np.linalg.norm(torques, axis=1).max() == pytest.approx(0.392, abs=2e-3)


@pytest.mark.parametrize(("horizon", "torque"), [(50, 0.0238), (20, 0.0507)])
def test_a_horizon_that_is_too_short_lets_the_torque_pass_the_limit(horizon, torque):
    overrides = [f"reference_governor.prediction_horizon={horizon}", "plant.duration=60.0"]
    torques = load(shipped("kalabic2014_governor"), overrides).build().run().torque
    assert np.linalg.norm(torques, axis=1).max() == pytest.approx(torque, rel=5e-3)


# --- guarantees ----------------------------------------------------------------------------


def random_flight(predictor, momentum, generator):
    """Return governor and start of a random flight that can be begun and needs no way round."""

    def turn():
        return lie.exp(generator.uniform(0.0, 1.0) * _direction(generator))

    references = predictor.reference_set
    while True:
        start, target = turn(), turn()
        vector = lie.log(target @ start.T)
        between = np.array([lie.exp(s * vector) @ start for s in np.linspace(0.0, 1.0, 33)])
        if references.margins(between).min() < 2.0 * STEADY:
            continue
        spin = generator.uniform(0.0, 0.8) * momentum * _direction(generator)
        state = State(0, start, spin)
        if predictor.predict(state, start).admissible:
            return AttitudeGovernor(predictor, references, target, alpha_tolerance=1e-4), state


def _direction(generator):
    vector = generator.normal(size=3)
    return vector / np.linalg.norm(vector)


@pytest.mark.parametrize("batch", range(8))
def test_200_random_flights_violate_nothing_stay_feasible_and_arrive(batch):
    generator = np.random.default_rng(batch)
    max_torque, max_momentum = generator.uniform(0.1, 0.4), generator.uniform(0.3, 1.0)
    references = ReferenceSet((EARTH, SUN), STEADY, ("earth", "sun"))
    ahead = predictor(references, max_torque=max_torque, max_momentum=max_momentum)
    for i in range(25):
        law, start = random_flight(ahead, max_momentum, generator)
        held, arrives = None, False
        for now, decision, torque in fly(law, start, 1500):
            assert decision.admissible, i
            if held is not None:  # recursive feasibility: the last reference can be held
                assert ahead.predict(now, held).admissible, i
            held = decision.reference.attitude
            assert np.linalg.norm(torque) <= max_torque + 1e-9, i
            assert np.linalg.norm(now.momentum) <= max_momentum + 1e-9, i
            assert references.margin(now.attitude)[0] >= -1e-9, i
            assert FEEDBACK.lyapunov(now, held) <= FEEDBACK.unstable_level, i
            if np.array_equal(held, law.target):
                arrives = True  # the prediction to there has ended in the tail set
                break
        assert arrives, i


@settings(max_examples=15)
@given(rotations(), vectors(0.08), rotations())
def test_from_any_start_that_can_be_held_nothing_is_violated(attitude, momentum, target):
    """Without zones, to targets up to half a turn away."""
    law = governor(target, ReferenceSet())
    state = State(0, attitude, momentum)
    if not law.predictor.predict(state, attitude).admissible:
        return
    for now, decision, torque in fly(law, state, 60):
        assert decision.admissible
        assert decision.margin >= 0.0
        assert np.linalg.norm(torque) <= LIMIT + 1e-12
        assert FEEDBACK.lyapunov(now, decision.reference.attitude) <= law.predictor.limits.level
        moved = decision.reference.attitude
        assert np.linalg.norm(moved.T @ moved - HOME) < 1e-14


def test_references_stay_orthonormal_and_on_the_shortest_geodesic(flight):
    defects = np.einsum("nji,njk->nik", flight.reference, flight.reference) - HOME
    assert np.abs(defects).max() < 1e-14
    axis = np.array([0.8, 0.6, 0.0])
    vectors = np.array([lie.log(reference) for reference in flight.reference])
    assert (
        np.abs(vectors - np.outer(vectors @ axis, axis)).max() < 1e-10
    )  # the axis is written to 1e-10
    assert np.all(np.diff(vectors @ axis) <= 1e-15)


# --- what a decision tells -----------------------------------------------------------------


def test_a_decision_tells_what_limits_it_and_when():
    law = governor()
    law.warm_up()
    decision = law.decide(START)
    assert decision.active_constraint == "torque limit"
    assert decision.violation_step == 0  # from rest the torque is largest at once
    assert 0.0 <= decision.margin < 1e-6
    assert decision.evaluations == 21  # alpha = 1, and 20 halvings down to 1e-6
    assert decision.horizon == law.predictor.horizon
    assert np.array_equal(decision.reference.angular_velocity, np.zeros(3))
    alone = predictor().predict(START, decision.reference.attitude)
    assert alone.margin == pytest.approx(decision.margin, abs=1e-10)
    later = [d for _, d, _ in fly(law, START, 100)][-1]
    assert later.active_constraint == "torque limit"
    assert 0 < later.violation_step < 60


def test_the_alpha_is_the_largest_admissible():
    law = governor()
    alpha = law.decide(START).alpha
    vector = lie.log(START.attitude.T)  # to I
    beyond = lie.exp((alpha + 1e-6) * vector) @ START.attitude
    within = lie.exp((alpha - 1e-6) * vector) @ START.attitude
    assert not law.predictor.predict(START, beyond).admissible
    assert law.predictor.predict(START, within).admissible


def test_at_the_target_one_prediction_tells_the_margin():
    law = governor()
    decision = law.decide(State(0, HOME, np.zeros(3)))
    assert (decision.alpha, decision.admissible, decision.evaluations) == (1.0, True, 1)
    assert decision.margin == pytest.approx(LIMIT)
    assert (decision.active_constraint, decision.violation_step) == ("", -1)
    assert np.array_equal(decision.reference.attitude, HOME)


def test_the_first_reference_is_the_attitude_or_what_is_given():
    near = State(0, lie.exp(np.array([0.02, 0.0, 0.0])), np.zeros(3))
    away = lie.exp(np.array([0.0, 0.05, 0.0]))
    law = governor(lie.exp(np.array([0.0, 1.0, 0.0])), first=away)
    assert lie.angle_between(law.decide(near).reference.attitude, away) < 0.05
    law.reset()
    again = law.decide(near)
    law.reset()
    assert np.array_equal(law.decide(near).reference.attitude, again.reference.attitude)


# --- cut points ----------------------------------------------------------------------------


@pytest.mark.parametrize("off", [0.0, 1e-9, -1e-9])
def test_half_a_turn_is_made_one_way_to_the_end(off):
    """(15): the target moves off the cut point, and back once the reference has left it."""
    law = governor(lie.exp(np.array([0.0, 0.0, math.pi + off])), max_torque=0.3)
    start = State(0, HOME, np.zeros(3))
    references = [d.reference.attitude for _, d, _ in fly(law, start, 700)]
    turns = np.unwrap([lie.log(r)[2] for r in references])
    assert np.all(np.diff(turns) * np.sign(turns[-1]) >= -1e-12)  # never back
    assert abs(turns[-1]) == pytest.approx(math.pi, abs=1e-6)
    assert np.array_equal(references[-1], law.target)


# --- trouble -------------------------------------------------------------------------------


def test_a_push_is_told_and_the_reference_held_until_it_is_over():
    law = governor()
    states = [state for state, _, _ in fly(law, START, 20)]
    reference = law.decide(states[-1]).reference.attitude
    pushed = states[-1]._replace(momentum=np.array([0.2, 0.0, 0.0]))
    decisions = [d for _, d, _ in fly(law, pushed, 900)]
    assert not decisions[0].admissible
    assert decisions[0].alpha == 0.0
    assert decisions[0].active_constraint == "torque limit"
    assert decisions[0].violation_step == 0
    assert decisions[0].margin < 0.0
    assert np.array_equal(decisions[0].reference.attitude, reference)
    assert decisions[-1].admissible
    assert decisions[-1].alpha == 1.0


def test_a_state_that_is_none_raises_nothing():
    law = governor()
    nowhere = State(0, np.full((3, 3), np.nan), np.zeros(3))
    assert not law.decide(nowhere).admissible
    good = law.decide(START).reference.attitude
    decision = law.decide(nowhere)
    assert not decision.admissible
    assert np.array_equal(decision.reference.attitude, good)


def test_targets_outside_the_set_are_refused_and_change_nothing():
    law = governor()
    outside = lie.exp(np.array([math.radians(70.0), 0.0, 0.0]))
    with pytest.raises(GncError, match=r"target: .* margin of -10 deg to zone 'earth'"):
        law.set_target(outside)
    with pytest.raises(ParameterError, match="target"):
        law.set_target(np.diag([1.0, 1.0, -1.0]))
    assert np.array_equal(law.target, HOME)
    wanted = lie.exp(np.array([0.1, 0.0, 0.0]))
    law.set_target(wanted)
    assert np.array_equal(law.target, wanted)
    law.reset()
    assert np.array_equal(law.target, HOME)
    with pytest.raises(ParameterError, match=r"target: .*'earth'"):
        governor(outside)
    with pytest.raises(ParameterError, match=r"initial_reference: .*'earth'"):
        governor(first=outside)


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("plant.initial_momentum=[0.2, 0.0, 0.0]", "the feedback law commands 0.04 N m"),
        ("plant.initial_momentum=[0.0999, 0.0, 0.0]", "violates 'torque limit' at predicted step"),
        ("reference_governor.max_momentum=1.0e-3", None),
        ("reference_governor.lyapunov_level=0.7", "required less than 0.6 J"),
        ("reference_governor.initial_reference_rotation_vector=[0.0, 0.0, 0.0]", "at the start"),
        ("reference_governor.target_rotation_vector=[1.0471, 0.0, 0.0]", "choose another target"),
        ("plant.initial_rotation_vector=[1.0471, 0.0, 0.0]", "choose another start"),
    ],
)
def test_what_cannot_be_flown_is_refused_before_the_flight(override, said):
    if said is None:
        load(shipped("kalabic2014_governor"), [override]).build()
        return
    with pytest.raises(GncError, match=said):
        load(shipped("kalabic2014_governor"), [override]).build()


def test_numbers_outside_their_range_are_refused():
    for name in ("alpha_tolerance", "cut_point_shift"):
        with pytest.raises(ParameterError, match=f"{name}: received 1.0; required a number in"):
            AttitudeGovernor(predictor(), REFERENCES, HOME, **{name: 1.0})


# --- the way round -------------------------------------------------------------------------


class Way:
    """A planner with one answer."""

    def __init__(self, clear, way):
        self.clear, self.way, self.asked = clear, way, 0

    def warm_up(self):
        """Nothing to prepare."""

    def is_clear(self, start, end):
        """As told."""
        del start, end
        return self.clear

    def plan(self, start, end):
        """As told."""
        del start, end
        self.asked += 1
        return self.way


def test_intermediate_references_are_made_one_after_the_other():
    way = tuple(lie.exp(np.array(v)) for v in ([0.0, 0.3, 0.0], [0.3, 0.3, 0.0]))
    planner = Way(False, way)
    law = governor(lie.exp(np.array([0.3, 0.0, 0.0])), planner=planner, max_torque=0.05)
    law.warm_up()
    flown = [d for _, d, _ in fly(law, State(0, HOME, np.zeros(3)), 600)]
    left = [d.waypoints for d in flown]
    assert left[0] == 2
    assert left[-1] == 0
    assert all(before - after in (0, 1) for before, after in pairwise(left))
    for turn in (*way, law.target):
        assert any(np.array_equal(d.reference.attitude, turn) for d in flown)
    assert planner.asked == 1
    law.set_target(HOME)  # forgets the way
    planner.clear = True
    assert law.decide(State(400, law.target, np.zeros(3))).waypoints == 0


def test_without_a_way_the_reference_is_held_and_the_zone_named():
    across = PointingZone("exclusion", [1, 0, 0], [1, 1, 0], 0.1, 1.0)
    references = ReferenceSet((across,), STEADY, ("sun",))
    planner = Way(False, None)
    target = lie.exp(np.array([0.0, 0.0, math.pi / 2]))
    law = governor(target, references, planner)
    for state, decision, _ in fly(law, State(0, HOME, np.zeros(3)), 5):
        assert (decision.alpha, decision.admissible) == (0.0, True)
        assert decision.active_constraint == "sun"
        assert np.array_equal(decision.reference.attitude, HOME)
        assert lie.angle_between(state.attitude, HOME) < 1e-12
    assert planner.asked == 1


def test_stuck_before_a_zone_a_way_is_asked_for():
    """Where the planner had thought the geodesic clear."""
    across = PointingZone("exclusion", [1, 0, 0], [1, 1, 0], 0.1, 1.0)
    references = ReferenceSet((across,), STEADY, ("sun",))
    planner = Way(True, (lie.exp(np.array([0.0, -0.5, 0.0])),))
    target = lie.exp(np.array([0.0, 0.0, math.pi / 2]))
    law = governor(target, references, planner, max_torque=0.3)
    flown = [d for _, d, _ in fly(law, State(0, HOME, np.zeros(3)), 900)]
    assert planner.asked >= 1
    assert any(d.active_constraint == "sun" and d.waypoints == 0 for d in flown)
    assert any(d.waypoints == 1 for d in flown)
    assert min(references.margin(d.reference.attitude)[0] for d in flown) >= STEADY


def test_the_governed_body_is_the_predicted_one():
    """The helper flies what the governor predicts."""
    assert BODY.time_step == predictor().loop.time_step
