"""``gnc report``: one HTML page about one or several flights."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    NamespaceOption,
    QuietOption,
    UnfinishedOption,
    given_scenario,
    print_json,
    require_writable,
    tell_unused,
)
from spacecraft_gnc.cli._progress import Progress, show_progress
from spacecraft_gnc.cli.plot import ScenarioOption

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.report import Run

SourcesArgument = Annotated[
    list[Path],
    typer.Argument(
        metavar="BAG|FILE.npz",
        help="Bag folder, .mcap file, or .npz of gnc simulate or gnc plan; several are compared "
        "with the first.",
        readable=False,
    ),
]
OutOption = Annotated[
    Path,
    typer.Option("--out", "-o", metavar="FILE.html", readable=False, help="Where to write it."),
]
TitleOption = Annotated[
    str,
    typer.Option(
        "--title", metavar="TEXT", help="Heading of the page.  [default: names of the runs]"
    ),
]


def report(
    sources: SourcesArgument,
    out: OutOption = Path("report.html"),
    scenario: ScenarioOption = None,
    title: TitleOption = "",
    namespace: NamespaceOption = None,
    unfinished: UnfinishedOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Write one self-contained HTML page: curves, 3-D view, summary, audit of one or more runs.

    A bag of several spacecraft is shown as several runs, unless --namespace names one.
    """
    from spacecraft_gnc.analysis.agents import agents
    from spacecraft_gnc.analysis.plan_file import require_one_kind
    from spacecraft_gnc.analysis.report import read_run, report_html
    from spacecraft_gnc.analysis.run_names import run_names
    from spacecraft_gnc.drawing.page import write_page

    require_writable(out, ".html")
    require_one_kind(sources)
    known = given_scenario(scenario, namespace)
    runs: list[Run] = []
    with show_progress("reading", silent=quiet) as progress:
        listed = [
            (path, name if agent is None or agent == namespace else f"{name} {agent}", agent)
            for path, name in zip(sources, run_names(sources), strict=True)
            for agent in agents(path, namespace, allow_unfinished=unfinished)
        ]
        for path, name, agent in listed:
            progress(len(runs), len(listed), f"reading {name}")
            watch = partial(_part, progress, name)
            found = read_run(
                path,
                name,
                known,
                namespace=agent,
                allow_unfinished=unfinished,
                progress=watch,
            )
            tell_unused(found.info, known)
            runs.append(found)
        progress(0, 1, "writing")
        write_page(report_html(runs, title), out)
    _tell(runs, out, as_json=as_json, quiet=quiet)


def _part(progress: Progress, name: str, what: str) -> Callable[[int, int], None]:
    """Return what shows the progress of a part of a run's audit."""
    return partial(progress, what=f"auditing {name}: {what}")


def _tell(runs: list[Run], out: Path, *, as_json: bool, quiet: bool) -> None:
    for run in runs:
        for warning in run.warnings():
            print(f"warning: {run.name}: {warning}", file=sys.stderr)
    if as_json:
        print_json({"out": out, "bytes": out.stat().st_size, "runs": [_described(r) for r in runs]})
    elif not quiet:
        print(out)


def _described(run: Run) -> dict[str, object]:
    return {
        "name": run.name,
        "path": str(run.info.path),
        "metrics": run.metrics,
        "audit": {"passed": run.verdict.passed, "text": run.verdict.text},
        "warnings": run.warnings(),
    }
