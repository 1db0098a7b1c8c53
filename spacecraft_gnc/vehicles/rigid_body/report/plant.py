"""Diagrams of the sources of the torque and of the plant's invariants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.bands import band
from spacecraft_gnc.drawing.chart import Chart, components, one_curve_each, over_time
from spacecraft_gnc.drawing.envelope import per_interval
from spacecraft_gnc.drawing.sources import Stretch, source_color, source_name, stretches
from spacecraft_gnc.drawing.traces import axis, log_axis
from spacecraft_gnc.vehicles.rigid_body.flown import Flown


def source_chart(runs: Sequence[Flown], points: int) -> Chart:
    """Return the band that shows where each torque came from, one row for each run."""
    widths = {run.name: per_interval(run.trajectory.n_steps, points) for run in runs}

    def of(run: Flown) -> list[Stretch]:
        return stretches(run.trajectory.source, run.times, widths[run.name])

    note = "The method itself, or the rung of its fallback ladder that gave each applied torque."
    if max(widths.values()) > 1:
        note += " Of a long run, each interval of the band shows its lowest rung."
    drawn = band(runs, of, source_name, source_color)
    return Chart("sources", "Source of the torque", note, drawn, wide=True)


def invariant_charts(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    """Yield the diagrams of energy, inertial momentum and orthogonality."""
    computed = [run.name for run in runs if not run.telemetry.invariants_recorded]
    origin = "As the plant published them."
    if computed:
        origin = f"Computed from the states: {', '.join(computed)}."
    unit = style.prefixed("J", *(run.telemetry.kinetic_energy for run in runs))
    energy = list(
        one_curve_each(
            runs, points, lambda run: unit.factor * run.telemetry.kinetic_energy, "kinetic energy"
        )
    )
    if energy:
        note = f"Rotational; only torque changes it. {origin}"
        drawn = over_time(runs, energy, axis(f"energy [{unit.label}]", rangemode="tozero"))
        yield Chart("energy", "Kinetic energy", note, drawn)
    unit = style.prefixed("N m s", *(run.telemetry.inertial_momentum for run in runs))
    drawn = components(
        runs, points, lambda run: run.telemetry.inertial_momentum, "XYZ", "momentum", unit
    )
    note = f"Components in the inertial frame; only torque changes it. {origin}"
    yield Chart("inertial_momentum", "Inertial angular momentum", note, drawn, tall=len(runs) > 1)
    defect = list(
        one_curve_each(
            runs, points, lambda run: run.telemetry.orthogonality_error, "defect of the rotation"
        )
    )
    note = f"Frobenius norm of RᵀR - I; 1e-15 is the rounding of doubles. {origin}"
    drawn = over_time(runs, defect, log_axis("orthogonality error [-]"))
    yield Chart("orthogonality", "Orthogonality of the attitude", note, drawn, scale="yaxis")
