"""Report of flights in formation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

from spacecraft_gnc.drawing import craft_view
from spacecraft_gnc.drawing.chart import Chart
from spacecraft_gnc.drawing.marks import mark, shade
from spacecraft_gnc.drawing.view import View
from spacecraft_gnc.vehicles.formation.charts import charts_of
from spacecraft_gnc.vehicles.formation.events import marks, spans
from spacecraft_gnc.vehicles.formation.flown import Flown
from spacecraft_gnc.vehicles.formation.rows import ROWS
from spacecraft_gnc.vehicles.formation.space import view_of
from spacecraft_gnc.vehicles.formation.telemetry import Telemetry, telemetry

if TYPE_CHECKING:
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.vehicles.formation.flight import FormationFlight
    from spacecraft_gnc.vehicles.formation.scenario import Scenario

_COUNTED: Final = {
    "missing_steps": "steps without a state or a command (gaps in the curves)",
    "inadmissible_steps": "steps without admissible shifts",
    "fallback_steps": "steps flown on a fallback command",
    "missed_deadlines": "commands that came after their deadline",
}


class FormationReport:
    """Implements `drawing.vehicle.VehicleReport`."""

    rows = ROWS

    def telemetry(
        self,
        flight: FormationFlight,
        scenario: Scenario | None,
        bag: Bag | None,
        namespace: str | None = None,
    ) -> Telemetry:
        """Return what a flight tells beside its arrays."""
        is_free = scenario is not None and scenario.plant.mode == "free_run"
        return telemetry(flight, bag, namespace, is_free=is_free)

    def warnings(self, run: Flown) -> Iterator[str]:
        """Yield what a reader should know before trusting the curves."""
        m = run.metrics
        for each in m["limits_exceeded"]:
            yield f"constraint broken: {each['text']}"
        if m["deadlocked"]:
            yield "the craft are parked in a formation that is not the desired one at the end"
        if m["spacecraft_lost"] and m["spacecraft_loss_detected_at"] is None:
            yield f"{m['spacecraft_lost']} was lost, which was not noticed"
        for alarm in m["false_alarms"]:
            yield f"{alarm['spacecraft']} was wrongly taken for lost at {alarm['at']:.5g} s"
        for key, what in _COUNTED.items():
            if m[key]:
                yield f"{what}: {m[key]}"

    def charts(self, runs: Sequence[Flown], points: int) -> Iterator[Chart]:
        """Yield the diagrams; those of one run show what happened."""
        for chart in charts_of(runs, points):
            if len(runs) == 1 and not chart.wide:
                shade(chart.figure, spans(runs[0]))
                mark(chart.figure, marks(runs[0]))
            yield chart

    def scene(self, runs: Sequence[Flown], points: int) -> View:
        """Return the craft in space."""
        return view_of(runs, points)

    def scene_script(self) -> str:
        """Return the code of the view."""
        return craft_view.script()


REPORT: Final = FormationReport()
