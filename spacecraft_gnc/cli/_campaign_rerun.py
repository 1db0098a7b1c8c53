"""``gnc campaign rerun``: one run of a campaign flown again, alone or in the ROS 2 graph."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from spacecraft_gnc.cli._common import (
    JsonOption,
    QuietOption,
    RunFailed,
    print_json,
    print_table,
    require_folder,
)
from spacecraft_gnc.errors import RecordingError

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.rerun import Rerun
    from spacecraft_gnc.cli._campaign_graph import GraphRun

_FLIGHT: Final = "flight.npz"
_SAME: Final = "every bit is that of the campaign"


def rerun(
    campaign: Annotated[
        Path, typer.Argument(metavar="DIR", readable=False, help="Folder of a campaign.")
    ],
    run: Annotated[int, typer.Option("--run", metavar="I", help="Number of the run.")],
    launch: Annotated[
        bool,
        typer.Option("--launch", help="Fly it through the ROS 2 graph as well, and audit its bag."),
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", metavar="DIR", help="New folder for its files [DIR/reruns/run-I-N]."
        ),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Fly one run of a campaign again and compare it with its row; 1 where a bit differs."""
    from spacecraft_gnc.campaign.rerun import fly_again
    from spacecraft_gnc.campaign.results import Campaign

    if launch:
        from spacecraft_gnc.extras import require_ros

        require_ros()
    again = fly_again(Campaign.open(campaign), run)
    if launch:
        again.require_flight()
    folder = _folder(again, campaign, out)
    graph = _launch(again, folder, quiet=quiet, as_json=as_json) if launch and folder else None
    if as_json:
        print_json(_as_dict(again, folder, graph))
    elif not quiet:
        _print(again, folder, graph)
    _require_same(again, graph, campaign)


def _folder(again: Rerun, campaign: Path, out: Path | None) -> Path | None:
    """Write scenario and flight of a run into a folder of their own; None: it has neither."""
    from spacecraft_gnc.campaign.rerun import write_scenario
    from spacecraft_gnc.cli._campaign_graph import SCENARIO_NAME, new_folder

    scenario, flight = again.flown.scenario, again.flown.flight
    if scenario is None:
        return None
    folder = new_folder(campaign / "reruns", f"run-{again.run}") if out is None else _empty(out)
    write_scenario(scenario, folder / SCENARIO_NAME)
    if flight is not None:
        flight.save(folder / _FLIGHT, scenario.to_yaml(), scenario.stated_defaults())
    return folder


def _empty(out: Path) -> Path:
    require_folder(out)
    if out.is_dir() and any(out.iterdir()):
        raise RecordingError(
            f"--out: received {str(out)!r}, which holds files; required a new or empty folder, so "
            "that nothing is overwritten; choose another one"
        )
    out.mkdir(parents=True, exist_ok=True)
    return out


def _launch(again: Rerun, folder: Path, *, quiet: bool, as_json: bool) -> GraphRun:
    from spacecraft_gnc.cli._campaign_graph import fly_in_graph
    from spacecraft_gnc.launcher.progress import choose

    return fly_in_graph(again, folder, choose(quiet=quiet, warnings_only=as_json))


def _as_dict(again: Rerun, folder: Path | None, graph: GraphRun | None) -> dict[str, Any]:
    return {
        "run": again.run,
        "differences": list(again.differences),
        "row": again.flown.row,
        "out": folder,
        "graph": None if graph is None else graph.as_dict(),
    }


def _print(again: Rerun, folder: Path | None, graph: GraphRun | None) -> None:
    row = again.flown.row
    reason = f": {row['reason']}" if row["reason"] else ""
    print(f"run {again.run}: {row['status']}{reason}")
    criterion = again.flyer.spec.variations.criterion
    rows = [(name, f"{row[name]}") for name in sorted(criterion.names) if name in row]
    rows.append(("alone", _verdict(again.differences)))
    if graph is not None:
        rows.append(("in the graph", _verdict(graph.problems, "; the audit passed")))
        rows.append(("recorded in", str(graph.bag)))
    if folder is not None:
        rows.append(("scenario, flight" if again.flown.flight else "scenario", str(folder)))
    print_table(rows)


def _verdict(problems: tuple[str, ...], further: str = "") -> str:
    return f"{len(problems)} differences" if problems else f"{_SAME}{further}"


def _require_same(again: Rerun, graph: GraphRun | None, campaign: Path) -> None:
    from spacecraft_gnc.cli._campaign_graph import told

    found = {"": again.differences, " in the graph": graph.problems if graph else ()}
    for where, problems in found.items():
        if problems:
            raise RunFailed(f"{campaign}: run {again.run} differs{where}: {told(problems)}")
