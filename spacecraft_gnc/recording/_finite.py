"""Which recorded numbers must be finite: all, but where a message definition says otherwise."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import RecordingError

_ANY: Final = frozenset(
    {
        # SolverStatus: NaN without a solve, or not known
        "residual",
        "cost",
        "first_costate",
        "torque_margin",
        "zone_margins",
        "min_curvature",
        "closed_loop_radius",
        "predicted_attitudes",
        "predicted_momenta",
        "predicted_torques",
        # wall times: NaN where there is no deadline, or nothing came
        "wall_solve_time",
        "wall_latency",
        "wall_deadline_slack",
    }
)
_INFINITE: Final = frozenset({"margin"})
"""GovernorStatus: infinite where nothing is predicted."""
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
        if values.dtype.kind != "f":
            continue
        wrong = _wrong(name, values)
        if name in _OF_A_SOLVE and "status" in fields:
            wrong = ~np.isfinite(values) & _along(fields["status"] == _CONVERGED, values)
        rows = np.flatnonzero(wrong.any(axis=tuple(range(1, wrong.ndim))))
        if rows.size:
            row = rows[np.argmin(steps[rows])]
            raise RecordingError(
                f"{where}, step {steps[row]}, field {name}: received "
                f"{_first(values[row], wrong[row])}; required a finite number; the message was "
                "recorded so: find what published it, and record again"
            )


def _wrong(name: str, values: NDArray[Any]) -> NDArray[np.bool_]:
    if name in _ANY:
        return np.zeros(values.shape, dtype=bool)
    wrong: NDArray[np.bool_] = np.isnan(values) if name in _INFINITE else ~np.isfinite(values)
    return wrong


def _along(rows: NDArray[np.bool_], values: NDArray[Any]) -> NDArray[np.bool_]:
    return rows.reshape(-1, *[1] * (values.ndim - 1))


def _first(values: NDArray[Any], wrong: NDArray[np.bool_]) -> str:
    """Return the first wrong number; of several, with its place."""
    if values.ndim == 0:
        return f"{values}"
    place = int(np.flatnonzero(wrong)[0])
    return f"{values[place]} at [{place}]"
