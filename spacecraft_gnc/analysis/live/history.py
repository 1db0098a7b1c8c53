"""The past of a flight as charts draw it: few enough samples, however long it lasts."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.live.picture import Picture, Setup, rounded

COLUMNS: Final = (
    "time",
    "error_deg",
    "target_error_deg",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "torque_x",
    "torque_y",
    "torque_z",
    "source",
    "q_x",
    "q_y",
    "q_z",
    "q_w",
)
"""Of a sample; the values of `Setup.strip` come before the quaternion."""
MOST: Final = 3000
"""Samples that are kept."""
_UNKNOWN: Final = [None] * 3
_generations = count()


def columns(setup: Setup) -> tuple[str, ...]:
    """Return the names of the columns of a sample."""
    strip = () if setup.strip is None else setup.strip.names
    return (*COLUMNS[:-4], *(f"strip_{i}" for i in range(len(strip))), *COLUMNS[-4:])


def sample(picture: Picture, setup: Setup) -> list[Any]:
    """Return the row of a picture, in the order of `columns`; None: not known."""
    attitude, target = picture.attitude, setup.target
    strip = [] if setup.strip is None else [None] * len(setup.strip.names)
    quaternion = None if attitude is None else lie.to_quaternion_xyzw(attitude)
    return [
        rounded(picture.time),
        rounded(picture.error_deg(picture.reference)),
        rounded(picture.error_deg(target if picture.target is None else picture.target)),
        *(_UNKNOWN if picture.momentum is None else rounded(picture.momentum)),
        *(_UNKNOWN if picture.torque is None else rounded(picture.torque)),
        picture.source,
        *(strip if picture.strip is None else rounded(picture.strip)),
        *([None] * 4 if quaternion is None else rounded(quaternion)),
    ]


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
