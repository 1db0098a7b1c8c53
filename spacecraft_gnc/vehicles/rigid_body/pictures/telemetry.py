"""Panels of the telemetry: each function draws one diagram into given axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.patches import Patch

from spacecraft_gnc.drawing import representations as forms
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import (
    TIME_LABEL,
    component,
    frame,
    legend,
    legend_below,
    limit,
    logarithmic,
    plain_numbers,
    positive,
)
from spacecraft_gnc.drawing.sources import source_color, source_name, stretches
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.telemetry import Telemetry

_BINS: Final = 40
_WIDTH: Final = 1.4  # of the line of a limit


def representation(axes: Axes, trajectory: Flight, form: forms.Representation) -> None:
    """Draw the attitude as quaternion, roll-pitch-yaw or rotation vector."""
    values = forms.values(form, series.attitudes(trajectory))
    components(axes, series.state_times(trajectory), values, form.components)
    frame(
        axes,
        series.state_times(trajectory),
        form.title,
        f"{form.name.replace('_', ' ')} [{form.unit}]",
    )


def inertial_momentum(axes: Axes, trajectory: Flight, telemetry: Telemetry) -> None:
    """Draw the components of the angular momentum in the inertial frame."""
    unit = style.prefixed("N m s", telemetry.inertial_momentum)
    values = unit.factor * telemetry.inertial_momentum
    components(axes, series.state_times(trajectory), values, "XYZ")
    frame(
        axes,
        series.state_times(trajectory),
        "Angular momentum, inertial frame",
        f"momentum [{unit.label}]",
    )


def components(axes: Axes, times: Array, values: Array, names: Sequence[str]) -> None:
    """Draw (n, m) values over time, a line for each name."""
    for i, name in enumerate(names):
        axes.plot(times, values[:, i], label=name, **component(i))
    legend(axes, len(names))


def kinetic_energy(axes: Axes, trajectory: Flight, telemetry: Telemetry) -> None:
    """Draw the rotational energy."""
    unit = style.prefixed("J", telemetry.kinetic_energy)
    times, values = series.state_times(trajectory), unit.factor * telemetry.kinetic_energy
    axes.plot(times, values, color=style.INK)
    axes.set_ylim(bottom=0.0)
    frame(axes, series.state_times(trajectory), "Kinetic energy", f"energy [{unit.label}]")


def orthogonality(axes: Axes, trajectory: Flight, telemetry: Telemetry) -> None:
    """Draw how far the recorded attitudes are from a rotation."""
    axes.plot(series.state_times(trajectory), telemetry.orthogonality_error, color=style.INK)
    logarithmic(axes, telemetry.orthogonality_error)
    frame(axes, series.state_times(trajectory), "Orthogonality of the attitude", "|RᵀR - I| [-]")


def residual(axes: Axes, trajectory: Flight, tolerance: float | None = None) -> None:
    """Draw the residual of the optimality conditions, with the solver's tolerance."""
    axes.plot(trajectory.time, trajectory.residual, color=style.INK, label="residual")
    logarithmic(axes, trajectory.residual)
    if tolerance is not None:
        label = f"tolerance {tolerance:g}"
        limit(axes, tolerance, label, _WIDTH)
        legend(axes, 2)
    frame(
        axes,
        series.state_times(trajectory),
        "Residual of the optimality conditions",
        "residual [-]",
    )


def curvature(axes: Axes, trajectory: Flight, telemetry: Telemetry) -> None:
    """Draw the smallest eigenvalue of the reduced Hessian."""
    axes.plot(trajectory.time, telemetry.min_curvature, color=style.INK)
    axes.margins(y=0.08)
    axes.set_ylim(bottom=min(0.0, float(np.nanmin(telemetry.min_curvature))))
    frame(
        axes,
        series.state_times(trajectory),
        "Least curvature of the solution",
        "curvature [cost per (N m)²]",
    )


def radius(axes: Axes, trajectory: Flight, telemetry: Telemetry) -> None:
    """Draw the spectral radius of the closed loop at its standstills."""
    color = style.AXIS_COLORS[0]
    axes.plot(trajectory.time, telemetry.closed_loop_radius, ".-", color=color, label="radius")
    limit(axes, 1.0, "stable below 1", _WIDTH)
    axes.margins(y=0.08)
    axes.set_ylim(bottom=0.0)
    legend(axes, 2)
    frame(
        axes,
        series.state_times(trajectory),
        "Closed-loop radius at a standstill",
        "spectral radius [-]",
    )


def governor_margin(axes: Axes, trajectory: Flight) -> None:
    """Draw the smallest margin of each prediction of the governor."""
    margin = np.where(np.isfinite(trajectory.governor_margin), trajectory.governor_margin, math.nan)
    axes.step(trajectory.time, margin, where="post", color=style.INK, label="margin")
    limit(axes, 0.0, "limit", _WIDTH)
    legend(axes, 2)
    frame(axes, series.state_times(trajectory), "Predicted margin", "margin [rad, N m or -]")


def solve_times(axes: Axes, runs: Mapping[str, Array], deadline: tuple[float, str]) -> None:
    """Draw the histogram of the solve times of one or several runs, with a deadline [s]."""
    known = {name: positive(values) for name, values in runs.items()}
    latest, text = deadline
    every = np.concatenate([*known.values(), np.array([latest] if latest else [])])
    unit = style.prefixed("s", every)
    low, high = math.log10(unit.factor * every.min()), math.log10(unit.factor * every.max())
    edges = np.logspace(low - 0.02, high + 0.02, _BINS + 1)
    for i, (name, values) in enumerate(known.items()):
        color = style.RUN_COLORS[i % len(style.RUN_COLORS)]
        scaled, alpha = unit.factor * values, 1.0 if len(known) == 1 else 0.55
        axes.hist(scaled, edges.tolist(), color=color, alpha=alpha, label=name)
    if latest:
        axes.axvline(unit.factor * latest, color=style.LIMIT_COLOR, linestyle="--", label=text)
    axes.set_xscale("log")
    plain_numbers(axes.xaxis)
    axes.set(title="Solve times", xlabel=f"wall time of a solve [{unit.label}]")
    axes.set_ylabel("solves [-]")
    legend(axes, 2) if len(known) == 1 else legend_below(axes)


def sources(axes: Axes, runs: Mapping[str, Flight]) -> None:
    """Draw where the torque came from as a band for each run."""
    seen = set()
    for row, trajectory in enumerate(runs.values()):
        for stretch in stretches(trajectory.source, series.state_times(trajectory)):
            seen.add(stretch.source)
            width = stretch.end - stretch.begin
            color = source_color(stretch.source)
            axes.barh(row, width, left=stretch.begin, height=0.7, color=color, linewidth=0)
    axes.set_yticks(range(len(runs)), runs if len(runs) > 1 else [""])
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set(title="Source of the torque", xlabel=TIME_LABEL)
    axes.set_xlim(0.0, max(float(series.state_times(t)[-1]) for t in runs.values()))
    handles = [Patch(color=source_color(s), label=source_name(s)) for s in sorted(seen)]
    legend(axes, 3, handles=handles)
