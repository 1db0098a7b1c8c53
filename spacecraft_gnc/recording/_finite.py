"""Which recorded numbers must be finite: all, but where a message definition says otherwise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import RecordingError

_ANY: Final = frozenset(
    # not known; no deadline, or nothing came
    {"min_curvature", "closed_loop_radius", "wall_solve_time", "wall_latency"}
    | {"wall_deadline_slack"}
)
_INFINITE: Final = frozenset({"margin", "torque_margin"})
"""Infinite where nothing is predicted (GovernorStatus), or without a limit (SolverStatus)."""
_OF_A_SOLVE: Final = (
    "residual",
    "cost",
    "first_costate",
    "torque_margin",
    "zone_margins",
    "predicted_attitudes",
    "predicted_momenta",
    "predicted_torques",
)
_CONVERGED: Final = 0  # SolverStatus.CONVERGED


def require_finite(
    where: str, steps: NDArray[np.int64], fields: Mapping[str, NDArray[Any]]
) -> None:
    """Refuse a recorded NaN or infinity that its message definition does not allow.

    Raises
    ------
    RecordingError
        Naming topic (``where``), the first step, the field and the value.
    """
    for name, values in fields.items():
        if values.dtype.kind != "f" or name in _ANY:
            continue
        wrong = np.isnan(values) if name in _INFINITE else ~np.isfinite(values)
        if name in _OF_A_SOLVE:
            wrong &= _along(fields["status"] == _CONVERGED, values)
        rows = np.flatnonzero(wrong.any(axis=tuple(range(1, wrong.ndim))))
        if rows.size:
            row = rows[np.argmin(steps[rows])]
            raise RecordingError(
                f"{where}, step {steps[row]}, field {name}: received "
                f"{_first(values[row], wrong[row])}; required a finite number; the message was "
                "recorded so: find what published it, and record again"
            )


def _along(rows: NDArray[np.bool_], values: NDArray[Any]) -> NDArray[np.bool_]:
    return rows.reshape(-1, *[1] * (values.ndim - 1))


def _first(values: NDArray[Any], wrong: NDArray[np.bool_]) -> str:
    """Return the first wrong number; of several, with its place."""
    if values.ndim == 0:
        return f"{values}"
    place = int(np.flatnonzero(wrong)[0])
    return f"{values[place]} at [{place}]"
