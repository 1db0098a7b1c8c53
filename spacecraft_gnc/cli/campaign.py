"""``gnc campaign``: many flights of one scenario, and what came of them."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from spacecraft_gnc.arguments import as_count
from spacecraft_gnc.cli._common import (
    JsonOption,
    QuietOption,
    RunFailed,
    ScenarioArgument,
    SetOption,
    SpacecraftOption,
    print_json,
    print_table,
    require_folder,
    tell_warnings,
)
from spacecraft_gnc.cli._progress import Progress, show_progress
from spacecraft_gnc.errors import ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.driver import Keeping
    from spacecraft_gnc.campaign.results import Campaign

_PASSED: Final = "passed"
_INTERRUPTED: Final = 130  # as a shell reports SIGINT
_FOLDER: Final = Path("runs", "campaigns")

VariationsArgument = Annotated[
    Path,
    typer.Argument(
        metavar="VARIATIONS.yaml",
        readable=False,
        help="What varies and what counts as success: a file, or the name of a shipped one.",
    ),
]
RunsOption = Annotated[
    int | None,
    typer.Option("--runs", "-n", metavar="N", help="Number of runs.  [default: of the file]"),
]
SeedOption = Annotated[int, typer.Option("--seed", metavar="S", help="Master seed.")]
OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        metavar="DIR",
        help="New folder, or that of this campaign, which goes on.  "
        "[default: runs/campaigns/VARIATIONS]",
        show_default=False,
    ),
]
WorkersOption = Annotated[
    int | None,
    typer.Option(
        "--workers", "-w", metavar="N", help="Worker processes to start.  [default: one a core]"
    ),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Use the workers of this dask scheduler instead, such as tcp://127.0.0.1:8786.",
    ),
]
KeepOption = Annotated[
    int, typer.Option("--keep", metavar="N", min=0, help="Keep the flights of the first N runs.")
]
KeepFailedOption = Annotated[
    int,
    typer.Option(
        "--keep-failed", metavar="N", min=0, help="Keep the flights of at most N failed runs."
    ),
]


def campaign(
    scenario: ScenarioArgument,
    variations: VariationsArgument,
    runs: RunsOption = None,
    seed: SeedOption = 0,
    out: OutOption = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    overrides: SetOption = None,
    keep: KeepOption = 0,
    keep_failed: KeepFailedOption = 100,
    namespace: SpacecraftOption = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Fly a scenario many times, each time varied, and say how often it succeeds.

    The same command again goes on where it was ended.
    """
    from spacecraft_gnc.campaign.driver import require_metrics
    from spacecraft_gnc.campaign.results import Campaign
    from spacecraft_gnc.campaign.spec import Spec, runs_of
    from spacecraft_gnc.campaign.summary import summarize
    from spacecraft_gnc.campaign.variations import load_variations
    from spacecraft_gnc.campaign.writer import exclusive
    from spacecraft_gnc.plant.random_numbers import LARGEST_SEED
    from spacecraft_gnc.scenario import load

    if workers is not None and scheduler is not None:
        raise ParameterError(
            "--workers: received beside --scheduler; required one of them: a scheduler has workers "
            "of its own; leave --workers out"
        )
    if workers is not None:
        as_count("--workers", workers)
    base = load(scenario, overrides or (), namespace)
    varied = load_variations(variations, base)
    seed = as_count("--seed", seed, least=0, most=LARGEST_SEED)
    spec = Spec.of(base, varied, seed, runs_of(varied, runs))
    folder = _FOLDER / variations.stem if out is None else out
    require_folder(folder)
    silent = quiet or as_json
    if not silent:
        tell_warnings(base)
    if not Campaign.exists(folder):
        require_metrics(spec)  # first: a folder is made for what can be flown
    found = Campaign.create(folder, spec)
    with exclusive(found):
        keeping = _fly(found, workers, scheduler, keep, keep_failed, silent=quiet)
        summary = summarize(found, keeping)
        found.write_summary(summary)
    _tell(found, summary, as_json=as_json, quiet=quiet)
    if keeping.mismatches:
        raise RunFailed(_mismatch(keeping.mismatches))


def _fly(
    found: Campaign,
    workers: int | None,
    scheduler: str | None,
    keep: int,
    keep_failed: int,
    *,
    silent: bool,
) -> Keeping:
    """Fly what is missing and keep what is to be kept; tell how to go on after Ctrl-C."""
    from spacecraft_gnc.campaign.cluster import connected
    from spacecraft_gnc.campaign.driver import fly_missing, keep_flights, kept_before
    from spacecraft_gnc.campaign.engine import Engine

    if found.is_complete and (keeping := kept_before(found, keep, keep_failed)):
        return keeping
    try:
        with connected(workers, scheduler) as client:
            engine = Engine(client)
            with show_progress("flying", silent=silent) as show:
                fly_missing(found, engine, _Rate(show))
            with show_progress("keeping flights", silent=silent) as show:
                return keep_flights(found, engine, keep, keep_failed, show)
    except KeyboardInterrupt:
        done = sum(map(len, found.done))
        print(
            f"interrupted: {done} of {found.spec.runs} runs are in {found.folder}; the same "
            "command goes on",
            file=sys.stderr,
        )
        raise typer.Exit(_INTERRUPTED) from None


class _Rate:
    """Shows how fast the runs are flown, and how they end; the start of the workers left out."""

    def __init__(self, show: Progress) -> None:
        self._show = show
        self._first: tuple[int, float] | None = None

    def __call__(self, done: int, total: int, counts: Counter[str]) -> None:
        """Show it."""
        now, passed = time.perf_counter(), counts[_PASSED]
        self._first = before, begun = self._first or (done, now)
        told = f"{passed} passed, {done - passed} failed"
        if done > before:
            rate = (done - before) / (now - begun)
            left = timedelta(seconds=round((total - done) / rate))
            told = f"{rate:.3g}/s, {told}, {left} left"
        self._show(done, total, told)


def _tell(found: Campaign, summary: dict[str, Any], *, as_json: bool, quiet: bool) -> None:
    if as_json:
        print_json({"folder": found.folder, **summary})
    elif not quiet:
        print(f"{found.folder}: {summary['done']} runs of {found.spec.scenario_path}")
        print_table(_rows(summary))


def _rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    rows = [("passed", f"{summary['passed']} ({100.0 * summary['success_rate']:.4g} %)")]
    rows += [(status, str(summary[status])) for status in ("failed", "refused", "error")]
    rows.append(("speed", f"{summary['flights_per_core_second']:.4g} flights per second and core"))
    kept = f"{len(summary['kept'])} flights"
    if summary["failed_not_kept"]:
        kept += f"; {summary['failed_not_kept']} more failed (--keep-failed)"
    return [*rows, ("kept", kept)]


def _mismatch(mismatches: Sequence[str]) -> str:
    return (
        f"flown again: {len(mismatches)} flights did not give their row ({mismatches[0]}); "
        "required the same bits; compare the versions and processors of the workers"
    )
