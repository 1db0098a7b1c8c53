"""Numbers of the columns of a table of rows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from spacecraft_gnc.types import Array


def numbers(column: Any) -> Array | None:
    """Return the (n,) or (n, m) numbers of an Arrow column, NaN for none; None: it has words."""
    kind = column.type
    if pa.types.is_null(kind):
        return np.full(len(column), np.nan)
    if pa.types.is_boolean(kind):
        return numbers(column.cast(pa.int8()))
    if pa.types.is_integer(kind) or pa.types.is_floating(kind):
        return np.asarray(column.to_numpy(), dtype=np.float64)
    return _rows(column) if _is_list(kind) and _is_number(kind.value_type) else None


def _rows(column: Any) -> Array | None:
    """Return the (n, m) numbers of a column of lists; None: they are not equally long."""
    lengths = pc.list_value_length(column)
    width = pc.max(lengths).as_py()
    if not width or pc.min(lengths).as_py() != width:
        return None
    flat = pc.list_flatten(column).to_numpy()
    known: Array = flat.astype(np.float64, copy=False).reshape(-1, width)
    if len(known) == len(column):
        return known
    rows = np.full((len(column), width), np.nan)
    rows[lengths.is_valid().to_numpy()] = known
    return rows


def _is_list(kind: Any) -> bool:
    return bool(
        pa.types.is_list(kind) or pa.types.is_large_list(kind) or pa.types.is_fixed_size_list(kind)
    )


def _is_number(kind: Any) -> bool:
    return bool(
        pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind)
    )
