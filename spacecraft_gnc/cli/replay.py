"""``gnc replay``: a recorded flight into a live graph, or against another controller."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    NamespaceOption,
    QuietOption,
    SetOption,
    UnfinishedOption,
)
from spacecraft_gnc.cli._play import Playing, play
from spacecraft_gnc.cli._resolve import Solving, solve_again
from spacecraft_gnc.errors import ParameterError

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
    typer.Option(
        "--scenario", metavar="SCENARIO.yaml", help="What flew, where the source does not hold it."
    ),
]
StepsOption = Annotated[
    str | None, typer.Option("--steps", metavar="A:B", help="Only the steps A to B - 1.")
]
ColdOption = Annotated[bool, typer.Option("--cold", help="Forget the past before every step.")]
OutOption = Annotated[
    Path | None, typer.Option("--out", "-o", metavar="FOLDER", help="Draw the comparison there.")
]


PublishOption = Annotated[
    bool, typer.Option("--publish", help="Play the bag into a live graph, with /clock.")
]
RateOption = Annotated[
    str | None,
    typer.Option(
        "--rate", metavar="X", help="Times real time; 0 or max: as fast as it goes.  [default: 1]"
    ),
]
StartOption = Annotated[
    float | None, typer.Option("--start", metavar="S", help="Begin there [s after the start].")
]
PausedOption = Annotated[bool, typer.Option("--paused", help="Begin paused.")]
LoopOption = Annotated[
    bool, typer.Option("--loop", help="Begin again, at --start, after the last message.")
]
TopicsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--topics", metavar="TOPIC", help="Play this one only; may be given several times."
    ),
]
WaitOption = Annotated[
    list[str] | None,
    typer.Option(
        "--wait-for",
        metavar="TOPIC",
        help="Begin once this one has a subscriber; may be given several times.  [default: each]",
    ),
]
PatienceOption = Annotated[
    float | None,
    typer.Option(
        "--patience", metavar="S", help="Begin without a subscriber after S [s].  [default: 2]"
    ),
]

PlayDomainOption = Annotated[
    int | None,
    typer.Option(
        "--domain-id",
        metavar="N",
        min=0,
        max=232,
        help="ROS_DOMAIN_ID to play on [the variable, else a free one].",
    ),
]


def replay(
    source: SourceArgument,
    method: MethodOption = None,
    overrides: SetOption = None,
    scenario: ScenarioOption = None,
    steps: StepsOption = None,
    cold: ColdOption = False,
    out: OutOption = None,
    publish: PublishOption = False,
    rate: RateOption = None,
    start: StartOption = None,
    paused: PausedOption = False,
    loop: LoopOption = False,
    topics: TopicsOption = None,
    wait_for: WaitOption = None,
    patience: PatienceOption = None,
    domain_id: PlayDomainOption = None,
    namespace: NamespaceOption = None,
    unfinished: UnfinishedOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Solve every recorded step again with another controller, or play a bag into a graph.

    Without --publish each step is solved from its recorded state and reference: what would that
    controller have commanded here? With the controller that flew, a lockstep flight is repeated bit
    for bit; anything else is exit code 1.
    """
    of_player = {
        "--rate": rate,
        "--start": start,
        "--paused": paused,
        "--loop": loop,
        "--topics": topics,
        "--wait-for": wait_for,
        "--patience": patience,
        "--domain-id": domain_id,
    }
    of_solver = {
        "--method": method,
        "--set": overrides,
        "--scenario": scenario,
        "--steps": steps,
        "--cold": cold,
        "--out": out,
        "--namespace": namespace,
    }
    from spacecraft_gnc.analysis.plan_file import refuse_plan

    _refuse(of_solver if publish else of_player, publish)
    refuse_plan(source)
    if publish:
        play(
            Playing(
                source=source,
                rate="1" if rate is None else rate,
                start=start or 0.0,
                paused=paused,
                loop=loop,
                topics=topics or [],
                expected=wait_for or [],
                patience=2.0 if patience is None else patience,
                domain_id=domain_id,
                unfinished=unfinished,
                as_json=as_json,
                quiet=quiet,
            )
        )
        return
    solve_again(
        Solving(
            source=source,
            method=method,
            overrides=overrides or [],
            scenario=scenario,
            steps=steps,
            cold=cold,
            namespace=namespace,
            unfinished=unfinished,
            out=out,
            as_json=as_json,
            quiet=quiet,
        )
    )


def _refuse(options: dict[str, Any], publish: bool) -> None:
    for name, value in options.items():
        if value not in (None, False, [], ()):
            remedy = f"leave {name} or --publish out" if publish else "add --publish"
            where = "without --publish, for" if publish else "with --publish, for it is"
            who = "an answer is solved off line" if publish else "the player's"
            raise ParameterError(f"{name}: received {value}; required {where} {who}; {remedy}")
