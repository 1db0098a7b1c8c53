"""Stored starts of the formation that deadlock where nothing resolves it.

They are the first sixteen of seeded draws: phases of whole control steps, offsets of 3 to 9 km,
amplitudes of 0.8 to 1.8, the box of config/campaigns/afrl_formation.yaml.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc.plant.random_numbers import uniforms

_SEED: Final = 2016
_STREAM: Final = "formation.start"
_SAMPLES: Final = 50


class Start(NamedTuple):
    """Where three craft begin, each on a natural ellipse of its own."""

    phase: tuple[float, ...]
    """[control steps]"""
    along_track_offset: tuple[float, ...]
    """[m]"""
    amplitude: tuple[float, ...]
    """Share of the nominal ellipse."""

    @classmethod
    def drawn(cls, run: int) -> Start:
        """Return the start of a run, from 0."""
        u = uniforms(_SEED, run, _STREAM, 0, 9).reshape(3, 3)
        return cls(
            tuple(np.floor(_SAMPLES * u[0]).tolist()),
            tuple((3000.0 + 6000.0 * u[1]).tolist()),
            tuple((0.8 + u[2]).tolist()),
        )


DEADLOCKED_RUNS: Final = (6, 9, 11, 13, 15, 17, 22, 23, 25, 33, 34, 39, 42, 43, 45, 46)
DEADLOCKS: Final = tuple(map(Start.drawn, DEADLOCKED_RUNS))
