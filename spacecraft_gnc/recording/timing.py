"""Latency from a state to its command, as measured by the plant."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import read_columns
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.types import Array


def read_latencies(path: Path | str, *, namespace: str | None = None) -> Array:
    """Return the wall times [s] from a state to its torque, of the torques that came in time.

    Parameters
    ----------
    path
        Bag folder or .mcap file.
    namespace
        Of the spacecraft, where the bag holds several.

    Returns
    -------
    (n,) array
        In the order of the steps: of every step in free run, of a few a second in lockstep.

    Raises
    ------
    RecordingError
        If there is no readable bag.
    """
    with open_bag(path) as bag:
        timing = read_columns(bag, [WALL_TIMING], namespace)[WALL_TIMING]
    latencies = timing.fields.get("wall_latency", np.empty(0))
    return np.asarray(latencies[np.isfinite(latencies)], dtype=np.float64)
