"""Diagrams of the sources of the torque and of the plant's invariants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.chart import Chart, components, one_curve_each, over_time
from spacecraft_gnc.drawing.envelope import per_interval
from spacecraft_gnc.drawing.sources import source_color, source_name, stretches
from spacecraft_gnc.drawing.traces import axis, label, log_axis
from spacecraft_gnc.vehicles.rigid_body.flown import Flown

_BAND_HEIGHT: Final = 34  # [px]


def source_chart(runs: Sequence[Flown], points: int) -> Chart:
    """Return the band that shows where each torque came from, one row for each run."""
    names = [label(run.name) for run in runs]
    bars: dict[int, dict[str, Any]] = {}
    merged = False
    for name, run in zip(names, runs, strict=True):
        width = per_interval(run.trajectory.n_steps, points)
        merged |= width > 1
        for stretch in stretches(run.trajectory.source, run.times, width):
            bar = bars.setdefault(stretch.source, _bar(stretch.source))
            bar["y"].append(name)
            bar["base"].append(stretch.begin)
            bar["x"].append(stretch.end - stretch.begin)
            bar["customdata"].append([stretch.begin, stretch.end, stretch.steps])
    y = axis(
        "",
        autorange="reversed",
        showticklabels=len(runs) > 1,
        ticks="",
        categoryorder="array",
        categoryarray=names,
    )
    drawn = over_time(runs, [bars[source] for source in sorted(bars)], y)
    drawn["layout"].update(
        {
            "barmode": "overlay",
            "showlegend": True,  # of a single source too
            "bargap": 0.25,
            "hovermode": "closest",
            "height": 110 + _BAND_HEIGHT * len(runs),
        }
    )
    note = "The method itself, or the rung of its fallback ladder that gave each applied torque."
    if merged:
        note += " Of a long run, each interval of the band shows its lowest rung."
    return Chart("sources", "Source of the torque", note, drawn, wide=True)


def _bar(source: int) -> dict[str, Any]:
    return {
        "type": "bar",
        "orientation": "h",
        "name": source_name(source),
        "y": [],
        "base": [],
        "x": [],
        "customdata": [],
        "marker": {"color": source_color(source), "line": {"width": 0}},
        "hovertemplate": "%{customdata[0]:.6g} s to %{customdata[1]:.6g} s: %{customdata[2]} steps",
    }


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
