"""``gnc replay``: a recorded flight into a live graph, or against another controller."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from spacecraft_gnc.cli._common import JsonOption, QuietOption, SetOption
from spacecraft_gnc.cli._resolve import Wish, solve_again

SourceArgument = Annotated[
    Path,
    typer.Argument(metavar="BAG|FILE.npz", help="Bag folder, .mcap file, or .npz of gnc simulate."),
]
MethodOption = Annotated[
    str | None,
    typer.Option("--method", metavar="NAME", help="Controller to solve every step with."),
]
ScenarioOption = Annotated[
    Path | None,
    typer.Option("--scenario", metavar="SCENARIO.yaml", help="What flew, where the source does not hold it."),
]
StepsOption = Annotated[
    str | None, typer.Option("--steps", metavar="A:B", help="Only the steps A to B - 1.")
]
ColdOption = Annotated[bool, typer.Option("--cold", help="Forget the past before every step.")]
OutOption = Annotated[
    Path | None, typer.Option("--out", "-o", metavar="FOLDER", help="Draw the comparison there.")
]
UnfinishedOption = Annotated[
    bool, typer.Option("--unfinished", help="Read what was saved of a bag that was cut off.")
]


def replay(
    source: SourceArgument,
    method: MethodOption = None,
    overrides: SetOption = None,
    scenario: ScenarioOption = None,
    steps: StepsOption = None,
    cold: ColdOption = False,
    out: OutOption = None,
    unfinished: UnfinishedOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Solve every recorded step again with another controller, or play a bag into a graph."""
    wish = Wish(
        source, method, overrides or [], scenario, steps, cold, unfinished, out, as_json, quiet
    )
    solve_again(wish)
