"""Folder of a campaign: whole parts, in one form in the end, of this campaign alone."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from spacecraft_gnc.campaign import writer as module
from spacecraft_gnc.campaign.results import Campaign, Part
from spacecraft_gnc.campaign.tables import table_of
from spacecraft_gnc.campaign.writer import Writer, exclusive
from spacecraft_gnc.errors import RecordingError

RUNS = 23


@pytest.fixture(autouse=True)
def short_parts(monkeypatch) -> None:
    monkeypatch.setattr(module, "_ROWS", 8)


@pytest.fixture
def campaign(make_spec, tmp_path: Path) -> Campaign:
    return Campaign.create(tmp_path / "out", make_spec(runs=RUNS))


def rows_of(runs: range, wall: float = 1.0):
    """Return rows of which some lack a metric, and one has another type."""
    return table_of(
        [
            {
                "run": run,
                "status": "failed" if run % 5 else "passed",
                "reason": None,
                "x": None if run < 9 else run / 3.0,
                "n": run if run % 2 else None,
                **({"late": run} if run > 15 else {}),
                "wall_time": wall,
            }
            for run in runs
        ]
    )


def everything(campaign: Campaign):
    return campaign.table().drop_columns(["wall_time"])


def names(campaign: Campaign) -> list[str]:
    return sorted(path.name for path in campaign.results.iterdir())


def written(campaign: Campaign, blocks: list[range], flushed: set[int], wall: float = 1.0) -> None:
    writer = Writer(campaign)
    for i, block in enumerate(blocks):
        writer.add(block, rows_of(block, wall))
        if i in flushed:
            writer.flush()
    writer.finish()


@st.composite
def blocks(draw):
    cuts = sorted(draw(st.sets(st.integers(1, RUNS - 1))))
    edges = [0, *cuts, RUNS]
    made = [range(a, b) for a, b in pairwise(edges)]
    return draw(st.permutations(made)), draw(st.sets(st.integers(0, len(made) - 1)))


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(blocks())
def test_the_files_are_the_same_however_the_rows_came(make_spec, tmp_path_factory, drawn) -> None:
    spec = make_spec(runs=RUNS)
    one, other = (Campaign.create(tmp_path_factory.mktemp("c") / "out", spec) for _ in range(2))
    written(one, [range(RUNS)], set())
    written(other, *drawn, wall=2.0)
    assert names(one) == names(other) == [
        "part-0-8.parquet", "part-16-7.parquet", "part-8-8.parquet",
    ]  # fmt: skip
    assert everything(one).equals(everything(other))
    assert other.is_complete
    schemas = {str(pq.read_schema(part.path)) for part in (*one.parts, *other.parts)}
    assert len(schemas) == 1, "any reader of Parquet takes them as one table"


def test_what_is_done_and_what_is_missing(campaign) -> None:
    writer = Writer(campaign)
    assert campaign.missing == (range(RUNS),)
    writer.add(range(3, 7), rows_of(range(3, 7)))
    writer.add(range(7, 10), rows_of(range(7, 10)))
    assert campaign.done == (), "not yet written"
    writer.flush()
    assert campaign.done == (range(3, 8), range(8, 10))
    assert campaign.missing == (range(3), range(10, RUNS))
    assert not campaign.is_complete
    assert campaign.counts() == {"passed": 1, "failed": 6}
    assert campaign.table(["run"])["run"].to_pylist() == list(range(3, 10))
    assert campaign.row(9)["x"] == 3.0
    with pytest.raises(RecordingError, match="received run 2; required a run whose row is there"):
        campaign.row(2)


def test_rows_are_written_when_there_are_many_of_them(campaign, monkeypatch) -> None:
    monkeypatch.setattr(module, "_HELD", 6)
    writer = Writer(campaign)
    writer.add(range(4), rows_of(range(4)))
    assert campaign.done == ()
    writer.add(range(4, 6), rows_of(range(4, 6)))
    assert campaign.done == (range(6),)


def test_rows_are_written_when_they_have_waited(campaign, monkeypatch) -> None:
    monkeypatch.setattr(module, "_PERIOD", 0.0)
    writer = Writer(campaign)
    writer.add(range(4), rows_of(range(4)))
    assert campaign.done == (range(4),)


@pytest.mark.parametrize("damage", ["cut", "empty", "fewer rows"])
def test_a_torn_part_is_flown_again(campaign, damage: str) -> None:
    writer = Writer(campaign)
    for runs in (range(4), range(8, 12)):
        writer.add(runs, rows_of(runs))
        writer.flush()
    path = campaign.parts[0].path
    content = path.read_bytes()
    if damage == "fewer rows":
        pq.write_table(rows_of(range(2)), path)
    else:
        path.write_bytes(content[: len(content) // 2] if damage == "cut" else b"")
    (campaign.results / ".part-16-2.parquet.part").write_bytes(b"torn")
    Writer(campaign)
    assert names(campaign) == ["part-8-4.parquet"]
    assert campaign.missing == (range(8), range(12, RUNS))


def test_parts_that_a_crash_left_beside_the_joined_one_are_passed_over(campaign) -> None:
    written(campaign, [range(RUNS)], set())
    before = everything(campaign)
    left = Part.of(campaign.results, range(2, 6))
    pq.write_table(rows_of(left.runs), left.path)
    assert everything(campaign).equals(before)
    Writer(campaign).finish()
    assert not left.path.exists()
    assert everything(campaign).equals(before)


def test_a_folder_is_that_of_one_campaign(campaign, make_spec) -> None:
    folder = campaign.folder
    assert Campaign.create(folder, campaign.spec).spec == campaign.spec
    told = json.loads((folder / "campaign.json").read_text())
    assert told["pass"] == campaign.spec.variations.criterion.text
    assert told["worst"] == 2
    with pytest.raises(RecordingError) as error:
        Campaign.create(folder, make_spec(runs=RUNS, seed=0))
    assert str(error.value).startswith(
        f"--out: received '{folder}', the folder of another campaign (seed 7 instead of 0); "
    )
    with pytest.raises(RecordingError, match="which holds other files"):
        Campaign.create(folder.parent, campaign.spec)


def test_what_is_no_campaign_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="cannot be read as a campaign"):
        Campaign.open(tmp_path)
    (tmp_path / "campaign.json").write_text('{"seed": 3}')
    with pytest.raises(RecordingError, match="cannot be read as a campaign"):
        Campaign.open(tmp_path)


def test_one_process_at_a_time_writes_a_campaign(campaign) -> None:
    told = "which another process is writing"
    with exclusive(campaign), pytest.raises(RecordingError, match=told), exclusive(campaign):
        pass
    with exclusive(campaign):
        pass


def test_pandas_polars_and_duckdb_read_the_rows(campaign) -> None:
    import duckdb
    import pandas as pd
    import polars as pl

    written(campaign, [range(10, RUNS), range(10)], {0})
    expected = campaign.table()["x"].to_pylist()
    frame = pd.read_parquet(campaign.results).sort_values("run")
    assert [None if pd.isna(x) else x for x in frame["x"]] == expected
    assert pl.read_parquet(campaign.results / "*.parquet").sort("run")["x"].to_list() == expected
    query = f"select x from read_parquet('{campaign.results}/*.parquet') order by run"
    assert [x for (x,) in duckdb.sql(query).fetchall()] == expected
