"""Design of a campaign: each point depends on its run alone, and fills its stratum."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kstest

from spacecraft_gnc.campaign.criterion import Criterion
from spacecraft_gnc.campaign.design import Design
from spacecraft_gnc.campaign.distributions.components import Components
from spacecraft_gnc.campaign.distributions.discrete import Choice
from spacecraft_gnc.campaign.distributions.laws import Uniform
from spacecraft_gnc.campaign.sampling import SAMPLINGS
from spacecraft_gnc.campaign.variations import Variations
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.plant.random_numbers import LARGEST_SEED, uniforms

SEEDS = st.integers(0, LARGEST_SEED)
CONTINUA = ("random", "latin_hypercube", "sobol")


def variations(sampling: str, runs: int | None = 64, dimensions: int = 3) -> Variations:
    scalar = Components((Uniform(0.0, 1.0),), is_list=False)
    distributions = (scalar,) * dimensions
    if sampling == "grid":
        distributions = (
            Choice((1.0, 2.0)),
            Choice(("x",)),
            Choice((1, 2, 3)),
            Choice((False, True)),
        )
    return Variations(
        path="v.yaml",
        text="",
        sampling=sampling,
        runs=runs,
        worst=3,
        criterion=Criterion.parse("a < 1"),
        names=tuple(f"plant.x{i}" for i in range(len(distributions))),
        distributions=distributions,
    )


@pytest.mark.parametrize("sampling", SAMPLINGS)
@settings(deadline=None, max_examples=25)
@given(seed=SEEDS, data=st.data())
def test_a_point_depends_on_its_run_alone(sampling, seed, data):
    runs = 12 if sampling == "grid" else 40
    whole = Design(variations(sampling), seed, runs).points(0, runs)
    assert whole.shape == (runs, 3)
    assert (whole >= 0.0).all()
    assert (whole < 1.0).all()
    design = Design(variations(sampling), seed, runs)
    alone = [design.points(run, 1)[0] for run in reversed(range(runs))]
    assert (alone[::-1] == whole).all()
    for _ in range(4):  # blocks in any order, again and again
        first = data.draw(st.integers(0, runs - 1))
        count = data.draw(st.integers(0, runs - first))
        assert (design.points(first, count) == whole[first : first + count]).all()


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_more_runs_keep_the_points_of_fewer(sampling):
    few = Design(variations(sampling), 5, 10).points(0, 10)
    many = Design(variations(sampling), 5, 10_000)
    assert (many.points(0, 10) == few).all()
    assert (many.points(9_000, 3) == Design(variations(sampling), 5, 9_003).points(9_000, 3)).all()


@pytest.mark.parametrize("sampling", CONTINUA)
def test_another_seed_gives_other_points(sampling):
    first, second = (Design(variations(sampling), seed, 64).points(0, 64) for seed in (1, 2))
    assert not (first == second).any()


def test_random_points_are_the_uniforms_of_seed_and_run():
    points = Design(variations("random"), 11, 50).points(20, 2)
    expected = [uniforms(11, run, "campaign", 0, 3) for run in (20, 21)]
    assert (points == expected).all()


@pytest.mark.parametrize("sampling", CONTINUA)
def test_every_number_is_uniform_and_none_is_correlated(sampling):
    n = 4096
    points = Design(variations(sampling), 3, n).points(0, n)
    for column in points.T:
        assert kstest(column, "uniform").pvalue > 1e-3
    correlation = np.corrcoef(points.T) - np.eye(3)
    assert np.abs(correlation).max() < 5.0 / np.sqrt(n)


@given(seed=SEEDS, runs=st.integers(1, 200))
def test_each_run_of_a_latin_hypercube_has_strata_of_its_own(seed, runs):
    points = Design(variations("latin_hypercube"), seed, runs).points(0, runs)
    for column in points.T:
        assert sorted(np.floor(column * runs)) == list(range(runs))


@settings(deadline=None)
@given(seed=SEEDS, power=st.integers(0, 8), block=st.integers(0, 3))
def test_each_aligned_block_of_a_sobol_sequence_is_stratified(seed, power, block):
    n = 2**power
    points = Design(variations("sobol"), seed, 4 * n).points(block * n, n)
    for column in points.T:
        assert sorted(np.floor(column * n)) == list(range(n))
    half, rest = (
        2 ** (power // 2),
        2 ** (power - power // 2),
    )  # the first two numbers: a (0, m, 2)-net
    boxes = {(int(a * half), int(b * rest)) for a, b in points[:, :2]}
    assert len(boxes) == n


def test_a_grid_takes_every_combination_once_the_last_parameter_fastest():
    grid = variations("grid", runs=None)
    assert grid.grid_size == 12
    design = Design(grid)
    assert design.runs == 12
    rows = [tuple(grid.values(point).values()) for point in design.points(0, 12)]
    assert rows == [(a, "x", b, c) for a in (1.0, 2.0) for b in (1, 2, 3) for c in (False, True)]


@given(st.lists(st.integers(1, 40), min_size=1, max_size=4), st.data())
def test_the_cell_of_any_grid_comes_back(sizes, data):
    choices = tuple(Choice(tuple(range(size))) for size in sizes)
    names = tuple(f"plant.x{i}" for i in range(len(sizes)))
    grid = dataclasses.replace(variations("grid", runs=None), names=names, distributions=choices)
    cell = [data.draw(st.integers(0, size - 1)) for size in sizes]
    run = int(np.ravel_multi_index(cell, sizes))
    assert list(grid.values(Design(grid).points(run, 1)[0]).values()) == cell


def test_the_number_of_runs_is_the_users_else_the_files():
    assert Design(variations("random")).runs == 64
    assert Design(variations("random"), runs=7).runs == 7
    with pytest.raises(ParameterError, match="runs: received nothing"):
        Design(variations("random", runs=None))


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ({"runs": 0}, "runs: received 0"),
        ({"runs": -1}, "runs: received -1"),
        ({"runs": 1.5}, "runs: received 1.5"),
        ({"runs": 10**10}, "runs: received 10000000000"),
        ({"seed": -1}, "seed: received -1"),
        ({"seed": 2**63}, "seed: received 9223372036854775808"),
    ],
)
def test_numbers_out_of_range_are_refused(arguments, reason):
    with pytest.raises(ParameterError, match=reason):
        Design(variations("random"), **arguments)


def test_a_grid_has_no_more_runs_than_cells():
    with pytest.raises(ParameterError, match="runs: received 13; required at most the 12 cells"):
        Design(variations("grid", runs=None), runs=13)
    assert Design(variations("grid", runs=None), runs=5).points(0, 5).shape == (5, 3)


def test_runs_beyond_the_last_are_refused():
    with pytest.raises(ParameterError, match="count: received 2; required a whole number, 0 to 1"):
        Design(variations("random")).points(63, 2)


def test_nothing_to_vary_needs_no_numbers():
    for sampling in CONTINUA:
        assert Design(variations(sampling, dimensions=0)).points(3, 4).shape == (4, 0)


def test_the_last_runs_of_a_large_sobol_campaign_are_there():
    assert Design(variations("sobol"), 1, 10**9).points(10**9 - 2, 2).shape == (2, 3)
