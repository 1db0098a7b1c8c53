"""``gnc campaign report``: one HTML page about a campaign, and its figures for print."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    QuietOption,
    print_json,
    require_folder,
    require_writable,
)
from spacecraft_gnc.cli._progress import show_progress

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.report import Data

FolderArgument = Annotated[
    Path, typer.Argument(metavar="DIR", readable=False, help="Folder of the campaign.")
]
OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out",
        "-o",
        metavar="FILE.html",
        readable=False,
        help="Where to write it.  [default: DIR/report.html]",
    ),
]
PngOption = Annotated[
    Path | None,
    typer.Option("--png", metavar="FOLDER", help="Write figures for print there, too."),
]
TitleOption = Annotated[
    str,
    typer.Option("--title", metavar="TEXT", help="Heading of the page.  [default: name of DIR]"),
]


def report(
    folder: FolderArgument,
    out: OutOption = None,
    png: PngOption = None,
    title: TitleOption = "",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Write one self-contained HTML page: success rate, metrics, parameters, failures, worst runs.

    It holds counts, not rows: its size hardly depends on the number of runs.
    """
    from spacecraft_gnc.campaign.report import read_data, report_html
    from spacecraft_gnc.campaign.results import Campaign
    from spacecraft_gnc.drawing.page import write_page

    campaign = Campaign.open(folder)
    target = folder / "report.html" if out is None else out
    require_writable(target, ".html")
    require_folder(png)
    with show_progress("reading", silent=quiet) as progress:
        data = read_data(campaign, progress)
        progress(0, 1, "writing")
        write_page(report_html(campaign, title, data), target)
        pictures = [] if png is None else _pictures(data, png)
    if as_json:
        print_json({"out": target, "bytes": target.stat().st_size, "png": pictures, **_told(data)})
    elif not quiet:
        for file in (target, *pictures):
            print(file)


def _pictures(data: Data, folder: Path) -> list[Path]:
    from spacecraft_gnc.campaign.pictures import campaign_figures
    from spacecraft_gnc.drawing.figures import save_figures

    makers = campaign_figures(data)
    return save_figures(((name, make()) for name, make in makers.items()), folder)


def _told(data: Data) -> dict[str, object]:
    from spacecraft_gnc.campaign.statistics import CONFIDENCE, clopper_pearson

    return {
        "runs": data.runs,
        "statuses": data.statuses,
        "success_rate": data.successes / data.runs,
        "confidence": CONFIDENCE,
        "interval": list(clopper_pearson(data.successes, data.runs)),
        "failures": [group._asdict() for group in data.groups],
        "worst": {each.metric: [run._asdict() for run in each.runs] for each in data.worst},
    }
