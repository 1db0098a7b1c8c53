"""The governor: constraints kept, optimal answers, and the last reference held."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from periodic_loops import kept, random_loop

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.governors.periodic import PeriodicGovernor, admissible_sets

ROUNDING = 1e-6  # of slacks, over flights of many steps
SEEDS = st.integers(0, 10**6)
PERIODS = st.integers(1, 3)


def governed(seed, p, q=2):
    loop, constraints = random_loop(seed, p, q=q)
    sets = admissible_sets(loop, constraints)
    return loop, constraints, sets, PeriodicGovernor(sets, np.arange(1.0, q + 1.0))


def slack_of(constraints, k, x, v):
    i = k % len(constraints.bounds)
    rows = constraints.state_rows[i] @ x + constraints.reference_rows[i] @ v
    return (constraints.bounds[i] - rows).min()


@given(SEEDS, PERIODS)
def test_constraints_are_kept_whatever_is_wished_for(seed, p):
    loop, constraints, sets, governor = governed(seed, p)
    generator = np.random.default_rng(seed)
    x, wish, limited = sets.inside[0][:2], np.zeros(2), 0
    for k in range(40):
        if k % 7 == 0:
            wish = 3.0 * generator.normal(size=2)
        decision = governor.decide(k, x, wish)
        assert decision.status == "optimal"
        assert not decision.held
        assert sets.contains(k, x, decision.reference, ROUNDING)
        assert slack_of(constraints, k, x, decision.reference) > -ROUNDING
        limited += bool(decision.active)
        x = loop.step(k, x, decision.reference)
    assert limited > 0


@given(SEEDS, PERIODS)
def test_each_answer_satisfies_the_optimality_conditions(seed, p):
    loop, _, sets, governor = governed(seed, p)
    generator = np.random.default_rng(seed)
    x, weight = sets.inside[0][:2], np.array([1.0, 2.0])
    for k in range(10):
        wish = 3.0 * generator.normal(size=2)
        decision = governor.decide(k, x, wish)
        v, o = decision.reference, sets.at(k)
        slacks = o.slacks(x, v)
        gradient = weight * (v - wish)
        for row in decision.active:
            assert row.multiplier > 0.0
            assert slacks[row.row] == pytest.approx(0.0, abs=ROUNDING)
            assert row.name == sets.names[o.constraint[row.row]]
            assert row.ahead == o.ahead[row.row]
            gradient = gradient + row.multiplier * o.reference_rows[row.row]
        assert np.abs(gradient).max() < ROUNDING * (1.0 + np.abs(wish).max())
        room = o.slacks(sets.inside[k % p][:2], sets.inside[k % p][2:])
        assert decision.slack == pytest.approx((slacks / room).min())
        assert decision.constraint in sets.names
        x = loop.step(k, x, v)


@given(SEEDS, PERIODS)
def test_an_admissible_reference_that_is_held_stays_admissible(seed, p):
    loop, constraints, sets, governor = governed(seed, p)
    generator = np.random.default_rng(seed)
    k = int(generator.integers(p))
    x = sets.inside[k][:2]
    v = governor.decide(k, x, 5.0 * generator.normal(size=2)).reference  # on the border
    assert kept(loop, constraints, k, x[None], v[None])[0] > -ROUNDING
    for j in range(k, k + 5 * p + 20):
        assert sets.contains(j, x, v, ROUNDING)
        x = loop.step(j, x, v)


def test_a_disturbance_that_leaves_no_reference_holds_the_last_one():
    loop, constraints, sets, governor = governed(4, 3)
    x, wish, states = sets.inside[0][:2], np.array([3.0, -2.0]), []
    last, held = None, 0
    for k in range(60):
        if k == 10:
            x = x + np.array([3.0, 3.0])
            assert slack_of(constraints, k, x, last) < 0.0
        decision = governor.decide(k, x, wish)
        if decision.held:
            held += 1
            assert decision.status == "infeasible"
            assert decision.active == ()
            assert decision.slack < 0.0
            assert np.array_equal(decision.reference, last)
        else:
            last = decision.reference
        assert governor.reference is not None
        states.append(decision.held)
        x = loop.step(k, x, decision.reference)
    assert states[10]
    assert 0 < held < 40
    assert not any(states[:10])
    assert not states[-1]  # the held reference has led back into the set


def test_a_wish_that_is_admissible_in_steady_state_is_reached():
    loop, _, sets, governor = governed(2, 2)
    wish = sets.inside[0][2:] + 0.05
    x = 0.5 * sets.inside[0][:2]
    for k in range(200):
        decision = governor.decide(k, x, wish)
        x = loop.step(k, x, decision.reference)
    assert np.array_equal(decision.reference, wish)
    assert decision.iterations == 0
    assert decision.active == ()


def test_a_start_without_an_admissible_reference_is_refused_with_the_reason():
    _, _, _, governor = governed(2, 2)
    with pytest.raises(ParameterError, match=r"state: .* step 5 .* % of the room: 'state 0 \+' at"):
        governor.decide(5, [30.0, 0.0], [0.0, 0.0])
    governor.reset([0.0, 0.0])
    assert governor.decide(5, [30.0, 0.0], [1.0, 1.0]).held
    governor.reset()
    assert governor.reference is None


def test_bad_arguments_are_refused():
    _, _, sets, governor = governed(2, 2)
    with pytest.raises(ParameterError, match="weight: received one of 3"):
        PeriodicGovernor(sets, np.ones(3))
    with pytest.raises(ShapeError, match="state"):
        governor.decide(0, [0.0], [0.0, 0.0])
    with pytest.raises(ParameterError, match=r"wish: .* finite"):
        governor.decide(0, [0.0, 0.0], [0.0, np.nan])
    with pytest.raises(ShapeError, match="reference"):
        PeriodicGovernor(sets, np.ones(2), [1.0])
