"""Ways to choose the points of a campaign's runs."""

from __future__ import annotations

from typing import Final

RANDOM: Final = "random"
"""Independent of each other."""
LATIN_HYPERCUBE: Final = "latin_hypercube"
"""One in each of as many strata as there are runs, for every number."""
SOBOL: Final = "sobol"
"""A scrambled Sobol' sequence: evenly filled at every length, best at powers of two."""
GRID: Final = "grid"
"""Every combination of the values listed."""
SAMPLINGS: Final = (RANDOM, LATIN_HYPERCUBE, SOBOL, GRID)
MOST_RUNS: Final = 10**9
"""Of a campaign: a Sobol' sequence has 2^30 points."""
