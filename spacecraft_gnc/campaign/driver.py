"""A campaign from its first run to its kept flights."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final, NamedTuple, Protocol

from spacecraft_gnc.campaign.engine import BlockSize, Engine
from spacecraft_gnc.campaign.flyer import ERROR, FAILED, HEAD, PASSED, Flyer, row_differences
from spacecraft_gnc.campaign.keeping import kept_runs
from spacecraft_gnc.campaign.results import Campaign
from spacecraft_gnc.campaign.spec import Spec
from spacecraft_gnc.campaign.tables import table_of
from spacecraft_gnc.campaign.tasks import Kept, fly_kept, fly_rows
from spacecraft_gnc.campaign.writer import Writer
from spacecraft_gnc.drawing.whole_file import whole_file
from spacecraft_gnc.errors import ParameterError

_TRIED: Final = 10  # runs, for what metrics a flight has


class Progress(Protocol):
    """Called after every block."""

    def __call__(self, done: int, total: int, counts: Counter[str]) -> None:
        """Tell how many runs of how many are done, and how many have which status."""


class Keeping(NamedTuple):
    """What was kept of a complete campaign."""

    runs: tuple[int, ...]
    left_out: int
    """Failed runs beyond those that are kept."""
    mismatches: tuple[str, ...]
    """Flights that did not give their row again, a text for each."""


def require_metrics(spec: Spec) -> None:
    """Refuse a criterion that names no metric of a flight; fly one to know them.

    Raises
    ------
    ParameterError
        If it does, or if neither the scenario as it stands nor one of the first runs can be flown.
    """
    flyer, reason = Flyer(spec), None
    for row in _first_rows(flyer):
        if row["status"] in (PASSED, FAILED):
            known = [name for name in row if name not in HEAD]
            spec.variations.criterion.check(known)
            return
        reason = reason or row["reason"]
    raise ParameterError(
        f"{spec.scenario_path}: received a campaign of which the first {min(_TRIED, spec.runs)} "
        f"runs cannot be flown ({reason}); required runs that fly; mend the scenario or the "
        "variations"
    )


def _first_rows(flyer: Flyer) -> Iterator[dict[str, object]]:
    yield flyer.fly_nominal().row
    for run in range(min(_TRIED, flyer.spec.runs)):
        yield flyer.fly(run).row


def fly_missing(campaign: Campaign, engine: Engine, progress: Progress) -> None:
    """Fly the runs of a campaign that have no row yet, and write their rows.

    What is done is written also where it ends early, by Ctrl-C or by a loss of the scheduler.
    """
    spec, size, writer = campaign.spec, BlockSize(), Writer(campaign)
    flyer, counts = Flyer(spec), campaign.counts()
    try:
        for runs, rows in engine.map(fly_rows, spec, campaign.missing, size):
            if rows is None:
                reason = "ended every worker process that it was given to"
                table = table_of([flyer.row_without_flight(runs.start, reason)])
                counts[ERROR] += 1
            else:
                table = rows.table
                size.learn(rows.seconds)
                counts.update(table["status"].to_pylist())
            writer.add(runs, table)
            progress(counts.total(), spec.runs, counts)
    finally:
        writer.flush()
    writer.finish()


def keep_flights(
    campaign: Campaign,
    engine: Engine,
    first: int,
    most_failed: int,
    progress: Callable[[int, int], object],
) -> Keeping:
    """Fly the runs of a complete campaign that are to be kept once more, and save their flights.

    Parameters
    ----------
    campaign, engine
        What was flown, and what flies.
    first
        Number of first runs to keep.
    most_failed
        Number of failed runs to keep at most.
    progress
        Called with how many are flown of how many.
    """
    chosen, left_out = kept_runs(campaign, first, most_failed)
    wanted = [run for run in chosen if not campaign.flight_of(run).exists()]
    mismatches = []
    blocks = [range(run, run + 1) for run in wanted]
    for done, (runs, kept) in enumerate(engine.map(fly_kept, campaign.spec, blocks), 1):
        (flight,) = kept or [Kept({}, b"")]
        wrong = row_differences(campaign.row(runs.start), flight.row)
        if wrong:
            mismatches.append(f"run {runs.start}: {wrong[0]}")
        else:
            _save(campaign.flight_of(runs.start), flight.file)
        progress(done, len(wanted))
    return Keeping(tuple(chosen), left_out, tuple(mismatches))


def kept_before(campaign: Campaign, first: int, most_failed: int) -> Keeping | None:
    """Return what is kept of a complete campaign; None where a flight is still to be flown."""
    chosen, left_out = kept_runs(campaign, first, most_failed)
    is_kept = all(campaign.flight_of(run).exists() for run in chosen)
    return Keeping(tuple(chosen), left_out, ()) if is_kept else None


def _save(path: Path, content: bytes) -> None:
    with whole_file(path) as file:
        file.write_bytes(content)
