"""``gnc plot``: figures of a recorded or simulated flight."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    NamespaceOption,
    QuietOption,
    UnfinishedOption,
    given_scenario,
    known_scenario,
    print_json,
    require_folder,
    require_writable,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import ParameterError

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.flown import Flown
    from spacecraft_gnc.cli._progress import Progress
    from spacecraft_gnc.drawing.figures import Maker
    from spacecraft_gnc.scenario import Scenario


class Format(str, Enum):
    """File formats of figures."""

    PNG = "png"
    SVG = "svg"
    PDF = "pdf"


class ErrorScale(str, Enum):
    """Scale of the attitude error."""

    LOG = "log"
    LINEAR = "linear"


SourcesArgument = Annotated[
    list[Path],
    typer.Argument(
        metavar="RUN",
        help="Folder of a launch, bag folder, .mcap file, or .npz of gnc simulate or gnc plan; "
        "several are drawn over each other.",
    ),
]
OnlyOption = Annotated[
    list[str] | None,
    typer.Option(
        "--only",
        metavar="NAME",
        help="Draw this figure; may be given several times.  [default: all]",
    ),
]
OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out", "-o", metavar="FOLDER", help="Folder of the figures.  [default: ./NAME-figures]"
    ),
]
FormatOption = Annotated[
    list[Format],
    typer.Option(
        "--format",
        "-f",
        metavar="png|svg|pdf",
        help="File format; may be given several times.",
    ),
]
ScenarioOption = Annotated[
    Path | None,
    typer.Option(
        "--scenario",
        metavar="SCENARIO.yaml",
        help="Torque limit and pointing zones, where the source does not hold them.",
    ),
]
ScaleOption = Annotated[
    ErrorScale,
    typer.Option("--error-scale", metavar="log|linear", help="Scale of the attitude error."),
]
TitleOption = Annotated[
    str | None,
    typer.Option(
        "--title", metavar="TEXT", help="Heading of the overview.  [default: name of the source]"
    ),
]

AnimateOption = Annotated[
    Path | None,
    typer.Option(
        "--animate",
        metavar="FILE.gif",
        help="Write a moving picture instead: spacecraft, zones, error and torque, the runs side "
        "by side.",
    ),
]


def plot(
    sources: SourcesArgument,
    out: OutOption = None,
    formats: FormatOption = [Format.PNG, Format.SVG],  # noqa: B006  # typer copies it
    only: OnlyOption = None,
    scenario: ScenarioOption = None,
    error_scale: ScaleOption = ErrorScale.LOG,
    title: TitleOption = None,
    animate: AnimateOption = None,
    namespace: NamespaceOption = None,
    unfinished: UnfinishedOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Draw the figures of a flight or plan for print, or of several over each other."""
    from spacecraft_gnc.analysis.plan_file import require_one_kind
    from spacecraft_gnc.analysis.plans import figures_part
    from spacecraft_gnc.analysis.run_info import UNKNOWN_SCENARIO
    from spacecraft_gnc.analysis.run_names import run_names

    given = given_scenario(scenario, namespace)
    require_folder(out)
    require_one_kind(sources)
    if animate is not None:
        require_writable(animate, ".gif", "--animate")
        _require_alone(out, only)
    with show_progress("reading", silent=quiet) as progress:
        runs = [
            _read(name, path, given, namespace, allow_unfinished=unfinished)
            for name, path in zip(run_names(sources), sources, strict=True)
        ]
        named = [run.name for run in runs]
        if animate is not None:
            progress(0, 1, "drawing the moving picture")
            heading = " and ".join(named) if title is None else title
            figures_part(runs).animate(runs, animate, title=heading)
            files = [animate]
        else:
            makers = _makers(runs, title, error_scale.value)
            folder = (
                out if out is not None else Path(f"{'-'.join(named)}-figures".replace("/", "_"))
            )
            files = _drawn(makers, _chosen(makers, only), folder, formats, progress)
    for run in runs:
        for warning in run.info.warnings():
            print(f"warning: {warning}", file=sys.stderr)
        if run.scenario is None and not (quiet or run.info.is_plan):
            print(f"note: {run.info.path}: {UNKNOWN_SCENARIO}", file=sys.stderr)
    if as_json:
        metrics = {run.name: _metrics(run) for run in runs}
        described = (
            {"runs": metrics} if len(runs) > 1 else {"metrics": next(iter(metrics.values()))}
        )
        source = sources if len(runs) > 1 else sources[0]
        print_json({"source": source, "files": [str(file) for file in files], **described})
    elif not quiet:
        for file in files:
            print(file)


def _read(
    name: str,
    path: Path,
    given: Scenario | None,
    namespace: str | None,
    *,
    allow_unfinished: bool,
) -> Flown:
    """Return a flight with its telemetry, or a plan."""
    from spacecraft_gnc.analysis.flown import flown
    from spacecraft_gnc.analysis.plan_file import is_plan
    from spacecraft_gnc.analysis.plans import read_plan
    from spacecraft_gnc.analysis.reader import load_run

    if is_plan(path):
        return read_plan(name, path)
    flight = load_run(path, namespace=namespace, allow_unfinished=allow_unfinished)
    scenario = known_scenario(flight.info, given)
    return flown(name, flight, scenario, allow_unfinished=allow_unfinished)


def _metrics(run: Flown) -> dict[str, Any]:
    from spacecraft_gnc.analysis.metrics import summarize
    from spacecraft_gnc.analysis.plans import planner_of

    if run.info.is_plan:
        return planner_of(run.scenario).numbers(run.trajectory)
    return summarize(run.trajectory, run.scenario)


def _require_alone(out: Path | None, only: list[str] | None) -> None:
    """Refuse options of the figures beside ``--animate``."""
    for name, value in {"--out": out, "--only": only}.items():
        if value:
            raise ParameterError(
                f"--animate: received with {name}; required without it, as no figure is drawn "
                f"beside the moving picture; leave {name} out, or draw the figures in a second call"
            )


def _drawn(
    makers: Mapping[str, Maker],
    names: list[str],
    folder: Path,
    formats: list[Format],
    progress: Progress,
) -> list[Path]:
    """Write the figures of these names; return their files."""
    from spacecraft_gnc.drawing.figures import save_figures

    kinds = [item.value for item in dict.fromkeys(formats)]
    files = []
    for i, name in enumerate(names):
        progress(i, len(names), f"drawing {name}")
        files += save_figures([(name, makers[name]())], folder, kinds)
    return files


def _makers(runs: list[Flown], title: str | None, error_scale: str) -> dict[str, Maker]:
    """Return what draws each figure, by name."""
    from spacecraft_gnc.analysis.plans import figures_part

    figures = figures_part(runs)
    if len(runs) > 1:
        return figures.comparison(runs, error_scale=error_scale)
    heading = runs[0].name if title is None else title
    return figures.flight(runs[0], title=heading, error_scale=error_scale)


def _chosen(makers: Mapping[str, Maker], only: list[str] | None) -> list[str]:
    """Return the names of the figures to draw.

    Raises
    ------
    ParameterError
        If there is none of a name.
    """
    for name in only or ():
        if name not in makers:
            raise ParameterError(
                f"--only: received {name!r}; required a figure that this flight has; use "
                f"{', '.join(makers)}"
            )
    return list(dict.fromkeys(only)) if only else list(makers)
