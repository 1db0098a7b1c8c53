"""What a user sees while a graph flies: a bar, plain lines, or nothing."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, Protocol

if TYPE_CHECKING:
    from spacecraft_gnc.launcher.plan import LaunchPlan

_LINE_PERIOD: Final = 5.0  # [s] wall time between two plain lines


class Report(Protocol):
    """What the graph tells about itself (`nodes._supervisor.Progress`)."""

    step: int
    wall_elapsed: float
    latency: float
    missed_deadlines: int
    status_step: int
    attitude_error: float
    solve_time: float


class Display:
    """Shows nothing: the base of what shows something."""

    def waiting(self, plan: LaunchPlan, domain_id: int) -> None:
        """Take note that the processes were started."""

    def starting(self, stages: Mapping[str, str]) -> None:
        """Take note of how far the nodes have come."""

    def flying(self, report: Report) -> None:
        """Take note of where the flight is."""

    def note(self, text: str) -> None:
        """Take note of something worth a line."""

    def close(self) -> None:
        """Show nothing more."""


class PlainLines(Display):
    """A line now and then, for logs and pipes."""

    def __init__(self) -> None:
        self._last = 0.0
        self._n_steps = 0
        self._period = 0.0

    def waiting(self, plan: LaunchPlan, domain_id: int) -> None:
        """Say what was started and where."""
        self._n_steps, self._period = plan.scenario.n_steps, plan.scenario.period
        self._last = time.monotonic()
        print(introduction(plan, domain_id), flush=True)

    def flying(self, report: Report) -> None:
        """Print a line if the last one is old."""
        if time.monotonic() - self._last < _LINE_PERIOD or report.step < 0:
            return
        self._last = time.monotonic()
        share = report.step / self._n_steps
        print(f"  {share:6.1%}  {describe(report, self._period)}", flush=True)

    def note(self, text: str) -> None:
        """Print it."""
        print(f"  {text}", flush=True)


class Bar(Display):
    """A progress bar on a terminal."""

    def __init__(self) -> None:
        from rich.progress import BarColumn, Progress, TextColumn

        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=30),
            TextColumn("{task.percentage:>5.1f} %  {task.fields[status]}"),
            auto_refresh=False,  # no thread: the launcher draws when it has something new
            transient=True,
        )
        self._task = self._bar.add_task("starting", total=None, status="")
        self._period = 0.0

    def waiting(self, plan: LaunchPlan, domain_id: int) -> None:
        """Say what was started and where, and begin the bar."""
        self._bar.console.print(introduction(plan, domain_id), highlight=False)
        self._period = plan.scenario.period
        self._bar.update(self._task, total=plan.scenario.n_steps)
        self._bar.start()

    def starting(self, stages: Mapping[str, str]) -> None:
        """Show how far the nodes have come."""
        status = ", ".join(f"{name} {stage}" for name, stage in stages.items())
        self._bar.update(self._task, status=status, refresh=True)

    def flying(self, report: Report) -> None:
        """Show where the flight is."""
        self._bar.update(
            self._task,
            description="flying",
            completed=max(report.step, 0),
            status=describe(report, self._period),
            refresh=True,
        )

    def note(self, text: str) -> None:
        """Print it above the bar."""
        self._bar.console.print(f"  {text}", highlight=False)

    def close(self) -> None:
        """Remove the bar."""
        self._bar.stop()


def choose(*, quiet: bool) -> Display:
    """Return the display that suits the terminal, or its absence."""
    if quiet:
        return Display()
    return Bar() if sys.stdout.isatty() else PlainLines()


def introduction(plan: LaunchPlan, domain_id: int) -> str:
    """Say what flies and how to look at it."""
    how = "one process" if plan.composed else f"{len(plan.nodes)} processes"
    return (
        f"{plan.scenario.path}: {plan.scenario.n_steps} steps of {plan.scenario.period:g} s in "
        f"{how}, {plan.scenario.plant.mode}, ROS_DOMAIN_ID={domain_id}, into {plan.out}"
    )


def describe(report: Report, period: float) -> str:
    """Put a report into words."""
    simulated = max(report.step, 0) * period
    speed = simulated / report.wall_elapsed if report.wall_elapsed > 0.0 else math.nan
    # Plant and controller report in turn: quote the time that the error belongs to.
    told = report.status_step * period if report.status_step >= 0 else simulated
    parts = [f"t = {told:.1f} s", _value(speed, "x real time", ".3g")]
    parts.append(_value(math.degrees(report.attitude_error), "deg off", ".4g"))
    parts.append(_value(report.solve_time * 1e6, "us/solve", ".0f"))
    if report.missed_deadlines:
        parts.append(f"{report.missed_deadlines} deadlines missed")
    return ", ".join(part for part in parts if part)


def _value(value: float, unit: str, form: str) -> Any:
    return f"{value:{form}} {unit}" if math.isfinite(value) else ""
