"""``gnc launch``: the scenario as a ROS 2 graph."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    QuietOption,
    ScenarioArgument,
    SetOption,
    SpacecraftOption,
    StrictOption,
    print_error,
    print_json,
    require_within_limits,
    tell_warnings,
)
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.extras import require_ros
from spacecraft_gnc.launcher.deadlines import misses_most
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import Interrupted, NodeDied, Outcome
from spacecraft_gnc.launcher.plan import LaunchPlan, make_plan
from spacecraft_gnc.launcher.progress import choose
from spacecraft_gnc.recording.metadata import METADATA_NAME, read_counts, read_losses
from spacecraft_gnc.signals.graph import CONTROLLER
from spacecraft_gnc.signals.members import role_of

OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out", "-o", metavar="DIR", help="New folder for bag and logs [runs/SCENARIO-N]."
    ),
]
ModeOption = Annotated[
    str | None, typer.Option("--mode", metavar="lockstep|free_run", help="Replaces plant.mode.")
]
RateOption = Annotated[
    float | None,
    typer.Option("--rate", metavar="X", help="Replaces plant.real_time_factor (free_run)."),
]
DurationOption = Annotated[
    float | None, typer.Option("--duration", metavar="S", help="Replaces plant.duration [s].")
]
ComposedOption = Annotated[bool, typer.Option("--composed", help="All nodes in one process.")]
_SHARES = {"median": 0.5, "p99": 0.99, "max": 1.0}
NoRecordOption = Annotated[bool, typer.Option("--no-record", help="Fly without the recorder.")]


def launch(
    scenario: ScenarioArgument,
    out: OutOption = None,
    mode: ModeOption = None,
    rate: RateOption = None,
    duration: DurationOption = None,
    composed: ComposedOption = False,
    overrides: SetOption = None,
    namespace: SpacecraftOption = None,
    no_record: NoRecordOption = False,
    strict: StrictOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Fly a scenario as a ROS 2 graph: one process a node, recorded into a bag."""
    born = time.monotonic()
    require_ros()
    changes = [
        *(overrides or ()),
        *([f"plant.mode={mode}"] if mode is not None else []),
        *([f"plant.real_time_factor={rate}"] if rate is not None else []),
        *([f"plant.duration={duration}"] if duration is not None else []),
        *(["launcher.composed=true"] if composed else []),
    ]
    plan = make_plan(scenario, changes, namespace=namespace, out=out, record=not no_record)
    if strict:
        _require_recorded(plan)
    if not (quiet or as_json):
        tell_warnings(plan.fleet)
    launcher = Launcher(plan, choose(quiet=quiet, warnings_only=as_json), born)
    try:
        outcome = launcher.run()
    except Interrupted as error:
        print_error(error)
        if (plan.bag / METADATA_NAME).exists():
            print(f"  recorded until then in {plan.bag}", file=sys.stderr)
        _shout_losses([plan.bag])
        raise typer.Exit(error.exit_code) from error
    except NodeDied as error:
        if not error.told:
            print_error(error)
        for line in error.last_output:
            print(f"  | {line}", file=sys.stderr)
        if plan.bag.is_dir() and not (plan.bag / METADATA_NAME).exists():
            print(f"  the bag was cut off: gnc recover {plan.bag}", file=sys.stderr)
        raise typer.Exit(error.exit_code) from error
    is_complete = _shout_losses(outcome.bags)
    is_answered = _shout_silence(plan, outcome)
    metrics = _metrics(plan, outcome) if strict or as_json or not quiet else {}
    _report(plan, outcome, metrics, as_json=as_json, quiet=quiet)
    require_within_limits(plan.scenario.path, metrics.get("limits_exceeded", ()), strict)
    if outcome.strangers or not (is_complete and is_answered):
        raise typer.Exit(1)


def _require_recorded(plan: LaunchPlan) -> None:
    """Refuse to judge a flight of which nothing is recorded."""
    if not plan.records:
        plan.discard()
        raise ParameterError(
            "--strict: received a flight without a recorder; required one, whose bag tells which "
            "limits were kept; leave out --no-record, or --strict"
        )


def _report(
    plan: LaunchPlan, outcome: Outcome, metrics: dict[str, Any], *, as_json: bool, quiet: bool
) -> None:
    if not quiet:
        for topic in _never_published(plan, outcome):
            text = f"{topic}: nobody published on it: nothing of it is in the bag"
            print(f"warning: recorder.topics: {text}", file=sys.stderr)
    if quiet and not as_json:
        return
    if as_json:
        print_json(metrics)
        return
    from spacecraft_gnc.cli.simulate import print_summaries

    speed = outcome.simulated_time / outcome.wall_time if outcome.wall_time else 0.0
    print(
        f"{plan.scenario.path}: flown in {outcome.wall_time:.3g} s, {speed:.3g} times real time, "
        f"{outcome.steps / outcome.wall_time:.0f} steps/s"
    )
    rows: list[tuple[str, str]] = []
    if plan.scenario.plant.mode == "free_run":
        rows += [("state to command", _latency(metrics))] if outcome.bags else []
        rows.append(("deadlines missed", _missed(outcome)))
    rows += [("restarted", name) for name in outcome.restarts]
    rows += [("STRANGER", text) for text in outcome.strangers]
    rows += [("messages refused", text) for text in _refused(outcome)]
    rows += [("recorded in", bag) for bag in outcome.bags]
    rows.append(("logs", str(plan.logs)))
    print_summaries(metrics, plan.fleet, rows, flown=bool(outcome.bags))


def _shout_losses(bags: Sequence[str | Path]) -> bool:
    """Say on stderr, however quiet, that a bag is not complete; return whether all are."""
    lost_by_bag = {bag: read_losses(Path(bag)) for bag in bags}
    for bag, lost in lost_by_bag.items():
        if lost:
            listed = ", ".join(f"{topic} {count}" for topic, count in lost.items())
            print_error(f"{bag}: MESSAGES LOST, the bag is not complete: {listed}")
    return not any(lost_by_bag.values())


def _shout_silence(plan: LaunchPlan, outcome: Outcome) -> bool:
    """Say on stderr, however quiet, that lockstep went on without commands; return whether not."""
    plant = plan.scenario.plant
    commanded = CONTROLLER in map(role_of, plan.nodes)  # else nobody was to answer
    if plant.mode == "free_run" or not outcome.missed_deadlines or not commanded:
        return True
    print_error(
        f"plant: no command within {plant.command_timeout:g} s for {outcome.missed_deadlines} of "
        f"{outcome.steps} steps, and idle control instead; required one for each step, else the "
        f"flight is not that of gnc simulate; {plan.logs / 'plant.log'} names the steps"
    )
    return False


def _never_published(plan: LaunchPlan, outcome: Outcome) -> list[str]:
    """Topics beside those of the graph that were to be recorded, and of which nothing came."""
    if not outcome.bags:
        return []
    from spacecraft_gnc.ros.graph_of import foreign_topics

    counts = [read_counts(Path(bag)) or {} for bag in outcome.bags]
    names = [f"/{name.strip('/')}" for name in foreign_topics(plan.fleet)]
    return [name for name in names if not any(count.get(name) for count in counts)]


def _metrics(plan: LaunchPlan, outcome: Outcome) -> dict[str, Any]:
    """Return the summary of the run; from the bag, if there is one."""
    from spacecraft_gnc.cli.simulate import summarize_agents
    from spacecraft_gnc.scenario.fingerprint import fingerprint

    agents = plan.fleet.agents
    hashes = {agent: {"scenario_hash": fingerprint(one)} for agent, one in agents.items()}
    summary: dict[str, Any] = {"scenario": plan.fleet.path, **hashes.get("", {"agents": hashes})}
    if outcome.bags:
        from numpy import quantile

        from spacecraft_gnc.analysis.reader import read_flight
        from spacecraft_gnc.recording.timing import read_latencies

        first, *others = (
            summarize_agents(
                {a: read_flight(bag, namespace=a or None).trajectory for a in agents}, plan.fleet
            )
            for bag in outcome.bags
        )
        summary |= first
        for part in others:  # the recorder was restarted
            summary["limits_exceeded"] += part["limits_exceeded"]
        latencies = read_latencies(outcome.bags[0], namespace=next(iter(agents)) or None)
        for name, share in _SHARES.items():
            known = latencies.size > 0
            summary[f"latency_{name}"] = float(quantile(latencies, share)) if known else None
    return summary | {
        "mode": plan.scenario.plant.mode,
        "domain_id": outcome.domain_id,
        "wall_time": outcome.wall_time,
        "steps_per_second": outcome.steps / outcome.wall_time if outcome.wall_time else None,
        "startup_time": outcome.startup_time,
        "missed_deadlines": outcome.missed_deadlines,
        "restarts": list(outcome.restarts),
        "strangers": list(outcome.strangers),
        "messages_refused": {name: dict(n) for name, n in outcome.refused.items() if n},
        "bags": list(outcome.bags),
        "messages_lost": sum(sum(read_losses(Path(bag)).values()) for bag in outcome.bags),
        "topics_never_published": _never_published(plan, outcome),
        "warnings": list(plan.fleet.warnings),
        "logs": plan.logs,
    }


def _missed(outcome: Outcome) -> str:
    text = f"{outcome.missed_deadlines} of {outcome.steps}"
    if not misses_most(outcome.missed_deadlines, outcome.steps):
        return text
    return f"{text}: lower --rate, or fly with --mode lockstep"


def _refused(outcome: Outcome) -> list[str]:
    """Return a line for each node that refused messages: how many, and why."""
    lines = []
    for name, counts in outcome.refused.items():
        reasons = ", ".join(f"{key} {count}" for key, count in counts.items())
        if reasons:
            lines.append(f"{sum(counts.values())} by {name}: {reasons}")
    return lines


def _latency(m: dict[str, Any]) -> str:
    if m["latency_median"] is None:
        return "never in time"
    median, p99, longest = (1e3 * m[f"latency_{name}"] for name in _SHARES)
    return f"{median:.2f} ms median, {p99:.2f} ms 99 %, {longest:.2f} ms longest"
