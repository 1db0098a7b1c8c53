"""Runs of a campaign flown through the ROS 2 graph and compared with their rows bit for bit."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from spacecraft_gnc.cli._common import print_error
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import LaunchError, ParameterError, RecordingError
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import Interrupted
from spacecraft_gnc.launcher.plan import make_plan, next_free
from spacecraft_gnc.launcher.progress import Display, Silence
from spacecraft_gnc.recording.metadata import read_losses

if TYPE_CHECKING:
    from spacecraft_gnc.campaign.rerun import Rerun
    from spacecraft_gnc.campaign.results import Campaign
    from spacecraft_gnc.scenario import Scenario

SCENARIO_NAME: Final = "scenario.yaml"
_GRAPH: Final = "graph"
_SPOT_CHECKS: Final = "spot_checks"


@dataclass(frozen=True, slots=True)
class GraphRun:
    """A run that was flown in the graph.

    Attributes
    ----------
    run
        Its number.
    bag
        Folder of its bag; None: there is no whole one.
    problems
        In what it differs from the campaign, and what its audit found, one line each; none: every
        bit is the same.
    """

    run: int
    bag: Path | None
    problems: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return it ready for JSON."""
        return {"run": self.run, "bag": self.bag, "problems": list(self.problems)}


def require_lockstep(scenario: Scenario) -> None:
    """Refuse a scenario whose flight in the graph depends on the speed of the machine.

    Raises
    ------
    ParameterError
        If it flies freely.
    """
    if scenario.plant.mode != "lockstep":
        raise ParameterError(
            f"plant.mode: received {scenario.plant.mode!r}; required lockstep, in which the graph "
            "flies the bits of the campaign; plan the campaign with --set plant.mode=lockstep"
        )


def fly_in_graph(again: Rerun, folder: Path, display: Display | None = None) -> GraphRun:
    """Fly a run as a graph of real processes, compare the bag with its row, and audit it.

    Parameters
    ----------
    again
        The run, flown again alone.
    folder
        Holds its ``scenario.yaml``; bag and logs go into ``graph/``.
    display
        Shows the progress; by default nothing does.

    Raises
    ------
    ParameterError
        If the scenario is not flown in lockstep.
    LaunchError
        If the launch was refused, or ended by a signal.
    """
    plan = make_plan(folder / SCENARIO_NAME, out=folder / _GRAPH)
    require_lockstep(plan.scenario)
    try:
        outcome = Launcher(plan, display or Silence(), time.monotonic()).run()
    except Interrupted:
        raise
    except LaunchError as error:
        return GraphRun(again.run, None, (str(error),))
    if outcome.restarts or len(outcome.bags) != 1:
        ends = f"{len(outcome.bags)} bags, restarted nodes: {', '.join(outcome.restarts) or 'none'}"
        return GraphRun(again.run, None, (ends,))
    bag = Path(outcome.bags[0])
    return GraphRun(again.run, bag, _problems(again, bag))


def _problems(again: Rerun, bag: Path) -> tuple[str, ...]:
    from spacecraft_gnc.analysis.audit import audit_bag
    from spacecraft_gnc.analysis.reader import read_flight

    lost = sum(read_losses(bag).values())
    if lost:
        return (f"{lost} messages lost",)
    try:
        found = again.compare(read_flight(bag).trajectory)
        first = audit_bag(bag).first
    except RecordingError as error:
        return (str(error),)
    if first is None:
        return found
    check, difference = first
    return (*found, f"audit, {check.name}: {difference.field}, step {difference.step}")


def spot_check(campaign: Campaign, count: int, *, silent: bool = False) -> tuple[GraphRun, ...]:
    """Fly runs drawn by the seed of a campaign through the graph, each compared bit for bit.

    Parameters
    ----------
    campaign
        A complete campaign; scenarios and bags go into its folder ``spot_checks``.
    count
        How many runs.
    silent
        Show no progress.

    Raises
    ------
    ParameterError
        If the scenario is not flown in lockstep.
    LaunchError
        If a launch was refused, or ended by a signal.
    """
    from spacecraft_gnc.campaign.rerun import fly_again, spot_runs, write_scenario

    require_lockstep(campaign.spec.scenario)
    checked: list[GraphRun] = []
    runs = spot_runs(campaign, count)
    with show_progress("flying through the graph", silent=silent) as progress:
        for run in runs:
            again = fly_again(campaign, run)
            folder = new_folder(campaign.folder / _SPOT_CHECKS, f"run-{run}")
            _, scenario = again.require_flight()
            write_scenario(scenario, folder / SCENARIO_NAME)
            checked.append(fly_in_graph(again, folder))
            progress(len(checked), len(runs))
    return tuple(checked)


def report_spot_checks(checked: Iterable[GraphRun]) -> bool:
    """Print on stderr each run that differs in the graph; return whether none does."""
    bad = [each for each in checked if each.problems]
    for each in bad:
        print_error(f"run {each.run} differs in the graph: {told(each.problems)}")
    return not bad


def told(problems: tuple[str, ...]) -> str:
    """Return the first of some problems and the number of the others, in one line."""
    return problems[0] if len(problems) == 1 else f"{problems[0]}; {len(problems) - 1} more"


def new_folder(parent: Path, stem: str) -> Path:
    """Create and return ``parent/stem-1``, or the next that is free.

    Raises
    ------
    RecordingError
        If it cannot be created.
    """
    try:
        return next_free(parent, stem)
    except OSError as error:
        raise RecordingError(
            f"{error.filename}: cannot be created ({error.strerror}); required a folder that can "
            "be written; choose another --out"
        ) from error
