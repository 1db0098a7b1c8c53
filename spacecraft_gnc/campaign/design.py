"""Design of a campaign: the point in the unit cube that each run is made of."""

from __future__ import annotations

from functools import cached_property
from typing import Any, Final

import numpy as np

from spacecraft_gnc.arguments import as_count
from spacecraft_gnc.campaign.sampling import GRID, LATIN_HYPERCUBE, MOST_RUNS, RANDOM, SOBOL
from spacecraft_gnc.campaign.variations import Variations
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.plant.random_numbers import LARGEST_SEED, uniforms
from spacecraft_gnc.types import Array

_STREAM: Final = "campaign"
_SOBOL_BITS: Final = 30  # of a point: 2^30 of them; SciPy skips points with at most 32
_BELOW_ONE: Final = 1.0 - 2.0**-53
_MOST_DIMENSIONS: Final = 21201  # for which SciPy has direction numbers


class Design:
    """Points of the runs of a campaign.

    Point i depends on the variations, the seed and i alone, whatever is drawn before it, where and
    how often; with ``latin_hypercube`` also on the number of runs, for each run has a stratum of
    its own there.

    Parameters
    ----------
    variations : Variations
        Sampling, dimensions and cells.
    seed : int
        Master seed, 0 to 2^63 - 1.
    runs : int, optional
        Number of runs; by default that of the variations, or of the cells of a grid.

    Raises
    ------
    ParameterError
        If a number is out of range, or a grid has fewer cells than there are runs.
    """

    def __init__(self, variations: Variations, seed: int = 0, runs: int | None = None) -> None:
        self.variations = variations
        self.seed = as_count("seed", seed, least=0, most=LARGEST_SEED)
        default = variations.default_runs
        if runs is None and default is None:
            raise ParameterError(
                f"runs: received nothing; required a number of runs, here or in {variations.path}; "
                "give for example 1000"
            )
        self.runs = as_count("runs", default if runs is None else runs, most=MOST_RUNS)
        cells = variations.grid_size
        if cells is not None and self.runs > cells:
            raise ParameterError(
                f"runs: received {self.runs}; required at most the {cells} cells of the grid of "
                f"{variations.path}; leave it out"
            )
        if variations.sampling == SOBOL and variations.dimensions > _MOST_DIMENSIONS:
            raise ParameterError(
                f"sampling: received sobol for {variations.dimensions} numbers in a run; required "
                f"at most {_MOST_DIMENSIONS}; set sampling: random"
            )

    def points(self, first: int, count: int) -> Array:
        """Return the points of some runs.

        Parameters
        ----------
        first : int
            First run, from 0.
        count : int
            How many runs.

        Returns
        -------
        (count, dimensions) array
            Numbers in [0, 1); those of one parameter stand side by side.

        Raises
        ------
        ParameterError
            If there are not so many runs.
        """
        as_count("first", first, least=0, most=self.runs)
        as_count("count", count, least=0, most=self.runs - first)
        if not (count and self.variations.dimensions):
            return np.zeros((count, self.variations.dimensions))
        drawn = {
            RANDOM: self._random,
            LATIN_HYPERCUBE: self._latin_hypercube,
            SOBOL: self._sobol,
            GRID: self._grid,
        }
        return drawn[self.variations.sampling](first, count)

    def _random(self, first: int, count: int) -> Array:
        d = self.variations.dimensions
        runs = range(first, first + count)
        return np.array([uniforms(self.seed, run, _STREAM, 0, d) for run in runs])

    def _latin_hypercube(self, first: int, count: int) -> Array:
        return self._hypercube[first : first + count]

    @cached_property
    def _hypercube(self) -> Array:
        """The whole design, (runs, dimensions): a permutation has no single elements."""
        from scipy.stats import qmc

        whole = np.empty((self.runs, self.variations.dimensions))
        for j in range(whole.shape[1]):  # by itself: the whole in one go takes three times the room
            engine = qmc.LatinHypercube(1, seed=_generator(self.seed, 1, j))
            whole[:, j] = engine.random(self.runs)[:, 0]
        return np.minimum(whole, _BELOW_ONE, out=whole)

    def _sobol(self, first: int, count: int) -> Array:
        engine = self._engine.reset()
        if first:
            engine.fast_forward(first)
        # SciPy warns of a first draw that is no power of two, which more runs may well make one
        drawn = count if first else 1 << (count - 1).bit_length()
        points: Array = engine.random(drawn)[:count]
        return points + 0.5**_SOBOL_BITS / 2.0  # middle of what the bits leave open: never 0

    @cached_property
    def _engine(self) -> Any:
        from scipy.stats import qmc

        d, scrambling = self.variations.dimensions, _generator(self.seed, 0)
        return qmc.Sobol(d, bits=_SOBOL_BITS, seed=scrambling)

    def _grid(self, first: int, count: int) -> Array:
        """Return the middles of cells; the last parameter of the file changes fastest."""
        sizes = [size for size in self.variations.sizes if size > 1]
        cells = np.unravel_index(np.arange(first, first + count), sizes)
        return np.stack([(cell + 0.5) / size for cell, size in zip(cells, sizes, strict=True)], 1)


def _generator(seed: int, *key: int) -> np.random.Generator:
    """Return a generator of which SciPy can spawn others, as it does before it draws."""
    return np.random.Generator(np.random.Philox(np.random.SeedSequence(seed, spawn_key=key)))
