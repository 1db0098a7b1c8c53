"""Report of flights of a rigid body."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from spacecraft_gnc.drawing import attitude_view
from spacecraft_gnc.drawing.chart import Chart, held
from spacecraft_gnc.drawing.sources import source_name
from spacecraft_gnc.drawing.view import View
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.flown import Flown
from spacecraft_gnc.vehicles.rigid_body.report.motion import motion_charts
from spacecraft_gnc.vehicles.rigid_body.report.plan import mark_plans, plan_charts
from spacecraft_gnc.vehicles.rigid_body.report.plant import invariant_charts, source_chart
from spacecraft_gnc.vehicles.rigid_body.report.rows import ROWS
from spacecraft_gnc.vehicles.rigid_body.report.solver import solver_charts
from spacecraft_gnc.vehicles.rigid_body.scenario import reservation
from spacecraft_gnc.vehicles.rigid_body.telemetry import Telemetry, computed, read_telemetry

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.recording.bag import Bag
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

_COUNTED: Final = {
    "missing_steps": "steps without a state or a torque (gaps in the curves)",
    "unconverged_steps": "solves that did not converge",
    "fallback_steps": "steps flown on a fallback torque",
    "plan_not_found_steps": "steps flown on an old plan, as no new one was found",
    "inadmissible_steps": "steps without an admissible reference",
    "missed_deadlines": "torques that came after their deadline",
}


class RigidBodyReport:
    """Implements `drawing.vehicle.VehicleReport`."""

    rows = ROWS

    def telemetry(
        self,
        flight: Flight,
        scenario: Scenario | None,
        bag: Bag | None,
        namespace: str | None = None,
    ) -> Telemetry:
        """Return what a flight tells beside its arrays."""
        if bag is None:
            return computed(flight, scenario)
        return read_telemetry(bag, namespace, flight, scenario)

    def warnings(self, run: Flown) -> Iterator[str]:
        """Yield what a reader should know before trusting the curves."""
        for key, what in _COUNTED.items():
            if run.metrics[key]:
                yield f"{what}: {run.metrics[key]}"
        if run.scenario is not None and reservation(run.scenario):
            yield f"{reservation(run.scenario)}, which is not that of the plant"
        late = int(np.count_nonzero(run.telemetry.deadline_slack < 0.0))
        if late:
            yield f"solves that ended after their deadline: {late}"
        for name, margin in run.metrics["zone_margin_deg"].items():
            if margin is not None and margin < 0.0:
                yield f"pointing zone {name} was violated by {-margin:.3g} deg"

    def charts(self, runs: Sequence[Flown], points: int) -> Iterator[Chart]:
        """Yield the diagrams."""
        for chart in self._charts(runs, points):
            mark_plans(chart, runs)
            yield chart

    def _charts(self, runs: Sequence[Flown], points: int) -> Iterator[Chart]:
        yield from motion_charts(runs, points)
        yield from plan_charts(runs, points)
        yield source_chart(runs, points)
        yield from solver_charts(runs, points)
        yield from invariant_charts(runs, points)

    def scene(self, runs: Sequence[Flown], points: int) -> View:
        """Return the attitudes on the unit sphere."""
        return attitude_view.scene([_motion(run) for run in runs], points)

    def scene_script(self) -> str:
        """Return the code of the view."""
        return attitude_view.script()


REPORT: Final = RigidBodyReport()


def _motion(run: Flown) -> attitude_view.Motion:
    flight, torque = run.trajectory, "torque, body [N m]"
    sources = [source_name(int(source)) for source in flight.source]
    return attitude_view.Motion(
        name=run.name,
        times=run.times,
        attitudes=series.attitudes(flight),
        references=series.references(flight),
        error_deg=series.settling_error_deg(flight),
        vectors={"momentum, body [N m s]": series.momenta(flight), torque: held(flight.torque)},
        notes={torque: [*sources, sources[-1]]},
        zones=run.scenario.controller.zones if run.scenario is not None else (),
    )
