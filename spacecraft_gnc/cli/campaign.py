"""``gnc campaign``: many flights of one scenario, and what came of them.

Its first word is that of a scenario, which is flown, or of a further command.
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Sequence
from datetime import timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import typer

from spacecraft_gnc.arguments import as_count
from spacecraft_gnc.cli._campaign_options import (
    KeepFailedOption,
    KeepOption,
    OutOption,
    RunsOption,
    SchedulerOption,
    SeedOption,
    SpotCheckOption,
    VariationsArgument,
    WorkersOption,
)
from spacecraft_gnc.cli._campaign_report import report
from spacecraft_gnc.cli._campaign_rerun import rerun
from spacecraft_gnc.cli._common import (
    JsonOption,
    QuietOption,
    RunFailed,
    ScenarioArgument,
    SetOption,
    SpacecraftOption,
    json_able,
    print_json,
    print_table,
    require_folder,
    tell_warnings,
)
from spacecraft_gnc.cli._help import App, Command, Group
from spacecraft_gnc.cli._progress import Progress, show_progress
from spacecraft_gnc.errors import GncError, ParameterError
from spacecraft_gnc.extras import require_ros

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.driver import Keeping
    from spacecraft_gnc.campaign.results import Campaign
    from spacecraft_gnc.cli._campaign_graph import GraphRun

_PASSED: Final = "passed"
_INTERRUPTED: Final = 130  # as a shell reports SIGINT
_FOLDER: Final = Path("runs", "campaigns")


def fly(
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
    spot_check: SpotCheckOption = 0,
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

    _require_one_source(workers, scheduler)
    if spot_check:
        require_ros()
    base = load(scenario, overrides or (), namespace)
    varied = load_variations(variations, base)
    seed = as_count("--seed", seed, least=0, most=LARGEST_SEED)
    spec = Spec.of(base, varied, seed, runs_of(varied, runs))
    folder = _FOLDER / variations.stem if out is None else out
    require_folder(folder)
    silent = quiet or as_json
    if not silent:
        tell_warnings(base)
    is_new = not Campaign.exists(folder)
    if is_new:
        require_metrics(spec)  # first: a folder is made for what can be flown
    found = Campaign.create(folder, spec)
    with exclusive(found):
        try:
            keeping = _fly(found, workers, scheduler, keep, keep_failed, silent=quiet)
        except GncError:
            if is_new and not found.done:
                found.discard()
            raise
        checked = _spot_check(found, spot_check, silent=quiet) if spot_check else ()
        summary = summarize(found, keeping)
        if checked:
            summary["spot_checks"] = json_able([each.as_dict() for each in checked])
        found.write_summary(summary)
    _tell(found, summary, as_json=as_json, quiet=quiet)
    _require_same(keeping, checked)


def _require_one_source(workers: int | None, scheduler: str | None) -> None:
    if workers is None:
        return
    as_count("--workers", workers)
    if scheduler is not None:
        raise ParameterError(
            "--workers: received beside --scheduler; required one of them: a scheduler has workers "
            "of its own; leave --workers out"
        )


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
        refused = counts["refused"]
        told = f"{passed} passed, {done - passed - refused} failed"
        told += f", {refused} refused" if refused else ""
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
    if "spot_checks" in summary:
        same = sum(not each["problems"] for each in summary["spot_checks"])
        told = f"{same} of {len(summary['spot_checks'])} the same bits in the graph"
        rows.append(("spot checks", told))
    return [*rows, ("kept", kept)]


def _spot_check(found: Campaign, count: int, *, silent: bool) -> tuple[GraphRun, ...]:
    from spacecraft_gnc.cli._campaign_graph import spot_check

    return spot_check(found, count, silent=silent)


def _require_same(keeping: Keeping, checked: Sequence[GraphRun]) -> None:
    """End with 1 where a flight did not give its row again.

    Raises
    ------
    RunFailed
        With how many and the first of them.
    """
    from spacecraft_gnc.cli._campaign_graph import report_spot_checks

    if keeping.mismatches:
        raise RunFailed(
            f"flown again: {len(keeping.mismatches)} flights did not give their row "
            f"({keeping.mismatches[0]}); required the same bits; compare the versions and "
            "processors of the workers"
        )
    if checked and not report_spot_checks(checked):
        raise RunFailed(
            f"spot check: {sum(bool(each.problems) for each in checked)} of {len(checked)} runs "
            "differ in the graph; required the same bits; see the bags in spot_checks"
        )


class _Flying(Command):
    """The command that flies, whose help lists the further ones."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write the arguments, the options and the further commands."""
        super().format_options(ctx, formatter)
        with formatter.section("Commands"):
            formatter.write_dl(list(_FURTHER.items()))


class _Default(Group):
    """A group that flies unless its first word is that of a command."""

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Return the context of the command that flies, or of the group."""
        if args and args[0] in self.commands:
            return super().make_context(info_name, args, parent, **extra)
        app = App()
        app.command(info_name, cls=_Flying)(fly)
        return typer.main.get_command(app).make_context(info_name, args, parent, **extra)


_FURTHER: Final = {
    "report": "Write one HTML page about a campaign.",
    "rerun": "Fly one run of a campaign again, alone or in the graph.",
}
campaign = App(cls=_Default)
campaign.command("report")(report)
campaign.command("rerun")(rerun)
