"""``gnc plot``: figures of a recorded or simulated flight."""

from __future__ import annotations

import sys
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spacecraft_gnc.cli._common import JsonOption, QuietOption, print_json
from spacecraft_gnc.recording import BAG_FOLDER, RUN_SCENARIO

if TYPE_CHECKING:
    from spacecraft_gnc.recording.reader import Flight
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


SourceArgument = Annotated[
    Path,
    typer.Argument(
        metavar="BAG|FILE.npz",
        help="Bag, .mcap file, folder of gnc launch, or .npz of gnc simulate.",
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
    typer.Option("--format", "-f", help="File format; may be given several times."),
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
    ErrorScale, typer.Option("--error-scale", help="Scale of the attitude error.")
]
TitleOption = Annotated[
    str | None,
    typer.Option("--title", help="Heading of the overview.  [default: name of the source]"),
]
UnfinishedOption = Annotated[
    bool, typer.Option("--unfinished", help="Read what was saved of a bag that was cut off.")
]


def plot(
    source: SourceArgument,
    out: OutOption = None,
    formats: FormatOption = [Format.PNG, Format.SVG],  # noqa: B006  # typer copies it
    scenario: ScenarioOption = None,
    error_scale: ScaleOption = ErrorScale.LOG,
    title: TitleOption = None,
    unfinished: UnfinishedOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Draw the figures of a flight: error, momentum, torque, attitude on the sphere, solver."""
    from spacecraft_gnc.analysis.figures import flight_figures, save_figures
    from spacecraft_gnc.analysis.metrics import summarize
    from spacecraft_gnc.recording.reader import load_run

    flight = load_run(source, allow_unfinished=unfinished)
    known = _scenario(flight, scenario)
    name = _name_of(source)
    heading = name if title is None else title
    figures = flight_figures(flight.trajectory, known, title=heading, error_scale=error_scale.value)
    folder = out if out is not None else Path(f"{name}-figures")
    files = save_figures(figures, folder, [item.value for item in dict.fromkeys(formats)])
    for warning in flight.info.warnings():
        print(f"warning: {warning}", file=sys.stderr)
    if as_json:
        metrics = summarize(flight.trajectory, known)
        print_json({"source": source, "files": [str(file) for file in files], "metrics": metrics})
    elif not quiet:
        for file in files:
            print(file)


def _name_of(source: Path) -> str:
    """Return the name of a file or folder; of a bag in the folder of a run, that of the run."""
    if source.is_file():
        return source.stem
    folder = source.resolve()
    is_run = folder.name == BAG_FOLDER and (folder.parent / RUN_SCENARIO).is_file()
    return folder.parent.name if is_run else folder.name


def _scenario(flight: Flight, path: Path | None) -> Scenario | None:
    """Return the scenario named on the command line, or else the one in the bag."""
    if path is None:
        return flight.info.scenario
    from spacecraft_gnc.scenario import load

    return load(path)
