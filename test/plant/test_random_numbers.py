"""Counter-based random numbers: a function of their key, independent and normal."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.plant.random_numbers import LARGEST_SEED, standard_normals, uniforms

NUMBERS = st.integers(0, LARGEST_SEED)


DRAWS = pytest.mark.parametrize("draw", [standard_normals, uniforms])


@DRAWS
@given(NUMBERS, NUMBERS, st.text(max_size=20), NUMBERS, st.integers(1, 9))
def test_they_depend_on_the_key_alone_and_longer_draws_continue_shorter_ones(
    draw, seed, run, stream, step, count
):
    longer = draw(seed, run, stream, step, 2 * count)
    assert (draw(seed, run, stream, step, count) == longer[:count]).all()


@DRAWS
@given(NUMBERS, NUMBERS, st.integers(0, LARGEST_SEED - 1))
def test_every_part_of_the_key_matters(draw, seed, run, step):
    base = draw(seed, run, "a", step, 4)
    for other in (
        draw(seed ^ 1, run, "a", step, 4),
        draw(seed, run ^ 1, "a", step, 4),
        draw(seed, run, "b", step, 4),
        draw(seed, run, "a", step + 1, 4),
        draw(run, seed, "a", step, 4) if run != seed else -base - 1.0,
    ):
        assert not np.isin(base, other).any()


def test_steps_of_a_stream_are_normal_and_not_correlated():
    n = 20_000
    drawn = np.array([standard_normals(7, 0, "noise", k, 3) for k in range(n)])
    sure = 5.0 / np.sqrt(n)  # five deviations of a mean
    assert np.abs(drawn.mean(axis=0)).max() < sure
    assert np.abs(drawn.var(axis=0) - 1.0).max() < sure * np.sqrt(2.0)
    assert np.abs((drawn**4).mean(axis=0) - 3.0).max() < sure * np.sqrt(96.0)
    for lag in (1, 2, 10):
        assert np.abs((drawn[lag:] * drawn[:-lag]).mean(axis=0)).max() < sure
    assert np.abs((drawn * np.roll(drawn, 1, axis=1)).mean(axis=0)).max() < sure


def test_uniform_numbers_are_uniform_and_runs_are_not_correlated():
    n = 20_000
    drawn = np.array([uniforms(7, run, "campaign", 0, 3) for run in range(n)])
    sure = 5.0 / np.sqrt(n)
    assert drawn.min() >= 0.0
    assert drawn.max() < 1.0
    centered = np.sqrt(12.0) * (drawn - 0.5)
    assert np.abs(centered.mean(axis=0)).max() < sure
    assert np.abs((centered**2).mean(axis=0) - 1.0).max() < sure
    assert np.abs((centered[1:] * centered[:-1]).mean(axis=0)).max() < sure
    assert np.abs((centered * np.roll(centered, 1, axis=1)).mean(axis=0)).max() < sure


def test_the_generator_is_the_published_philox():
    """Philox-4x64-10 by its definition (Salmon et al. 2011), in plain integers."""
    mask = 2**64 - 1
    key, counter = [11, 12], [1, 13, 14, 0]  # NumPy counts up before it draws
    a, b = counter[:2], counter[2:]
    x = [*a, *b]
    for _ in range(10):
        high0, low0 = divmod(0xD2E7470EE14C6C93 * x[0], 2**64)
        high1, low1 = divmod(0xCA5A826395121157 * x[2], 2**64)
        x = [high1 ^ x[1] ^ key[0], low1, high0 ^ x[3] ^ key[1], low0]
        key = [(key[0] + 0x9E3779B97F4A7C15) & mask, (key[1] + 0xBB67AE8584CAA73B) & mask]
    drawn = np.random.Philox(key=[11, 12], counter=[0, 13, 14, 0]).random_raw(4)
    assert drawn.tolist() == x
