"""``gnc export``: a bag for other tools."""

from __future__ import annotations

import sys
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    NamespaceOption,
    QuietOption,
    UnfinishedOption,
    print_json,
    require_writable,
)
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import RecordingError

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.export import Export


class Format(str, Enum):
    """File formats of exports."""

    CSV = "csv"
    PARQUET = "parquet"
    NPZ = "npz"
    MAT = "mat"


BagArgument = Annotated[
    Path, typer.Argument(metavar="BAG", readable=False, help="Bag folder or .mcap file.")
]
FormatOption = Annotated[
    Format, typer.Option("--format", "-f", metavar="|".join(Format), help="File format.")
]
OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out", "-o", metavar="FILE", readable=False, help="File to write.  [default: RUN.FORMAT]"
    ),
]
TopicsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--topics",
        metavar="TOPIC",
        help="Topic to write; may be given several times.  [default: all of control steps]",
    ),
]
ForceOption = Annotated[bool, typer.Option("--force", help="Replace a file that exists.")]


def export(
    bag: BagArgument,
    kind: FormatOption,
    out: OutOption = None,
    topics: TopicsOption = None,
    force: ForceOption = False,
    namespace: NamespaceOption = None,
    unfinished: UnfinishedOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Write the topics of a bag as one file: every number in full, every column with its unit.

    CSV comes with a second file, FILE.columns.csv, that holds the units.
    """
    from spacecraft_gnc.analysis.export import read_export, write_export
    from spacecraft_gnc.analysis.plan_file import refuse_plan
    from spacecraft_gnc.analysis.run_names import run_name

    refuse_plan(bag)
    target = out if out is not None else Path(f"{run_name(bag)}.{kind.value}")
    _require_free(target, kind.value, force)
    with show_progress("reading", silent=quiet) as progress:
        found = read_export(
            bag,
            topics or (),
            namespace=namespace,
            allow_unfinished=unfinished,
            progress=progress,
        )
        progress(0, 1, "writing")
        files = write_export(found, target, kind.value, progress)
    for remark in () if quiet else found.remarks:
        print(f"note: {remark}", file=sys.stderr)
    if found.left_out and not quiet:
        names = ", ".join(found.left_out)
        print(f"note: left out, for they carry no control step: {names}", file=sys.stderr)
    _tell(found, files, as_json=as_json, quiet=quiet)


def _require_free(target: Path, kind: str, force: bool) -> None:
    from spacecraft_gnc.analysis.export.formats import units_path

    require_writable(target, f".{kind}")
    for file in (target, units_path(target)) if kind == "csv" else (target,):
        if file.is_dir() or (file.exists() and not force):
            remedy = "remove it" if file.is_dir() else "choose another or pass --force"
            raise RecordingError(
                f"--out: received {str(file)!r}, which exists; required a new file; {remedy}"
            )


def _tell(found: Export, files: list[Path], *, as_json: bool, quiet: bool) -> None:
    if as_json:
        print_json(
            {
                "source": found.path,
                "files": [str(file) for file in files],
                "steps": len(found.steps()),
                "topics": {topic.name: len(topic.steps) for topic in found.topics},
                "left_out": list(found.left_out),
                "remarks": list(found.remarks),
            }
        )
    elif not quiet:
        for file in files:
            print(file)
