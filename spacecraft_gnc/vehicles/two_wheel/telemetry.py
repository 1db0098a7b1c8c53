"""Telemetry of a spacecraft with wheels: what a bag tells beside the arrays of a flight."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from spacecraft_gnc.recording.columns import Columns, read_columns
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.signals import DIAGNOSIS

if TYPE_CHECKING:
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight


class Watch(NamedTuple):
    """What the monitor on board saw; row k belongs to control step k, NaN: not known."""

    residual: Array
    """(n, m) [rad/s]."""
    threshold: Array
    """(n, m) [rad/s]."""


class Telemetry(NamedTuple):
    """What a bag tells beside the arrays of a flight."""

    missed_deadlines: int | None = None
    """Steps of a free run whose command came too late; None: no free run."""
    watch: Watch | None = None
    """None where no wheel is watched, or nothing was recorded of it."""


def telemetry(
    flight: WheelFlight, bag: Bag | None, namespace: str | None, *, is_free: bool
) -> Telemetry:
    """Return what the bag of a flight tells; ``is_free``: it was a free run."""
    if bag is None:
        return Telemetry()
    found = read_columns(bag, [WALL_TIMING, DIAGNOSIS], namespace)
    counts = found[WALL_TIMING].fields.get("missed_deadlines", np.zeros(1, dtype=np.int64))
    return Telemetry(int(counts.max()) if is_free else None, _watch(flight, found[DIAGNOSIS]))


def _watch(flight: WheelFlight, columns: Columns) -> Watch | None:
    """Return the diagnosis of each control step."""
    residual = columns.fields.get("residual")
    if residual is None or not np.isfinite(residual).any():
        return None
    within = columns.steps < flight.n_steps
    rows = []
    for name in Watch._fields:
        values = columns.fields[name]
        row = np.full((flight.n_steps, *values.shape[1:]), np.nan)
        row[columns.steps[within]] = values[within]
        rows.append(row)
    return Watch(*rows)
