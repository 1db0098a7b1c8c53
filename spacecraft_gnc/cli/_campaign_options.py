"""Arguments and options of ``gnc campaign``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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


SpotCheckOption = Annotated[
    int,
    typer.Option(
        "--spot-check",
        metavar="K",
        min=0,
        help="In the end fly K runs through the ROS 2 graph as well, and compare bit for bit.",
    ),
]
