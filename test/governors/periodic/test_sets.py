"""The sets against simulation, linear programming and the classical recursion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from periodic_loops import kept, largest, random_loop, stacked, steady_slack

from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.governors.periodic import (
    EmptySetError,
    PeriodicConstraints,
    PeriodicLoop,
    SetOptions,
    admissible_sets,
)

SEEDS = st.integers(0, 10**6)
PERIODS = st.integers(1, 3)
ROUNDING = 1e-7  # of slacks of rows that a tolerance of 1e-9 leaves out, and of long products


@pytest.mark.parametrize("p", [1, 2, 3])
@pytest.mark.parametrize("seed", [3, 11])
def test_a_point_belongs_exactly_if_its_flight_keeps_the_constraints(p, seed):
    loop, constraints = random_loop(seed, p)
    sets = admissible_sets(loop, constraints)
    assert sets.determined
    generator = np.random.default_rng(1)
    for k in range(p):
        points = generator.uniform(-2.0, 2.0, size=(4000, 3))
        x, v = points[:, :2], points[:, 2:]
        truth = np.minimum(
            kept(loop, constraints, k, x, v), steady_slack(loop, constraints, v, 0.99)
        )
        rows, bounds = stacked(sets.at(k))
        slack = (bounds - points @ rows.T).min(axis=1)
        clear = np.abs(truth) > ROUNDING
        assert np.array_equal(slack[clear] > 0.0, truth[clear] > 0.0)
        assert (truth > 0.0).sum() > 20


@given(SEEDS, PERIODS, st.integers(1, 2))
def test_the_border_is_invariant_and_admissible(seed, p, q):
    loop, constraints = random_loop(seed, p, q=q)
    sets = admissible_sets(loop, constraints)
    assert sets.determined
    generator = np.random.default_rng(seed)
    for k in range(p):
        rows, bounds = stacked(sets.at(k))
        room = bounds - rows @ sets.inside[k]
        rays = generator.normal(size=(20, 2 + q))
        along = (rays @ rows.T / room).max(axis=1)
        border = sets.inside[k] + rays / np.maximum(along, 1e-3)[:, None]
        x, v = border[:, :2], border[:, 2:]
        assert kept(loop, constraints, k, x, v).min() > -ROUNDING
        for j in range(k, k + 2 * p + 1):
            for state, reference in zip(x, v, strict=True):
                assert sets.contains(j, state, reference, ROUNDING)
            x = np.array([loop.step(j, s, r) for s, r in zip(x, v, strict=True)])


def classical(loop, constraints, share):
    """O_infinity of Gilbert and Tan: rows ahead until those of the next step are redundant."""
    a, b = loop.state_map[0], loop.reference_map[0]
    c, d, bound = constraints.state_rows[0], constraints.reference_rows[0], constraints.bounds[0]
    steady = c @ np.linalg.solve(np.eye(len(a)) - a, b) + d
    rows = [np.hstack([np.zeros_like(c), steady])]
    bounds = [share * bound]
    while True:
        new = np.hstack([c, d])
        over = [largest(row, np.vstack(rows), np.concatenate(bounds)) for row in new]
        if (np.array(over) <= bound + 1e-9).all():
            return np.vstack(rows), np.concatenate(bounds)
        rows, bounds = [*rows, new], [*bounds, bound]
        c, d = c @ a, c @ b + d


@pytest.mark.parametrize("seed", range(4))
def test_a_time_invariant_loop_has_the_classical_set(seed):
    loop, constraints = random_loop(seed, 1, n=3, q=2)
    ours, our_bounds = stacked(admissible_sets(loop, constraints).at(0))
    theirs, their_bounds = classical(loop, constraints, 0.99)
    for row, bound in zip(ours, our_bounds, strict=True):
        assert largest(row, theirs, their_bounds) <= bound + ROUNDING
    for row, bound in zip(theirs, their_bounds, strict=True):
        assert largest(row, ours, our_bounds) <= bound + ROUNDING


def test_a_time_invariant_loop_called_periodic_has_the_same_sets():
    loop, constraints = random_loop(5, 1)
    one = admissible_sets(loop, constraints)
    three = admissible_sets(
        PeriodicLoop(np.tile(loop.state_map, (3, 1, 1)), np.tile(loop.reference_map, (3, 1, 1))),
        PeriodicConstraints(
            np.tile(constraints.state_rows, (3, 1, 1)),
            np.tile(constraints.reference_rows, (3, 1, 1)),
            np.tile(constraints.bounds, (3, 1)),
            constraints.names,
        ),
    )
    rows, bounds = stacked(one.at(0))
    for k in range(3):
        others, their_bounds = stacked(three.at(k))
        assert len(others) == len(rows)
        order, theirs = np.lexsort(rows.round(9).T), np.lexsort(others.round(9).T)
        assert np.allclose(rows[order], others[theirs], atol=1e-12)
        assert np.allclose(bounds[order], their_bounds[theirs])


@given(SEEDS, PERIODS)
def test_no_row_that_stays_is_redundant(seed, p):
    loop, constraints = random_loop(seed, p)
    sets = admissible_sets(loop, constraints)
    for k in range(p):
        rows, bounds = stacked(sets.at(k))
        room = bounds - rows @ sets.inside[k]
        for i in range(len(rows)):
            others = np.arange(len(rows)) != i
            assert largest(rows[i], rows[others], bounds[others]) > bounds[i] - 1e-6 * room[i]


def test_rows_tell_their_constraint_and_how_far_ahead_it_is_met():
    loop, constraints = random_loop(7, 3)
    sets = admissible_sets(loop, constraints)
    generator = np.random.default_rng(0)
    assert sets.horizon > 0
    for k in range(3):
        o = sets.at(k)
        x, v = generator.normal(size=2), generator.normal(size=1)
        states = [x]
        for j in range(sets.horizon):
            states.append(loop.step(k + j, states[-1], v))
        for slack, i, ahead in zip(o.slacks(x, v), o.constraint, o.ahead, strict=True):
            if ahead >= 0:
                phase = (k + ahead) % 3
                row = constraints.state_rows[phase, i] @ states[ahead]
                row += constraints.reference_rows[phase, i] @ v
                assert slack == pytest.approx(constraints.bounds[phase, i] - row, abs=1e-9)
    assert sets.at(4) is sets.at(1)


def test_a_recursion_cut_short_states_by_how_much_it_may_err():
    loop, constraints = random_loop(3, 2, radius=0.95)
    whole = admissible_sets(loop, constraints)
    short = admissible_sets(loop, constraints, SetOptions(most_steps=1))
    assert whole.determined
    assert whole.excess == 0.0
    assert not short.determined
    assert short.steps == 3
    assert 0.0 < short.excess < np.inf
    exceeded = 0.0
    for k in range(2):
        rows, bounds = stacked(short.at(k))
        a = np.block(
            [
                [loop.state_map[k], loop.reference_map[k]],
                [np.zeros((1, 2)), np.eye(1)],
            ]
        )
        later, their_bounds = stacked(short.at(k + 1))
        for row, bound in zip(later, their_bounds, strict=True):
            room = bound - row @ short.inside[(k + 1) % 2]
            exceeded = max(exceeded, (largest(row @ a, rows, bounds) - bound) / room)
    assert 0.0 < exceeded <= short.excess + 1e-6


def test_progress_is_told_after_each_backward_step():
    loop, constraints = random_loop(3, 2)
    told = []
    sets = admissible_sets(loop, constraints, progress=lambda *call: told.append(call))
    assert [call[0] for call in told] == list(range(1, sets.steps + 1))
    assert {call[1] for call in told} == {1002}
    assert told[-1][2] > 0


def test_a_row_without_a_bound_does_not_apply():
    loop, constraints = random_loop(3, 2)
    bounds = np.array(constraints.bounds)
    bounds[:, 0] = np.inf
    sets = admissible_sets(
        loop,
        PeriodicConstraints(
            constraints.state_rows, constraints.reference_rows, bounds, constraints.names
        ),
    )
    assert all((o.constraint != 0).all() for o in sets.sets)
    assert any((o.constraint == 1).any() for o in sets.sets)


def one_state(bounds, names=("low", "high")):
    return (
        PeriodicLoop(np.full((1, 1, 1), 0.5), np.full((1, 1, 1), 0.5)),
        PeriodicConstraints(
            np.array([[[-1.0], [1.0]]]), np.zeros((1, 2, 1)), np.array([bounds]), names
        ),
    )


def test_constraints_that_exclude_one_another_are_named():
    with pytest.raises(EmptySetError, match=r"'high', 'low', which no constant.* by 0.5") as told:
        admissible_sets(*one_state([-2.0, 1.0]), SetOptions(steady_share=1.0 - 1e-9))
    assert told.value.conflict == ("high", "low")
    with pytest.raises(EmptySetError, match="required a set with an interior"):
        admissible_sets(*one_state([-1.0, 1.0]))


def test_a_constraint_out_of_reach_of_every_reference_is_named():
    loop, constraints = one_state([1.0, 1.0])
    loop = PeriodicLoop(loop.state_map, np.zeros((1, 1, 1)))
    blocked = PeriodicConstraints(
        constraints.state_rows, constraints.reference_rows, np.array([[-0.1, 1.0]]), ("low", "high")
    )
    with pytest.raises(EmptySetError, match="'low', which no reference influences") as told:
        admissible_sets(loop, blocked)
    assert told.value.conflict == ("low",)


def test_bad_arguments_are_refused():
    _, constraints = random_loop(3, 2)
    with pytest.raises(ParameterError, match=r"state_map: .* spectral radius 1; required less"):
        PeriodicLoop(np.ones((2, 1, 1)), np.ones((2, 1, 1)))
    with pytest.raises(ShapeError, match=r"state_map: .* \(2, 1\); required square"):
        PeriodicLoop(np.ones((2, 2, 1)), np.ones((2, 2, 1)))
    with pytest.raises(ShapeError, match="reference_map"):
        PeriodicLoop(0.5 * np.ones((2, 1, 1)), np.ones((3, 1, 1)))
    with pytest.raises(ParameterError, match=r"state_map: .* finite"):
        PeriodicLoop(np.full((1, 1, 1), np.nan), np.ones((1, 1, 1)))
    rows = (constraints.state_rows, constraints.reference_rows)
    with pytest.raises(ParameterError, match="bounds: received NaN or minus infinity"):
        PeriodicConstraints(*rows, np.full((2, 6), np.nan), constraints.names)
    with pytest.raises(ShapeError, match="names: received 1; required 6"):
        PeriodicConstraints(*rows, constraints.bounds, ("one",))
    with pytest.raises(ShapeError, match="bounds: received an array"):
        PeriodicConstraints(*rows, np.ones((1, 6)), constraints.names)
    with pytest.raises(ShapeError, match=r"constraints: .*\(2, 2, 1\); required \(3, 2, 1\)"):
        admissible_sets(random_loop(3, 3)[0], constraints)
    with pytest.raises(ParameterError, match="steady_share"):
        SetOptions(steady_share=1.0)
    with pytest.raises(ParameterError, match="most_steps"):
        SetOptions(most_steps=0)
    with pytest.raises(ParameterError, match="tolerance"):
        SetOptions(tolerance=0.1)
