"""Sources of the commands of a flight, as stretches of time."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import style
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.types import Array

NOT_RECORDED: Final = -1
_BY_RANK: Final = (
    Source.METHOD,
    *(source for source in Source if source is not Source.METHOD),
    NOT_RECORDED,
)
"""Best first."""
_RANKS: Final = np.array([_BY_RANK.index(source) for source in (*Source, NOT_RECORDED)])


class Stretch(NamedTuple):
    """Consecutive steps whose torque came from one source."""

    source: int
    """Of `loop.Source`, or `NOT_RECORDED`."""
    begin: float
    """[s]"""
    end: float
    """[s]"""
    steps: int


def source_name(source: int, otherwise: str = "not recorded") -> str:
    """Return a source in words; ``otherwise`` for a number that is none."""
    known = 0 <= source < len(Source)
    return Source(source).name.lower().replace("_", " ") if known else otherwise


def source_color(source: int) -> str:
    """Return the color of a source."""
    return style.MUTED if source < 0 else style.SOURCE_COLORS[source]


def stretches(sources: NDArray[np.int64], times: Array, width: int = 1) -> list[Stretch]:
    """Return the stretches of one source, in order.

    Parameters
    ----------
    sources, times
        (n,) of the steps, (n + 1,) of the states [s].
    width
        Steps that are taken together: the lowest rung of the ladder among them counts, the method
        itself above all of them and what was not recorded below.
    """
    starts = np.arange(0, len(sources), width)
    rungs = np.maximum.reduceat(_RANKS[sources], starts)
    changes = np.flatnonzero(np.append(True, rungs[1:] != rungs[:-1]))
    begins = starts[changes]
    ends = np.append(begins[1:], len(sources))
    return [
        Stretch(
            _BY_RANK[rung],
            float(times[begin]),
            float(times[end]),
            int(end - begin),
        )
        for rung, begin, end in zip(rungs[changes], begins, ends, strict=True)
    ]
