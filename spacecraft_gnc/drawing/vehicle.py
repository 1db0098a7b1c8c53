"""Protocols of a vehicle's own part of the report, of the figures for print, and of its plans."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from spacecraft_gnc.drawing.chart import Chart
from spacecraft_gnc.drawing.table import Row
from spacecraft_gnc.drawing.view import View
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.drawing.figures import Maker
    from spacecraft_gnc.parameters.problems import Problem
    from spacecraft_gnc.recording.bag import Bag


class FlownRun(Protocol):
    """A run as figures and report read it; a room types its flight and its scenario.

    A run of a report also has ``telemetry``, as `VehicleReport.telemetry` returns it.
    """

    @property
    def name(self) -> str:
        """How it is called."""

    @property
    def times(self) -> Array:
        """(n + 1,) of the states [s]."""

    @property
    def trajectory(self) -> Any:
        """What was flown."""

    @property
    def scenario(self) -> Any:
        """What flew; None: not known."""

    @property
    def metrics(self) -> dict[str, Any]:
        """Its summary in numbers."""


class VehicleReport(Protocol):
    """The part of the report's page that is the vehicle's own; its runs are each a `FlownRun`."""

    @property
    def rows(self) -> Sequence[Row]:
        """Rows of the summary table."""

    def telemetry(
        self, flight: Any, scenario: Any, bag: Bag | None, namespace: str | None = None
    ) -> Any:
        """Return what a flight tells beside its arrays; ``bag``: that it was read from.

        The result has ``missed_deadlines``, commands that came too late; None: no free run.
        """

    def warnings(self, run: Any) -> Iterable[str]:
        """Return what a reader should know before trusting the curves, one line each."""

    def charts(self, runs: Sequence[Any], points: int) -> Iterable[Chart]:
        """Return the diagrams; a run may spend so many points on a curve."""

    def scene(self, runs: Sequence[Any], points: int) -> View:
        """Return the 3-D view."""

    def scene_script(self) -> str:
        """Return the code of the view, with its function ``drawView(view)``."""


class VehicleFigures(Protocol):
    """Figures for print. Runs are as those of `VehicleReport`, without metrics."""

    def flight(self, run: Any, *, title: str = "", error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws each figure of one flight, by name."""

    def comparison(self, runs: Sequence[Any], *, error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws the figures of several flights over each other, by name."""

    def animate(self, runs: Sequence[Any], path: Path, *, title: str = "") -> None:
        """Write a moving picture of flights side by side."""


class VehiclePlanner(Protocol):
    """Planning of transfers. A plan has ``n_steps``, ``period`` and ``time``, as a flight has."""

    @property
    def report(self) -> VehicleReport:
        """The part of a page whose runs are plans."""

    @property
    def figures(self) -> VehicleFigures:
        """Figures of such runs."""

    def warm_up(self) -> None:
        """Load what a solve needs, so that it can be timed."""

    def solve(self, scenario: Any, *, shortest: bool = False) -> Any:
        """Return the plan of a scenario, or the one of the shortest time for which one is found."""

    def refusal(self, scenario: Any, plan: Any) -> Problem | None:
        """Return why it is none to fly; None where it is one."""

    def numbers(self, plan: Any) -> dict[str, Any]:
        """Return it in numbers, by name: the metrics of a run."""

    def summary(self, numbers: dict[str, Any]) -> list[tuple[str, str]]:
        """Return what to say of these, (label, text) by line."""

    def checks(self, plan: Any) -> tuple[tuple[str, str, str, str, str], ...]:
        """Return name, steps, largest violation, tolerance and verdict of each condition."""

    def save(self, path: Path, plan: Any, scenario: str, defaults: str) -> None:
        """Write a plan, with the texts of its scenario and of the defaults that it took."""

    def load(self, path: Path) -> tuple[Any, str, str]:
        """Read a plan, and these texts."""
