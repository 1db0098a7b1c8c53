"""Metrics of a flight of a spacecraft with wheels; None where nothing is known."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array, Matrix3

SETTLED_ANGLE: Final = 0.01  # [rad]
SETTLED_RATE: Final = 0.001  # [rad/s]


def summarize(
    time: Array,
    attitude: Array,
    angular_velocity: Array,
    wheel_speed: Array,
    wheel_acceleration: Array,
    target: Matrix3,
    healthy: NDArray[np.bool_] | None = None,
    diagnosed: NDArray[np.bool_] | None = None,
) -> dict[str, Any]:
    """Return the metrics of a flight, ready for JSON.

    Parameters
    ----------
    time : (n,) array
        Times of the states [s].
    attitude, angular_velocity, wheel_speed : (n, 3, 3), (n, 3), (n, m) arrays
        States: body to inertial, body frame [rad/s], relative to the bus [rad/s]; NaN: not known.
    wheel_acceleration : (k, m) array
        Commands relative to the bus [rad/s^2].
    target : (3, 3) array
        Attitude that is finally wanted, body to inertial.
    healthy, diagnosed : (n, m) bool arrays, optional
        Whether each wheel answers, in truth and as the diagnosis on board has it.

    Returns
    -------
    dict
        ``final_error_deg``, ``settle_time`` [s], ``max_wheel_speed`` [rad/s],
        ``max_wheel_acceleration`` [rad/s^2], ``wheel_lost_at``, ``wheel_loss_detected_at`` [s] (of
        the wheel that is lost first), ``wheel_losses`` and ``false_alarms`` (`Losses`).
    """
    found = losses(time, healthy, diagnosed)
    first = found.losses[0] if found.losses else {}
    return {
        "final_error_deg": final_error_deg(attitude, target),
        "settle_time": settle_time(time, attitude, angular_velocity, target),
        "max_wheel_speed": largest(wheel_speed),
        "max_wheel_acceleration": largest(wheel_acceleration),
        "wheel_lost_at": first.get("lost_at"),
        "wheel_loss_detected_at": first.get("detected_at"),
        "wheel_losses": found.losses,
        "false_alarms": found.false_alarms,
    }


def final_error_deg(attitude: Array, target: Matrix3) -> float | None:
    """Return the angle [deg] from the last known attitude of (n, 3, 3) to ``target`` (3, 3)."""
    error = lie.angles_between(attitude, target)
    known = error[np.isfinite(error)]
    return math.degrees(known[-1]) if known.size else None


def settle_time(
    time: Array, attitude: Array, angular_velocity: Array, target: Matrix3
) -> float | None:
    """Return the time [s] from which on the bus is at rest at the target for good.

    At rest there: less than `SETTLED_ANGLE` of rotation off, turning at less than `SETTLED_RATE`.
    These are at least as strict as the report's boxes in 3-2-1 angles and rates (AFRL, 4.1), to
    first order in the angles. None if the last known state is not; unknown states are passed over.
    """
    error = lie.angles_between(attitude, target)
    rate = np.linalg.norm(angular_velocity, axis=1)
    known = np.isfinite(error) & np.isfinite(rate)
    times = time[known]
    away = np.flatnonzero((error[known] >= SETTLED_ANGLE) | (rate[known] >= SETTLED_RATE))
    first = int(away[-1]) + 1 if away.size else 0
    return float(times[first]) if first < times.size else None


def largest(values: Array) -> float | None:
    """Return the largest size of the values that are known."""
    known = np.abs(values[~np.isnan(values)])
    return float(known.max()) if known.size else None


class Losses(NamedTuple):
    """What happened to the wheels, and what was concluded on board, ready for JSON."""

    losses: list[dict[str, Any]]
    """Of each wheel lost, in the order of the losses: ``wheel`` (from 1), ``lost_at`` and
    ``detected_at`` [s]; None: it was not excluded after its loss."""
    false_alarms: list[dict[str, Any]]
    """Of each wheel excluded that answered: ``wheel`` (from 1) and ``at`` [s]."""


def losses(
    time: Array, healthy: NDArray[np.bool_] | None, diagnosed: NDArray[np.bool_] | None
) -> Losses:
    """Return the losses of (n, m) wheels beside their detection, and the false alarms.

    A wheel that was excluded while it answered is a false alarm, also where it is lost later: that
    loss was not detected.
    """
    lost, excluded = _first_times(time, healthy), _first_times(time, diagnosed)
    alarms = {i: at for i, at in excluded.items() if at < lost.get(i, math.inf)}
    return Losses(
        [
            {
                "wheel": i + 1,
                "lost_at": at,
                "detected_at": None if i in alarms else excluded.get(i),
            }
            for i, at in sorted(lost.items(), key=lambda item: item[1])
        ],
        [{"wheel": i + 1, "at": at} for i, at in sorted(alarms.items(), key=lambda item: item[1])],
    )


def _first_times(time: Array, answers: NDArray[np.bool_] | None) -> dict[int, float]:
    """Return the first time [s] at which each wheel of (n, m) does not answer; absent: never."""
    columns: Iterable[NDArray[np.bool_]] = [] if answers is None else answers.T
    return {i: float(time[np.argmin(c)]) for i, c in enumerate(columns) if not c.all()}
