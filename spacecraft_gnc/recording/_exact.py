"""Comparison of serialized messages with the bytes that their fields encode to."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.signals.codec import LITTLE_ENDIAN

_ENCAPSULATION: Final = len(LITTLE_ENDIAN)
_ALIGNMENT: Final = 4  # [bytes] of the end of a message, as RTPS carries it
_LENGTH: Final = 4  # [bytes] of the length of a string or a sequence
_ASCII: Final = 0x80

Place = tuple[int, np.dtype[Any], int]
"""Offset, type and count of the numbers of a field."""


def exact_rows(
    rows: NDArray[np.uint8], places: Iterable[Place], lengths: Iterable[int], end: int
) -> NDArray[np.bool_]:
    """Tell which messages (m, size) of one layout are encoded as `Signal.encode` does it.

    Whatever no field covers is zero, the message ends at the next multiple of four bytes, a bool is
    0 or 1, and a string is UTF-8 with one NUL, at its end. Of a NaN any bits are as good.

    Parameters
    ----------
    rows
        Messages with their encapsulation headers.
    places
        Of the fields.
    lengths
        Offsets of the lengths of strings and sequences.
    end
        Bytes up to the end of the last field.
    """
    count, size = rows.shape
    if size != end + -end % _ALIGNMENT:
        return np.zeros(count, dtype=np.bool_)
    exact = np.asarray((rows[:, :_ENCAPSULATION] == list(LITTLE_ENDIAN)).all(axis=1))
    padding = np.ones(size, dtype=np.bool_)
    padding[:_ENCAPSULATION] = False
    for offset in lengths:
        padding[offset : offset + _LENGTH] = False
    for offset, dtype, n in places:
        stop = offset + n * dtype.itemsize
        padding[offset:stop] = False
        if dtype.kind == "S":
            exact &= _are_texts(rows[:, offset:stop])
        elif dtype.kind == "b":
            exact &= (rows[:, offset:stop] <= 1).all(axis=1)
    exact &= ~rows[:, padding].any(axis=1)
    return exact


def _are_texts(rows: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """Tell which rows are UTF-8 with one NUL, at the end."""
    if not rows.shape[1]:
        return np.zeros(len(rows), dtype=np.bool_)
    good = np.asarray((rows[:, -1] == 0) & (rows[:, :-1] != 0).all(axis=1))
    for row in np.flatnonzero((rows >= _ASCII).any(axis=1)):
        try:
            rows[row].tobytes().decode()
        except UnicodeDecodeError:
            good[row] = False
    return good
