"""``gnc reproduce``: a paper's cases, ours beside the paper's figures."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spacecraft_gnc.cli._common import (
    QuietOption,
    RunFailed,
    json_able,
    require_folder,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import RecordingError

if TYPE_CHECKING:
    from spacecraft_gnc.studies.report import Report

NameArgument = Annotated[
    str | None,
    typer.Argument(
        metavar="NAME",
        help="gupta2015, bagherzadeh2023, kalabic2014, afrl2016 or phogat.  [default: all]",
    ),
]
ResultOption = Annotated[
    Path | None, typer.Option("--json", metavar="FILE", help="Write the figures here as JSON.")
]
OutOption = Annotated[
    Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the pictures.")
]
BaselinesOption = Annotated[
    bool,
    typer.Option("--baselines/--no-baselines", help="Run the slow baseline solvers as well."),
]
PartOption = Annotated[
    str | None,
    typer.Option(
        "--only",
        metavar="PART",
        help="One part of a paper: two_wheel, docking or formation of afrl2016.  [default: all]",
    ),
]
RunsOption = Annotated[
    int | None,
    typer.Option(
        "--runs",
        "-n",
        metavar="N",
        min=0,
        help="Flights of each campaign of a paper; 0: none.  [default: 1000]",
        show_default=False,
    ),
]


def reproduce(
    name: NameArgument = None,
    result: ResultOption = None,
    out: OutOption = Path("runs/reproduce"),
    baselines: BaselinesOption = True,
    only: PartOption = None,
    runs: RunsOption = None,
    quiet: QuietOption = False,
) -> None:
    """Run a paper's cases; print ours beside the paper's figures; draw its pictures.

    A campaign of a paper is flown in a folder of its name beside the pictures, and goes on there
    if it was ended. Ends with 1 where a figure does not come out.
    """
    from spacecraft_gnc.drawing.figures import save_figures
    from spacecraft_gnc.studies import PAPERS, reproduce, require_paper, require_part
    from spacecraft_gnc.studies.options import Options

    if name is not None:
        require_paper(name)
    if only is not None:
        require_part(name, only)
    _require_writable(result)
    require_folder(out)
    reports = []
    for paper in PAPERS if name is None else [name]:
        with show_progress("flying", silent=quiet) as show:
            options = Options(
                baselines=baselines,
                only=only,
                folder=out,
                runs=runs,
                progress=lambda what, step, n_steps: show(step, n_steps, what),
            )
            report = reproduce(paper, options)
            files = save_figures(report.draw(), out)
        if not quiet:
            _print(report, files)
        reports.append(report)
    if result is not None:
        values = {report.name: report.to_dict() for report in reports}
        result.write_text(json.dumps(json_able(values), indent=2) + "\n", encoding="utf-8")
    failed = [f"{r.name}: {check.quantity}" for r in reports for check in r.failed]
    if failed:
        number = "1 figure" if len(failed) == 1 else f"{len(failed)} figures"
        raise RunFailed(
            f"reproduce: {number} did not come out ({'; '.join(failed)}); "
            "required every check within its tolerance; see the rows NOT OK"
        )


def _require_writable(result: Path | None) -> None:
    """Refuse a file that could not be written, before anything is flown."""
    if result is None:
        return
    folder = result.parent
    if result.is_dir():
        problem, remedy = "a directory", "name a file in it"
    elif not folder.is_dir():
        problem, remedy = "in a folder that does not exist", f"create it: mkdir -p {folder}"
    elif not os.access(result if result.exists() else folder, os.W_OK):
        problem, remedy = "which may not be written", "choose another one"
    else:
        return
    raise RecordingError(
        f"--json: received {str(result)!r}, {problem}; required a file to write; {remedy}"
    )


def _print(report: Report, files: list[Path]) -> None:
    for line in report.lines():
        print(line)
    print()
    for file in files:
        print(f"written to {file}")
    print()
