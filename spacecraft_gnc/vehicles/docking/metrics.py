"""Metrics of a docking flight; None where nothing is known."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS

DOCKED_OFFSET: Final = 0.02  # [m]
DOCKED_ANGLE: Final = math.radians(1.0)  # [rad]
_AT_TARGET: Final = 1e-6  # [m], [rad] by which a reference that has arrived may miss the target


def angles(attitude: Array) -> Array:
    """Return the angle (n,) [rad] of attitudes (n, 3, 3), deputy to chief; NaN: not known."""
    return lie.angles_between(attitude, np.eye(3))


def docked_at(time: Array, port_offset: Array, attitude: Array) -> float | None:
    """Return the time [s] from which on the deputy is docked for good.

    Docked: the ports are at most `DOCKED_OFFSET` apart, and the bodies at most `DOCKED_ANGLE` out
    of line. None if the last known state is not; unknown states are passed over.

    Parameters
    ----------
    time : (n,) array
        Times of the states [s].
    port_offset, attitude : (n, 3), (n, 3, 3) arrays
        Deputy port minus chief port, chief frame [m]; deputy to chief.
    """
    distance, angle = np.linalg.norm(port_offset, axis=1), angles(attitude)
    away = (distance > DOCKED_OFFSET) | (angle > DOCKED_ANGLE)
    return _for_good(time, ~away, np.isfinite(distance) & np.isfinite(angle))


def settled_at(time: Array, reference: Array, target: Array) -> float | None:
    """Return the time [s] from which on references (n, 6) are the targets (n, 6) for good."""
    miss = np.abs(reference - target).max(axis=1)
    return _for_good(time, miss <= _AT_TARGET, np.isfinite(miss))


def _for_good(time: Array, there: NDArray[np.bool_], known: NDArray[np.bool_]) -> float | None:
    """Return the first of the known times after which it is ``there`` at all later ones."""
    times, there = time[known], there[known]
    away = np.flatnonzero(~there)
    first = int(away[-1]) + 1 if away.size else 0
    return float(times[first]) if first < times.size else None


def last_known(values: Array) -> float | None:
    """Return the last of the values (n,) that is known."""
    known = values[np.isfinite(values)]
    return float(known[-1]) if known.size else None


def largest(values: Array) -> float | None:
    """Return the largest size of the values that are known."""
    known = np.abs(values[np.isfinite(values)])
    return float(known.max()) if known.size else None


def least(values: Array) -> float | None:
    """Return the least of the values that are known."""
    known = values[np.isfinite(values)]
    return float(known.min()) if known.size else None


def impulse(force: Array, period: float, limit: float = math.inf) -> float:
    """Return the integral of |force| [N s] over steps of ``period`` [s]; unknown ones are left out.

    Parameters
    ----------
    force : (n, 3) array
        Of each step [N].
    limit
        What a component is cut off at [N].
    """
    given = np.linalg.norm(np.clip(force, -limit, limit), axis=1)
    return float(np.nansum(given) * period)


class Loss(NamedTuple):
    """A thruster direction that was lost, and what was concluded on board."""

    thruster_lost: str | None
    """Of `state.DIRECTIONS`; None: none was lost."""
    thruster_lost_at: float | None
    """[s]"""
    thruster_loss_detected_at: float | None
    """When that direction was concluded lost, at or after its loss [s]; None: it was not."""
    false_alarms: list[dict[str, Any]]
    """Of each direction concluded lost while it answered: ``thruster`` and ``at`` [s]."""


def loss(
    time: Array, thrusters: NDArray[np.bool_] | None, concluded: NDArray[np.int64] | None
) -> Loss:
    """Return the first loss beside its detection, and the false alarms.

    Parameters
    ----------
    time : (n,) array
        Starts of the steps [s].
    thrusters : (n, 6) bool array, optional
        Whether each direction answers.
    concluded : (n,) int array, optional
        Index of the direction concluded lost; -1: none.
    """
    lost = {} if thrusters is None else _first_losses(time, thrusters)
    found = {} if concluded is None else _first_times(time, concluded)
    alarms = {i: at for i, at in found.items() if at < lost.get(i, math.inf)}
    first = min(lost, key=lambda i: lost[i]) if lost else None
    return Loss(
        None if first is None else DIRECTIONS[first],
        None if first is None else lost[first],
        None if first is None or first in alarms else found.get(first),
        [{"thruster": DIRECTIONS[i], "at": at} for i, at in alarms.items()],
    )


def _first_losses(time: Array, thrusters: NDArray[np.bool_]) -> dict[int, float]:
    """Return when each direction of (n, 6) first does not answer [s]; absent: never."""
    return {i: float(time[np.argmin(c)]) for i, c in enumerate(thrusters.T) if not c.all()}


def _first_times(time: Array, concluded: NDArray[np.int64]) -> dict[int, float]:
    """Return when each direction is first concluded lost [s], in the order of these times."""
    values, rows = np.unique(concluded, return_index=True)
    pairs = sorted((int(row), int(value)) for row, value in zip(rows, values, strict=True))
    return {value: float(time[row]) for row, value in pairs if 0 <= value < len(DIRECTIONS)}
