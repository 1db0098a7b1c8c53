"""Metrics of a flight in formation; None where nothing is known."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.geometry import pairs

Bools = NDArray[np.bool_]


def position_errors(position: Array, wanted: Array, healthy: Bools) -> Array:
    """Return the largest distance (n,) of a healthy craft from where it is to be [m].

    NaN where it is not known, or no craft is healthy.

    Parameters
    ----------
    position, wanted : (n, m, 3) arrays
        Of the craft, and what each is to track [m].
    healthy : (n, m) array of bool
    """
    away = np.linalg.norm(position - wanted, axis=-1)
    known = np.where(healthy, away, -math.inf).max(axis=-1, initial=-math.inf)
    return np.where(np.isfinite(known), known, math.nan)


def equal_shifts(shift: NDArray[np.int64], healthy: Bools) -> Bools:
    """Tell of each step (n,) whether all healthy craft have one shift; of shifts (n, m)."""
    most = np.where(healthy, shift, -1).max(axis=-1, initial=-1)
    return np.asarray((~healthy | (shift == most[:, None])).all(axis=-1) & (most >= 0))


def formed_at_step(errors: Array, equal: Bools, formed_error: float) -> int | None:
    """Return the first step from which on the desired formation is kept for good.

    It is where all shifts are equal and every position error is below ``formed_error``; unknown
    steps are passed over. None: it is not, at the last known step.

    Parameters
    ----------
    errors : (n,) array
        Largest position error of a healthy craft [m].
    equal : (n,) array of bool
        Whether all healthy craft have one shift.
    formed_error : float
        [m]
    """
    known = np.flatnonzero(np.isfinite(errors))
    away = np.flatnonzero(~equal[known] | (errors[known] >= formed_error))
    first = int(away[-1]) + 1 if away.size else 0
    return int(known[first]) if first < known.size else None


def delta_v_norms(delta_v: Array, healthy: Bools) -> Array:
    """Return the length (n, m) of each delta-v commanded [m/s]; 0 of a craft that is lost.

    Parameters
    ----------
    delta_v : (n, m, 3) array
    healthy : (n, m) array of bool
    """
    return np.where(healthy, np.linalg.norm(delta_v, axis=-1), 0.0)


def healthy_pairs(healthy: Bools) -> Bools:
    """Tell of each pair (n, pairs) whether both craft are healthy; of craft (n, m)."""
    first, second = pairs(healthy.shape[-1]).T
    return np.asarray(healthy[:, first] & healthy[:, second])


def largest(values: Array) -> float | None:
    """Return the largest of the values that are known."""
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else None


def least(values: Array) -> float | None:
    """Return the least of the values that are known."""
    known = values[np.isfinite(values)]
    return float(known.min()) if known.size else None


def last_known(values: Array) -> float | None:
    """Return the last of the values (n,) that is known."""
    known = values[np.isfinite(values)]
    return float(known[-1]) if known.size else None


def occurrences(flags: Bools) -> int:
    """Return how many times flags (n,) become true, the first step included."""
    return int(np.count_nonzero(flags & ~np.append(False, flags[:-1])))


def passages(passing: Bools, shift: NDArray[np.int64]) -> int:
    """Return the number of steps to another parked formation on the way out of deadlocks.

    Parameters
    ----------
    passing : (n,) array of bool
        Whether the shifts of a step are those of a parked formation on the way.
    shift : (n, m) array
        Shifts [control steps].
    """
    changed = np.append(False, (np.diff(shift, axis=0) != 0).any(axis=1))
    return int(np.count_nonzero(passing & changed))


class Loss(NamedTuple):
    """A craft that was lost, and what was concluded on board."""

    spacecraft_lost: str | None
    """Its name; None: none was lost."""
    spacecraft_lost_at: float | None
    """[s]"""
    spacecraft_loss_detected_at: float | None
    """When it was concluded lost, at or after its loss [s]; None: it was not."""
    false_alarms: list[dict[str, Any]]
    """Of each craft concluded lost while it answered: ``spacecraft`` and ``at`` [s]."""


def loss(time: Array, healthy: Bools, concluded: Bools, craft: tuple[str, ...]) -> Loss:
    """Return the first loss beside its detection, and the false alarms.

    Parameters
    ----------
    time : (n,) array
        Starts of the steps [s].
    healthy, concluded : (n, m) arrays of bool
        Whether each craft answers; whether it was concluded lost.
    craft : tuple of str
        Names.
    """
    lost, found = _first_times(time, ~healthy), _first_times(time, concluded)
    alarms = {i: at for i, at in found.items() if at < lost.get(i, math.inf)}
    first = min(lost, key=lambda i: lost[i]) if lost else None
    return Loss(
        None if first is None else craft[first],
        None if first is None else lost[first],
        None if first is None or first in alarms else found.get(first),
        [{"spacecraft": craft[i], "at": at} for i, at in alarms.items()],
    )


def _first_times(time: Array, flags: Bools) -> dict[int, float]:
    """Return when each column of flags (n, m) first is true [s]; absent: never."""
    return {i: float(time[np.argmax(c)]) for i, c in enumerate(flags.T) if c.any()}
