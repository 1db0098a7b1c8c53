"""Progress display of a flight: a bar, plain lines, or nothing."""

from __future__ import annotations

import math
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final, Protocol

from spacecraft_gnc.launcher.deadlines import misses_most

if TYPE_CHECKING:
    from spacecraft_gnc.launcher.plan import LaunchPlan

_LINE_PERIOD: Final = 5.0  # [s] wall between two plain lines
_WIDE: Final = 110  # least columns of a terminal for the wide bar
_WIDE_BAR, _NARROW_BAR = 30, 10  # columns
_AROUND: Final = len("starting   100.0 %  ")  # columns of the text beside bar and status


class Report(Protocol):
    """Progress as reported by the graph (`nodes._supervisor.Progress`)."""

    step: int
    wall_elapsed: float
    latency: float
    missed_deadlines: int
    status_step: int
    distance: float
    attitude_error: float
    solve_time: float


class Display:
    """Shows warnings only, on stderr; base of the other displays."""

    def waiting(self, plan: LaunchPlan, domain_id: int) -> None:
        """Report that the processes were started."""

    def starting(self, stages: Mapping[str, str]) -> None:
        """Report the state of the nodes during start-up."""

    def flying(self, report: Report) -> None:
        """Report the progress of the flight."""

    def note(self, text: str) -> None:
        """Report an event in one line."""

    def warn(self, text: str) -> None:
        """Print a warning."""
        self.tell(f"warning: {text}")

    def tell(self, text: str) -> None:
        """Print a line, however quiet the display is."""
        print(text, file=sys.stderr, flush=True)

    def close(self) -> None:
        """Close the display."""


class Silence(Display):
    """Shows nothing."""

    def warn(self, text: str) -> None:
        """Show no warning."""


class PlainLines(Display):
    """Occasional lines, for logs and pipes."""

    def __init__(self) -> None:
        self._last = 0.0
        self._n_steps = 0
        self._period = 0.0

    def waiting(self, plan: LaunchPlan, domain_id: int) -> None:
        """Print what was started and where."""
        self._n_steps, self._period = plan.scenario.n_steps, plan.scenario.period
        self._last = time.monotonic()
        print(introduction(plan, domain_id), file=sys.stderr, flush=True)

    def flying(self, report: Report) -> None:
        """Print a line if enough time has passed since the last one."""
        if time.monotonic() - self._last < _LINE_PERIOD or report.step < 0:
            return
        self._last = time.monotonic()
        share = report.step / self._n_steps
        text = ", ".join(describe(report, self._period))
        print(f"  {share:6.1%}  {text}", file=sys.stderr, flush=True)

    def note(self, text: str) -> None:
        """Print it."""
        print(f"  {text}", file=sys.stderr, flush=True)


class Bar(Display):
    """A progress bar on a terminal."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn
        from rich.table import Column

        console = Console(stderr=True)
        bar = _WIDE_BAR if console.width >= _WIDE else _NARROW_BAR
        self._room = console.width - bar - _AROUND
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=bar),
            TextColumn(
                "{task.percentage:>5.1f} %  {task.fields[status]}",
                table_column=Column(no_wrap=True),
            ),
            console=console,
            auto_refresh=False,  # no thread: the launcher draws on updates
            transient=True,
        )
        self._task = self._bar.add_task("starting", total=None, status="")
        self._period = 0.0

    def waiting(self, plan: LaunchPlan, domain_id: int) -> None:
        """Print what was started and where, and start the bar."""
        self._bar.console.print(introduction(plan, domain_id), highlight=False)
        self._period = plan.scenario.period
        self._bar.update(self._task, total=plan.scenario.n_steps)
        self._bar.start()

    def starting(self, stages: Mapping[str, str]) -> None:
        """Show the state of the nodes during start-up."""
        status = ", ".join(f"{name} {stage}" for name, stage in stages.items())
        if len(status) > self._room:
            counts = Counter(stages.values())
            status = ", ".join(f"{count} {stage}" for stage, count in counts.items())
        self._bar.update(self._task, status=status, refresh=True)

    def flying(self, report: Report) -> None:
        """Show the progress of the flight."""
        self._bar.update(
            self._task,
            description="flying",
            completed=max(report.step, 0),
            status=fitting(describe(report, self._period), self._room),
            refresh=True,
        )

    def note(self, text: str) -> None:
        """Print it above the bar."""
        self._bar.console.print(f"  {text}", highlight=False)

    def tell(self, text: str) -> None:
        """Print it above the bar."""
        self._bar.console.print(text, highlight=False, markup=False, soft_wrap=True)

    def close(self) -> None:
        """Remove the bar."""
        self._bar.stop()


def choose(*, quiet: bool, warnings_only: bool = False) -> Display:
    """Return the display that suits the terminal or pipe."""
    if quiet:
        return Silence()
    if warnings_only:
        return Display()
    return Bar() if sys.stderr.isatty() else PlainLines()


def introduction(plan: LaunchPlan, domain_id: int) -> str:
    """Return a line that names the scenario, its processes, domain and folder."""
    how = "one process" if plan.composed else f"{len(plan.nodes)} processes"
    return (
        f"{plan.scenario.path}: {plan.scenario.n_steps} steps of {plan.scenario.period:g} s in "
        f"{how}, {plan.scenario.plant.mode}, ROS_DOMAIN_ID={domain_id}, into {plan.out}"
    )


def describe(report: Report, period: float) -> list[str]:
    """Return the parts of a report as text, the most important first."""
    simulated = max(report.step, 0) * period
    speed = simulated / report.wall_elapsed if report.wall_elapsed > 0.0 else math.nan
    # Plant and controller report separately: show the time of the distance.
    told = report.status_step * period if report.status_step >= 0 else simulated
    parts = [_off(report)]
    if report.missed_deadlines:
        most = misses_most(report.missed_deadlines, report.step)
        share = f" of {report.step}" if most else ""
        parts.append(f"{report.missed_deadlines}{share} deadlines missed")
    parts += [f"t = {told:.1f} s", _value(speed, "x real time", ".3g")]
    parts.append(_value(report.solve_time * 1e6, "us/solve", ".0f"))
    return [part for part in parts if part]


def _off(report: Report) -> str:
    """Return how far it is from where it is to go, and from the attitude that it is to have."""
    place = _value(report.distance, "m", ".4g")
    turned = _value(math.degrees(report.attitude_error), "deg", ".4g")
    known = " and ".join(part for part in (place, turned) if part)
    return f"{known} off" if known else ""


def fitting(parts: Sequence[str], room: int) -> str:
    """Return as many of the first parts as fit into ``room`` characters."""
    text = ""
    for part in parts:
        longer = f"{text}, {part}" if text else part
        if len(longer) > room:
            break
        text = longer
    return text


def _value(value: float, unit: str, form: str) -> str:
    return f"{value:{form}} {unit}" if math.isfinite(value) else ""
