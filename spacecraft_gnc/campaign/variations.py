"""The variations file: which parameters a campaign varies, how, and what counts as success."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from spacecraft_gnc.arguments import require_kind, require_path
from spacecraft_gnc.campaign.criterion import Criterion
from spacecraft_gnc.campaign.distributions.distribution import Distribution
from spacecraft_gnc.campaign.sampling import GRID
from spacecraft_gnc.campaign.variations_file import read_variations
from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.types import Array


@dataclass(frozen=True, eq=False)
class Variations:
    """What varies from run to run; build it with `load_variations`.

    Attributes
    ----------
    path, text : str
        The file, and what it says.
    sampling : str
        ``random``, ``latin_hypercube``, ``sobol`` or ``grid``.
    runs : int or None
        Default number of runs; None where the file has none.
    worst : int
        Runs kept as the worst of each metric of the criterion.
    criterion : Criterion
        What counts as success.
    names : tuple of str
        Parameters, ``section.parameter``, in the order of the file.
    distributions : tuple of Distribution
        One for each of them.
    """

    path: str
    text: str
    sampling: str
    runs: int | None
    worst: int
    criterion: Criterion
    names: tuple[str, ...]
    distributions: tuple[Distribution, ...]

    @cached_property
    def dimensions(self) -> int:
        """Numbers of a point of the design."""
        return sum(distribution.dimensions for distribution in self.distributions)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Values of each parameter, 0 for a continuum."""
        return tuple(distribution.size or 0 for distribution in self.distributions)

    @property
    def grid_size(self) -> int | None:
        """Cells of the grid; None with another sampling."""
        return math.prod(self.sizes) if self.sampling == GRID else None

    @property
    def default_runs(self) -> int | None:
        """Number of runs where the user gives none; None where the file has none either."""
        return self.grid_size if self.runs is None else self.runs

    def values(self, point: Array) -> dict[str, Value]:
        """Return the value of each parameter, in its ROS 2 form, at a point of the design.

        Parameters
        ----------
        point : (dimensions,) array
            Numbers in [0, 1).
        """
        values, start = {}, 0
        for name, distribution in zip(self.names, self.distributions, strict=True):
            end = start + distribution.dimensions
            values[name] = distribution.value(point[start:end])
            start = end
        return values


def load_variations(path: str | Path, scenario: Scenario, text: str | None = None) -> Variations:
    """Read and check a variations file.

    Parameters
    ----------
    path : str or Path
        The file, or the name of one that comes with the package.
    scenario : Scenario
        What is varied: its parameters, their ranges, and the values that the file varies about.
    text : str, optional
        What the file says, if it is at hand; ``path`` then only tells where it stands.

    Raises
    ------
    InvalidScenario
        With every problem of the file at once.
    """
    require_kind("scenario", scenario, Scenario)
    return Variations(**read_variations(require_path("path", path), scenario, text))
