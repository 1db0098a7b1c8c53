"""Runs of a campaign that did not pass, grouped by reason, and its worst runs."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from spacecraft_gnc.campaign.columns import numbers
from spacecraft_gnc.campaign.criterion import Criterion
from spacecraft_gnc.campaign.flyer import FAILED, PASSED
from spacecraft_gnc.campaign.keeping import worst_values
from spacecraft_gnc.campaign.statistics import MOST_CATEGORIES

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.results import Campaign

MOST_GROUPS: Final = 40
"""Largest groups that are listed."""
LISTED: Final = 5
"""Runs that are named of each group."""
WORST: Final = 10
"""Worst runs that are listed of each metric."""
_LOOKED_AT: Final = 1000
_NUMBER: Final = r"[-+]?[0-9]+(\.[0-9]*)?([eE][-+]?[0-9]+)?"


class Group(NamedTuple):
    """Runs that ended alike.

    Attributes
    ----------
    status, reason
        Of the first of them; of a failed run, the parts of the criterion that it did not meet.
    size
        How many there are.
    first_runs
        The first ones, at most `LISTED`.
    """

    status: str
    reason: str
    size: int
    first_runs: tuple[int, ...]


class WorstRun(NamedTuple):
    """A run and its value of the metric."""

    run: int
    value: float
    status: str


class Worst(NamedTuple):
    """Worst runs of a metric of the criterion.

    Attributes
    ----------
    metric
        Its name.
    is_largest
        Whether larger values are worse.
    missing
        Runs that were flown and have no value: these did not pass.
    runs
        The worst one first, at most `WORST`.
    """

    metric: str
    is_largest: bool
    missing: int
    runs: tuple[WorstRun, ...]


def word_counts(column: Any) -> dict[str, int]:
    """Return how often each text of an Arrow column occurs, the most frequent first.

    Empty where there are more than `MOST_CATEGORIES` different ones.
    """
    for some in (column.slice(0, _LOOKED_AT), column):  # most columns of many show it at once
        counted = pc.value_counts(some.drop_null())
        if len(counted) > MOST_CATEGORIES:
            return {}
    pairs = [(str(each["values"]), int(each["counts"])) for each in counted.to_pylist()]
    return dict(sorted(pairs, key=lambda each: (-each[1], each[0])))


def without_numbers(column: Any) -> Any:
    """Return an Arrow column of texts with # for every number in them."""
    return pc.replace_substring_regex(column, _NUMBER, "#")


def groups(campaign: Campaign) -> Iterator[Group]:
    """Yield what became of the runs that did not pass, the largest group first.

    Reasons that differ in numbers only are one. Runs that failed are told apart by the parts of the
    criterion that they do not meet.
    """
    table = _with_reasons(campaign)
    is_criterion = pc.equal(table["status"], FAILED)  # whose numbers are its own
    forms = pc.if_else(is_criterion, table["reason"], without_numbers(table["reason"]))
    table = table.append_column("form", forms)
    found = table.group_by(["status", "form"]).aggregate([("run", "count"), ("run", "min")])
    by_size = sorted(found.to_pylist(), key=lambda each: (-each["run_count"], each["run_min"]))
    for each in by_size[:MOST_GROUPS]:
        alike = table.filter(
            pc.and_(
                pc.equal(table["status"], each["status"]), pc.equal(table["form"], each["form"])
            )
        ).slice(0, LISTED)
        runs = tuple(alike["run"].to_pylist())
        yield Group(each["status"], alike["reason"][0].as_py(), each["run_count"], runs)


def _with_reasons(campaign: Campaign) -> Any:
    """Return run, status and reason of the runs that did not pass."""
    criterion = campaign.spec.variations.criterion
    metrics = sorted(criterion.names & set(campaign.schema.names))
    clauses = [Criterion.parse(text) for text in clauses_of(criterion.text)]
    parts = []
    for table in campaign.tables(["run", "status", "reason", *metrics]):
        some = table.filter(pc.not_equal(table["status"], PASSED))
        rows = some.select(["status", "reason", *metrics]).to_pylist()
        reasons = pa.array([_reason(row, clauses) for row in rows], pa.string())
        parts.append(some.select(["run", "status"]).append_column("reason", reasons))
    return pa.concat_tables(parts)


def _reason(row: Mapping[str, Any], clauses: Sequence[Criterion]) -> str:
    if row["status"] != FAILED or row["reason"]:
        return row["reason"] or ""
    return f"not met: {'; '.join(each.text for each in clauses if not each.holds(row))}"


def clauses_of(text: str) -> list[str]:
    """Return the parts of a criterion that are joined by ``and``, as they are written."""
    text = text.strip()
    tree = ast.parse(text, mode="eval").body
    if not isinstance(tree, ast.BoolOp) or not isinstance(tree.op, ast.And):
        return [text]
    return [ast.get_source_segment(text, part) or ast.unparse(part) for part in tree.values]


def worst_runs(campaign: Campaign) -> Iterator[Worst]:
    """Yield the worst runs of each metric of the criterion that has a direction."""
    criterion = campaign.spec.variations.criterion
    for metric, sign in criterion.worse.items():
        if metric in campaign.schema.names:
            table = campaign.table(["run", "status", metric])
            values = numbers(table[metric])
            if values is not None and values.ndim == 1:
                flown = np.asarray(pc.is_in(table["status"], value_set=pa.array([PASSED, FAILED])))
                missing = int(np.count_nonzero(flown & np.isnan(values)))
                worst = worst_values(campaign, metric, WORST)
                yield Worst(metric, sign > 0, missing, tuple(_with_status(table, worst)))


def _with_status(table: Any, worst: Sequence[tuple[int, float]]) -> Iterator[WorstRun]:
    places = np.searchsorted(table["run"].to_numpy(), [run for run, _ in worst])
    for place, (run, value) in zip(places.tolist(), worst, strict=True):
        yield WorstRun(run, value, table["status"][place].as_py())
