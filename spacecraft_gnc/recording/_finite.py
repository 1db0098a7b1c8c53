"""Refuse recorded numbers that break the rules of their signal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.signals.signal import Signal


def require_finite(
    where: str, signal: Signal, steps: NDArray[np.int64], fields: Mapping[str, NDArray[Any]]
) -> None:
    """Refuse a recorded NaN or infinity that the signal does not allow.

    Raises
    ------
    RecordingError
        Naming topic (``where``), the first step, the field and the value.
    """
    for name, values in fields.items():
        field = signal.fields.get(name.partition(".")[0])
        if field is None or values.dtype.kind != "f" or (field.rule.nan and field.rule.infinite):
            continue
        wrong = np.isnan(values) if field.rule.infinite else ~np.isfinite(values)
        if field.rule.when is not None:
            other, value = field.rule.when
            wrong &= _along(fields[other] == value, values)
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
