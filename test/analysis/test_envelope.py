"""A long series is drawn with fewer points, but no extreme is hidden."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.drawing import envelope

SAMPLES = st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=400).map(np.array)


@given(SAMPLES, st.integers(2, 60))
def test_least_and_greatest_value_of_every_interval_survive(values, points):
    times = np.arange(len(values), dtype=float)
    drawn = envelope.thin(times, values, points)
    assert len(drawn.times) <= max(points, 2)
    width = envelope.per_interval(len(values), points)
    for begin in range(0, len(values), width):
        part = values[begin : begin + width]
        inside = (drawn.times >= begin) & (drawn.times < begin + width)
        assert drawn.values[inside].max() == part.max()
        assert drawn.values[inside].min() == part.min()


@given(SAMPLES, st.integers(2, 60))
def test_only_samples_are_drawn_in_their_order(values, points):
    times = np.arange(len(values), dtype=float)
    drawn = envelope.thin(times, values, points)
    assert np.all(np.diff(drawn.times) >= 0.0)
    np.testing.assert_array_equal(values[drawn.times.astype(int)], drawn.values)


def test_a_short_series_is_drawn_in_full():
    times, values = np.arange(50.0), np.linspace(0.0, 1.0, 50)
    drawn = envelope.thin(times, values, 50)
    assert drawn.times is times
    assert drawn.values is values


def test_an_interval_that_was_lost_stays_a_gap():
    values = np.ones(1000)
    values[300:500] = np.nan
    values[777] = 9.0
    drawn = envelope.thin(np.arange(1000.0), values, 100)
    assert np.isnan(drawn.values[(drawn.times >= 300) & (drawn.times < 500)]).all()
    assert np.nanmax(drawn.values) == 9.0


@pytest.mark.parametrize("n", [1, 2, 10, 4001, 100_001])
def test_the_slider_has_the_first_and_the_last_state(n):
    chosen = envelope.strided(n, 4000)
    assert chosen[0] == 0
    assert chosen[-1] == n - 1
    assert len(chosen) <= 4001
