"""Success rates with intervals, quantiles and histograms, against definitions and numpy."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from spacecraft_gnc.campaign import statistics as stats
from spacecraft_gnc.campaign.statistics import Binning, Coded
from spacecraft_gnc.errors import ParameterError

ANY = st.floats(-1e6, 1e6) | st.sampled_from([math.nan, math.inf, -math.inf, 0.0, 1.0])
COLUMNS = st.integers(1, 200).flatmap(lambda n: arrays(np.float64, n, elements=ANY))


def at_least(k, n, p):
    """Return P(X >= k) of a binomial X, in rational arithmetic."""
    p = Fraction(p)
    terms = (math.comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(k, n + 1))
    return sum(terms, Fraction(0))


@pytest.mark.parametrize("confidence", [0.9, 0.95, 0.99])
@pytest.mark.parametrize(("k", "n"), [(0, 7), (1, 1), (1, 29), (7, 7), (15, 148), (60, 61)])
def test_the_interval_is_that_of_the_definition(k, n, confidence):
    low, high = stats.clopper_pearson(k, n, confidence)
    tail = 0.5 * (1.0 - confidence)
    if k > 0:
        assert float(at_least(k, n, low)) == pytest.approx(tail, rel=1e-9)
    if k < n:
        assert float(1 - at_least(k + 1, n, high)) == pytest.approx(tail, rel=1e-9)
    assert (low == 0.0) == (k == 0)
    assert (high == 1.0) == (k == n)


@pytest.mark.parametrize(
    ("k", "n", "low", "high"),
    [
        (81, 263, 0.2527, 0.3676),
        (15, 148, 0.0578, 0.1617),
        (0, 20, 0.0000, 0.1684),
        (1, 29, 0.0009, 0.1776),
    ],
)
def test_the_interval_is_the_published_one(k, n, low, high):
    """Newcombe (1998), Statistics in Medicine 17, Table I, method 5."""
    assert stats.clopper_pearson(k, n) == pytest.approx((low, high), abs=5e-5)


@pytest.mark.parametrize("p", [0.01, 0.3, 0.5, 0.97])
def test_the_interval_covers_the_probability_as_often_as_it_says(p):
    n = 40
    low, high = stats.clopper_pearson_bounds(np.arange(n + 1), n)
    chance = [math.comb(n, k) * p**k * (1 - p) ** (n - k) for k in range(n + 1)]
    assert np.dot(chance, (low <= p) & (p <= high)) >= 0.95


def test_the_interval_of_a_million_runs_is_that_of_the_normal_approximation():
    n, k = 1_000_000, 973_000
    p = k / n
    width = 1.959964 * math.sqrt(p * (1 - p) / n)
    assert stats.clopper_pearson(k, n) == pytest.approx((p - width, p + width), abs=2e-6)


def test_nothing_is_known_of_no_run():
    assert stats.clopper_pearson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(("k", "n", "confidence"), [(-1, 3, 0.9), (4, 3, 0.9), (1, 3, 1.0)])
def test_what_is_no_count_is_refused(k, n, confidence):
    with pytest.raises(ParameterError, match="received"):
        stats.clopper_pearson(k, n, confidence)


@given(COLUMNS)
def test_histograms_are_those_of_numpy(values):
    binning = stats.binning(values)
    known = values[np.isfinite(values)]
    if binning is None:
        assert not known.size or np.ptp(known) <= 1e-12 * np.abs(known).max()
        return
    codes = binning.codes(values)
    passed = np.arange(len(values)) % 3 == 0
    counts = stats.tally(Coded(codes, binning), passed)
    first = binning.edges[0] if binning.categories is None else binning.categories[0]
    for k in (0, 1):
        some = values[(passed == k) & np.isfinite(values)]
        if binning.categories is None:
            expected = np.histogram(some, binning.edges)[0]
        else:
            expected = [np.count_nonzero(some == each) for each in binning.categories]
        np.testing.assert_array_equal(counts[:, k], expected)
    assert counts.sum() + np.count_nonzero(codes >= stats.BELOW) == len(values)
    np.testing.assert_array_equal(codes == stats.MISSING, ~np.isfinite(values))
    np.testing.assert_array_equal(codes == stats.BELOW, np.isfinite(values) & (values < first))


@given(COLUMNS, st.integers(0, 100))
def test_histograms_of_pairs_are_those_of_numpy(values, seed):
    x = np.random.default_rng(seed).normal(size=len(values))
    first, second = stats.binning(values), stats.binning(x)
    if first is None or second is None or first.labels:
        return
    passed = x > 0.0
    coded = Coded(first.codes(values), first), Coded(second.codes(x), second)
    counts = stats.tally_pair(*coded, passed)
    for k in (0, 1):
        some = (passed == k) & np.isfinite(values)
        expected = np.histogram2d(values[some], x[some], [first.edges, second.edges])[0]
        np.testing.assert_array_equal(counts[:, :, k], expected)


@pytest.mark.parametrize("factor", [2, 3])
def test_merged_bins_hold_what_their_parts_hold(factor):
    values = np.random.default_rng(3).normal(size=5000)
    binning = stats.binning(values)
    coded = Coded(binning.codes(values), binning).merged(factor)
    counts = stats.tally(coded, values > 0.5)
    expected = np.histogram(values, binning.edges[::factor])[0]
    np.testing.assert_array_equal(counts.sum(axis=1), expected)


def test_decades_are_divided_logarithmically():
    values = 10.0 ** np.random.default_rng(4).uniform(-6.0, 2.0, 3000)
    binning = stats.binning(values)
    assert binning.is_log
    np.testing.assert_allclose(np.diff(np.log(binning.edges)), np.diff(np.log(binning.edges))[0])
    assert (binning.edges[0], binning.edges[-1]) == (values.min(), values.max())
    assert not stats.binning(np.random.default_rng(4).uniform(size=3000)).is_log


def test_one_value_far_off_does_not_leave_the_rest_in_one_bin():
    values = np.append(np.random.default_rng(5).normal(size=3000), 1e9)
    binning = stats.binning(values)
    codes = binning.codes(values)
    assert codes[-1] == stats.ABOVE
    assert Coded(codes, binning).outside() == 1
    assert np.ptp(binning.edges) < 25.0


def test_few_repeated_values_are_categories():
    values = np.repeat([8.0, 5.0, 13.5], 10)
    binning = stats.binning(values)
    assert binning.labels == ("5", "8", "13.5")
    np.testing.assert_array_equal(binning.codes(values), np.repeat([1, 0, 2], 10))
    np.testing.assert_array_equal(binning.centers, [0.0, 1.0, 2.0])
    assert stats.binning(np.array([1.0, 2.0, 3.0])).labels == ()  # three runs, each its own


@pytest.mark.parametrize("values", [[], [math.nan], [2.0, 2.0], [1e301, -1e301]])
def test_what_does_not_vary_has_no_bins(values):
    assert stats.binning(np.array(values)) is None


def test_the_center_of_a_logarithmic_bin_is_its_geometric_mean():
    binning = Binning(np.array([1.0, 100.0, 1e4]), is_log=True)
    np.testing.assert_allclose(binning.centers, [10.0, 1000.0])


@given(COLUMNS)
def test_quantiles_are_those_of_the_numbers(values):
    known = values[np.isfinite(values)]
    found = stats.quantiles(values)
    if not known.size:
        assert found is None
    else:
        np.testing.assert_array_equal(found, np.quantile(known, stats.LEVELS))


def test_success_is_explained_by_what_decides_it_and_by_nothing_else():
    random = np.random.default_rng(6)
    cause, other = random.uniform(size=(2, 20_000))
    passed = cause < 0.7
    shares = []
    for values in (cause, other):
        binning = stats.binning(values)
        shares.append(stats.explained(stats.tally(Coded(binning.codes(values), binning), passed)))
    assert shares[0] > 0.9
    assert shares[1] < 0.002
    assert stats.explained(np.array([[0, 40], [60, 0]])) == 1.0
    assert stats.explained(np.array([[0, 40], [0, 60]])) == 0.0
    assert stats.explained(np.array([[1, 0], [0, 1]])) == 0.0  # each run its own bin


def test_the_share_explained_is_the_adjusted_ratio_of_an_analysis_of_variance():
    counts = np.array([[5, 15], [9, 11], [2, 28]])
    bins = [np.repeat([0.0, 1.0], row) for row in counts]
    every = np.concatenate(bins)
    within = sum(np.sum((each - each.mean()) ** 2) for each in bins)
    total = np.sum((every - every.mean()) ** 2)
    mean_within, mean_total = within / (len(every) - 3), total / (len(every) - 1)
    assert stats.explained(counts) == pytest.approx(1.0 - mean_within / mean_total)
