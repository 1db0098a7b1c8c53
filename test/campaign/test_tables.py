"""Tables of rows in one form."""

from __future__ import annotations

import pyarrow as pa
import pytest

from spacecraft_gnc.campaign.tables import (
    common_schema,
    conformed,
    joined,
    table_of,
    without_null_types,
)


def types(table: pa.Table) -> dict[str, str]:
    return {field.name: str(field.type) for field in table.schema}


def test_a_table_has_the_columns_of_all_rows_and_the_wall_time_last() -> None:
    rows = [{"run": 0, "reason": None, "wall_time": 0.1}, {"run": 1, "x": 2.5, "wall_time": 0.1}]
    table = table_of(rows)
    assert types(table) == {
        "run": "int64", "reason": "string", "x": "double", "wall_time": "double",
    }  # fmt: skip
    assert table.to_pylist()[0] == {"run": 0, "reason": None, "x": None, "wall_time": 0.1}


VALUES = {
    "null and number": ([None], [1.5], "double"),
    "integer and number": ([1], [1.5], "double"),
    "null and integer": ([None], [3], "int64"),
    "lists": ([[1.0]], [None], "list<element: double>"),
    "lists of integers and numbers": ([[1, 2]], [[1.5]], "list<item: double>"),
    "number and list": ([1.5], [[1.5, 2.0]], "string"),
    "text and number": (["a"], [1.5], "string"),
    "bools and numbers": ([True], [1.5], "string"),
}


@pytest.mark.parametrize("case", VALUES, ids=str)
def test_columns_of_different_types_come_together(case: str) -> None:
    first, second, expected = VALUES[case]
    tables = [table_of([{"x": v, "wall_time": 1.0} for v in values]) for values in (first, second)]
    for order in (tables, tables[::-1]):
        whole = joined(order)
        assert types(whole)["x"].replace("element", "item") == expected.replace("element", "item")
    values = joined(tables)["x"].to_pylist()
    if expected != "string":
        assert values == [*first, *second]
    else:
        assert values == [str(v).lower() if v is True else str(v) for v in (*first, *second)]


def test_mixed_values_of_one_block_become_text() -> None:
    table = table_of([{"x": 1.5, "wall_time": 1.0}, {"x": [1.5], "wall_time": 1.0}])
    assert table["x"].to_pylist() == ["1.5", "[1.5]"]


def test_a_column_without_values_is_one_of_doubles_in_the_end() -> None:
    table = table_of([{"x": None, "wall_time": 1.0}])
    schema = without_null_types(common_schema([table.schema]))
    assert str(conformed(table, schema).schema.field("x").type) == "double"
