"""Tables of rows: made of the rows of a block, brought to one form, and written whole."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from spacecraft_gnc.campaign.flyer import REASON, WALL_TIME
from spacecraft_gnc.drawing.whole_file import whole_file


def table_of(rows: Sequence[Mapping[str, Any]]) -> Any:
    """Return rows as a `pyarrow.Table`: a column for each name, in order of first appearance."""
    import pyarrow as pa

    names = _wall_time_last(name for row in rows for name in row)
    types = {REASON: pa.string()}  # also where no row has one
    return pa.table(
        {name: _array([row.get(name) for row in rows], types.get(name)) for name in names}
    )


def joined(tables: Sequence[Any]) -> Any:
    """Return tables one below the other, with the columns of all."""
    import pyarrow as pa

    schema = common_schema([table.schema for table in tables])
    return pa.concat_tables([conformed(table, schema) for table in tables])


def common_schema(schemas: Iterable[Any]) -> Any:
    """Return the schema that holds the columns of all; where types differ, text holds any."""
    import pyarrow as pa

    types: dict[str, Any] = {}
    for schema in schemas:
        for field in schema:
            types[field.name] = _common_type(types.get(field.name, pa.null()), field.type)
    return pa.schema([pa.field(name, types[name]) for name in _wall_time_last(types)])


def conformed(table: Any, schema: Any) -> Any:
    """Return a table in a schema from `common_schema`; a column that it lacks has no values."""
    import pyarrow as pa

    if table.schema.equals(schema):
        return table
    known = set(table.column_names)
    columns = [
        _cast(table[field.name], field.type)
        if field.name in known
        else pa.nulls(table.num_rows, field.type)
        for field in schema
    ]
    return pa.table(columns, schema=schema)


def without_null_types(schema: Any) -> Any:
    """Return a schema whose columns without any value are of doubles, which every reader knows."""
    import pyarrow as pa

    fields = [
        pa.field(field.name, pa.float64() if pa.types.is_null(field.type) else field.type)
        for field in schema
    ]
    return pa.schema(fields)


def write_table(table: Any, path: Path) -> None:
    """Write a table as Parquet, whole or not at all.

    Raises
    ------
    RecordingError
        If it cannot be written.
    """
    import pyarrow.parquet as pq

    with whole_file(path) as file:
        pq.write_table(table, file, compression="zstd")


def _wall_time_last(names: Iterable[str]) -> list[str]:
    ordered = dict.fromkeys(names)
    return [*(name for name in ordered if name != WALL_TIME), WALL_TIME]


def _array(values: list[Any], type_: Any = None) -> Any:
    import pyarrow as pa

    try:
        return pa.array(values, type=type_)
    except (pa.ArrowInvalid, pa.ArrowTypeError):  # numbers beside lists or words
        return _array_of_text(values)


def _common_type(first: Any, second: Any) -> Any:
    import pyarrow as pa

    if pa.types.is_list(first) and pa.types.is_list(second):
        return pa.list_(_common_type(first.value_type, second.value_type))
    for one, other in ((first, second), (second, first)):
        if one.equals(other) or pa.types.is_null(one):
            return other
        if pa.types.is_integer(one) and pa.types.is_floating(other):
            return other
    return pa.string()


def _cast(column: Any, type_: Any) -> Any:
    import pyarrow as pa

    if pa.types.is_string(type_) and not (
        pa.types.is_string(column.type) or pa.types.is_null(column.type)
    ):
        return pa.chunked_array([_array_of_text(column.to_pylist())], type=type_)
    return column.cast(type_)


def _array_of_text(values: Iterable[Any]) -> Any:
    import pyarrow as pa

    texts = [None if value is None else json.dumps(value) for value in values]
    return pa.array(texts, type=pa.string())
