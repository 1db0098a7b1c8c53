"""Removal of redundant rows against one linear program for each row."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from periodic_loops import largest

from spacecraft_gnc.governors.periodic.redundancy import farthest, is_implied, needed_rows


def polyhedron(seed, d, m):
    """Return random polar rows, some of them inside the hull of others, and some repeated."""
    generator = np.random.default_rng(seed)
    rows = generator.normal(size=(m, d)) * generator.uniform(0.3, 3.0, size=(m, 1))
    mixed = 0.5 * rows[: m // 3] + 0.4 * rows[m // 3 : 2 * (m // 3)]
    return np.vstack([rows, mixed, rows[:2], 0.5 * rows[2:4], np.zeros((1, d))])


@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(6, 40))
def test_rows_stay_exactly_if_linear_programs_need_them(seed, d, m):
    rows = polyhedron(seed, d, m)
    found = needed_rows(rows, 1e-9).indices
    first = len(rows) - 5  # of what repeats others only
    assert found.max() < first
    for i in range(first):
        others = np.delete(rows[:first], i, axis=0)
        over = largest(rows[i], others, np.ones(len(others)))
        assert abs(over - 1.0) < 1e-6 or (over > 1.0) == (i in found)


@given(st.integers(0, 10**6), st.integers(1, 5))
def test_units_and_blind_directions_change_nothing(seed, d):
    rows = polyhedron(seed, d, 20)
    scale = 10.0 ** np.random.default_rng(seed).integers(-3, 4, size=d)
    blind = np.column_stack([rows * scale, np.zeros(len(rows))])
    assert np.array_equal(needed_rows(rows, 1e-9).indices, needed_rows(blind, 1e-9).indices)


def test_an_implied_row_is_told_from_one_that_is_not():
    square = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    assert is_implied(np.array([0.5, 0.5]), square, 1e-9)
    assert not is_implied(np.array([0.5, 0.5 + 1e-6]), square, 1e-9)
    assert farthest(np.array([2.0, 1.0]), square) == 3.0
    assert farthest(np.array([2.0, 1.0]), square[:1]) == np.inf
    assert not is_implied(np.array([2.0, 1.0]), square[:1], 1e-9)
    assert len(needed_rows(np.empty((0, 3)), 1e-9).indices) == 0


@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(6, 40))
def test_each_ray_meets_its_row_first_and_finds_it_again(seed, d, m):
    rows = polyhedron(seed, d, m)
    found = needed_rows(rows, 1e-9)
    along = found.rays @ rows.T
    others = along.copy()
    for i, own in enumerate(found.indices):
        same = np.abs(rows - rows[own]).max(axis=1) < 1e-12
        others[i, same] = 0.0
        assert along[i, own] == pytest.approx(1.0, abs=1e-6) or along[i, own] > 1.0
        assert along[i, own] > others[i].max()
    again = needed_rows(rows, 1e-9, found.rays)
    assert np.array_equal(again.indices, found.indices)
