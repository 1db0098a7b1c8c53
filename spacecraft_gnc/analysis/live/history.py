"""History of a flight for the charts, decimated to a bounded number of samples."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.live.picture import Picture, Setup, rounded

MOST: Final = 3000
"""Samples that are kept."""
_generations = count()


def columns(setup: Setup) -> list[str]:
    """Return the names of a sample's values: time, those of the vehicle, and the attitude."""
    return ["time", *setup.history, "orientation"]


def sample(picture: Picture, setup: Setup) -> list[Any]:
    """Return the row of a picture, in the order of `columns`; None: not known.

    The attitude is a quaternion x, y, z, w.
    """
    values = picture.values
    attitude = values.get("attitude")
    quaternion = None if attitude is None else lie.to_quaternion_xyzw(attitude)
    drawn = (picture.time, *(values.get(name) for name in setup.history), quaternion)
    return [rounded(value) for value in drawn]


class History:
    """Samples in the order of time, thinned where they become too many.

    Attributes
    ----------
    generation
        Changes when samples that were handed out are no longer the first ones; no two histories
        ever have the same one.
    stride
        Every how many steps a sample is wanted.
    """

    def __init__(self) -> None:
        self.generation = next(_generations)
        self.stride = 1
        self._rows: list[list[Any]] = []

    def __len__(self) -> int:
        return len(self._rows)

    def wants(self, step: int) -> bool:
        """Tell whether a step is to be sampled."""
        return step % self.stride == 0

    def append(self, row: list[Any]) -> None:
        """Add a sample; every second one goes where there are too many."""
        self._rows.append(row)
        if len(self._rows) > MOST:
            self._rows = self._rows[::2]
            self.stride *= 2
            self.generation = next(_generations)

    def clear(self) -> None:
        """Forget everything: another flight begins."""
        self._rows = []
        self.stride = 1
        self.generation = next(_generations)

    def since(self, known: int) -> Sequence[list[Any]]:
        """Return the samples after the first ``known``."""
        return self._rows[known:]


def chosen_steps(n_steps: int) -> list[int]:
    """Return at most `MOST` steps of a recording, its first and last among them."""
    wanted = min(n_steps, MOST)
    return [] if wanted == 0 else np.linspace(0, n_steps - 1, wanted).round().astype(int).tolist()
