"""Panels of the motion: each function draws one diagram into given axes."""

from __future__ import annotations

import math
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import representations as forms
from spacecraft_gnc.drawing import sphere, style
from spacecraft_gnc.drawing.axes import component, frame, legend, plain_numbers, positive
from spacecraft_gnc.drawing.axes import limit as draw_limit
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.metrics.summary import SETTLE_THRESHOLDS_DEG, settle_time

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.parameters.zones import ZoneParameters

_COMPONENTS = "xyz"
_LEAST_ERROR = 1e-4  # at which the logarithmic scale ends [deg]: a plan ends at rounding errors
_WIDE_SPREAD = 20.0  # largest over median solve time from which a linear scale hides the median


def attitude_error(axes: Axes, trajectory: Flight, *, scale: str = "log") -> None:
    """Draw the angle from reference to attitude, and when it settles below each threshold.

    Where a governor shapes the reference, what settles is the angle to the target; that to the
    reference is drawn beside it.

    Parameters
    ----------
    scale
        ``log`` or ``linear``.
    """
    times = series.state_times(trajectory)
    error = series.settling_error_deg(trajectory)
    governed = series.targets(trajectory) is not None
    axes.plot(times, error, color=style.INK, linewidth=1.5, label="to the target")
    if governed:
        beside = series.attitude_error_deg(trajectory)
        label = "to the governor's reference"
        axes.plot(times, beside, color=style.AXIS_COLORS[0], linewidth=1.0, label=label)
    frame(axes, times, "Attitude error", "angle [deg]")
    known = positive(error)
    if scale == "log" and known.size:
        axes.set_yscale("log")
        axes.set_ylim(max(_LEAST_ERROR, 0.5 * known.min()), 2.5 * known.max())
        plain_numbers(axes.yaxis)
    else:
        axes.set_ylim(bottom=0.0)
    settled = {
        threshold: time
        for threshold in SETTLE_THRESHOLDS_DEG
        if (time := settle_time(times, error, threshold)) is not None and time > times[0]
    }
    for threshold, time in settled.items():
        axes.hlines(threshold, time, times[-1], color=style.MUTED, linewidth=0.8)
        axes.plot([time], [threshold], marker="v", markersize=5, color=style.INK)
        if axes.get_yscale() == "log":
            _label_settling(axes, time, threshold)
    if governed:
        legend(axes, 2)
    if axes.get_yscale() != "log":  # the labels of small thresholds would lie on each other
        lines = [_settling_text(threshold, time) for threshold, time in settled.items()]
        axes.text(0.98, 0.95, "\n".join(lines), transform=axes.transAxes, ha="right", va="top")


def _settling_text(threshold: float, time: float) -> str:
    return f"below {threshold:g}° from {time:.1f} s"


def _label_settling(axes: Axes, time: float, threshold: float) -> None:
    """Write beside its mark that the error stays below ``threshold`` [deg] from ``time`` [s]."""
    late = time > 0.72 * axes.get_xlim()[1]
    axes.annotate(
        _settling_text(threshold, time),
        (time, threshold),
        xytext=(-5 if late else 5, 4),
        textcoords="offset points",
        ha="right" if late else "left",
        fontsize=8,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8},
    )


def tracking(axes: Axes, trajectory: Flight) -> None:
    """Draw the attitude as quaternion, and the moving reference as broad bands beneath it."""
    times = series.state_times(trajectory)
    wanted = forms.quaternions_xyzw(series.references(trajectory))
    flown = forms.quaternions_xyzw(series.attitudes(trajectory))
    same = np.nansum(wanted * flown, axis=1)[-1]  # q and -q are one rotation
    flown = flown if same >= 0.0 else -flown
    for i, name in enumerate(forms.QUATERNION.components):
        look = component(i)
        axes.plot(times, wanted[:, i], color=look["color"], linewidth=5.0, alpha=0.3)
        axes.plot(times, flown[:, i], label=name, **look)
    frame(axes, times, "Attitude, and reference as bands", "quaternion [-]")
    legend(axes, 4)


def momentum(axes: Axes, trajectory: Flight) -> None:
    """Draw the components of the angular momentum."""
    times, values = series.state_times(trajectory), series.momenta(trajectory)
    unit = style.prefixed("N m s", values)
    for i, name in enumerate(_COMPONENTS):
        axes.plot(times, unit.factor * values[:, i], label=rf"$\Pi_{name}$", **component(i))
    frame(axes, times, "Angular momentum, body frame", f"momentum [{unit.label}]")
    legend(axes, 3)


def torque_components(axes: Axes, trajectory: Flight) -> None:
    """Draw the components of the torque, each value held for one control period."""
    _held_components(axes, trajectory, trajectory.torque, "u", "Torque, body frame")


def external_torque(axes: Axes, trajectory: Flight) -> None:
    """Draw the components of the sum of the disturbances, likewise."""
    values = trajectory.external_torque
    _held_components(axes, trajectory, values, "d", "External torque, body frame")


def _held_components(
    axes: Axes, trajectory: Flight, torque: Array, letter: str, title: str
) -> None:
    times, values = _held(trajectory, torque)
    unit = style.prefixed("N m", values)
    for i, name in enumerate(_COMPONENTS):
        label = f"${letter}_{name}$"
        axes.step(times, unit.factor * values[:, i], where="post", label=label, **component(i))
    frame(axes, times, title, f"torque [{unit.label}]")
    legend(axes, 3)


def torque_norm(axes: Axes, trajectory: Flight, limit: float | None = None) -> None:
    """Draw the norm of the torque with its limit [N m]."""
    times, values = _held(trajectory, series.torque_norm(trajectory))
    unit = style.prefixed("N m", values, np.array([limit or 0.0]))
    axes.step(times, unit.factor * values, where="post", color=style.INK, label="$|u|$")
    frame(axes, times, "Torque norm", f"torque [{unit.label}]")
    if limit:
        text = f"limit {unit.factor * limit:g} {unit.label}"
        draw_limit(axes, unit.factor * limit, text)
    axes.set_ylim(bottom=0.0)
    axes.margins(y=0.08)
    legend(axes, 2)


def alpha(axes: Axes, trajectory: Flight) -> None:
    """Draw the share of the way that the governor allowed, and the way that is left."""
    times, color = series.state_times(trajectory), style.AXIS_COLORS[0]
    # Dots: alpha may be 0 at every other step, which a line would fill in.
    axes.plot(times[:-1], trajectory.alpha, ".", markersize=3, color=color, label=r"$\alpha$")
    frame(axes, times, "Reference governor", "share of the way [-]")
    axes.set_ylim(-0.03, 1.03)
    targets = series.targets(trajectory)
    if targets is None:
        return
    left = np.degrees(lie.angles_between(targets[:-1], trajectory.reference))
    whole = float(np.nanmax(left, initial=0.0))
    if whole > 0.0:
        label = f"way left, of {whole:.3g}°"
        axes.step(
            *_held(trajectory, left / whole), where="post", color=style.INK, linewidth=1.0,
            linestyle=style.AXIS_STYLES[1], label=label,
        )  # fmt: skip
        legend(axes, 2)


def zone_margins(axes: Axes, trajectory: Flight, zones: tuple[ZoneParameters, ...]) -> None:
    """Draw the angle left to the border of each pointing zone."""
    times = series.state_times(trajectory)
    for i, zone in enumerate(zones):
        margin = series.zone_margin_deg(trajectory, zone)
        axes.plot(times, margin, label=f"{zone.name} ({zone.kind})", **component(i % 3))
    draw_limit(axes, 0.0, "border")
    frame(axes, times, "Pointing-zone margin", "angle to border [deg]")
    legend(axes, 3)


def iterations(axes: Axes, trajectory: Flight) -> None:
    """Draw the iterations of each solve; those that did not converge are marked."""
    solved = trajectory.status >= 0
    failed = series.unconverged(trajectory)
    time, count = trajectory.time, trajectory.iterations
    axes.plot(time[solved], count[solved], ".", markersize=3, color=style.AXIS_COLORS[0])
    if failed.any():
        axes.plot(
            time[failed],
            count[failed],
            "x",
            markersize=5,
            color=style.LIMIT_COLOR,
            label="not converged",
        )
        legend(axes, 1)
    frame(axes, series.state_times(trajectory), "Solver iterations", "iterations [-]")
    axes.set_ylim(0.0, max(int(count.max(initial=0)), 1) + 0.5)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))


def solve_time(axes: Axes, trajectory: Flight) -> None:
    """Draw the wall-clock time of each solve."""
    unit = style.prefixed("s", trajectory.solve_time)
    values = unit.factor * trajectory.solve_time
    axes.plot(trajectory.time, values, ".", markersize=3, color=style.AXIS_COLORS[0])
    frame(axes, series.state_times(trajectory), "Solve time, wall clock", f"time [{unit.label}]")
    known = positive(values)
    if known.size and known.max() > _WIDE_SPREAD * np.median(known):
        axes.set_yscale("log")  # one slow solve would press all others onto the axis
        plain_numbers(axes.yaxis)
    else:
        axes.set_ylim(bottom=0.0)


def attitude_sphere(
    axes: Axes,
    trajectory: Flight,
    zones: tuple[ZoneParameters, ...] = (),
    view: sphere.View | None = None,
) -> None:
    """Draw the paths of the three body axes on the unit sphere, with the pointing zones.

    The start is dashed, the end solid.
    """
    view = view or sphere.View()
    sphere.draw_sphere(axes, view)
    draw_zones(axes, view, zones)
    attitudes = series.attitudes(trajectory)
    known = attitudes[np.isfinite(attitudes).all(axis=(1, 2))]
    for i, color in enumerate(style.AXIS_COLORS):
        sphere.draw_curve(axes, view, attitudes[:, :, i], color=color, linewidth=1.6)
        sphere.draw_arrow(axes, view, known[0, :, i], color=color, dashed=True)
        sphere.draw_arrow(axes, view, known[-1, :, i], color=color, dashed=False)
    axes.set_title("Body axes on the unit sphere, inertial frame")
    _sphere_legend(axes, zones)


def draw_zones(axes: Axes, view: sphere.View, zones: tuple[ZoneParameters, ...]) -> None:
    """Draw the cones of pointing zones on the sphere."""
    for zone in zones:
        axis = zone.inertial_axis / np.linalg.norm(zone.inertial_axis)
        half_angle = math.radians(zone.half_angle_deg)
        sphere.draw_cap(axes, view, axis, half_angle, color=style.ZONE_COLORS[zone.kind])


def _sphere_legend(axes: Axes, zones: tuple[ZoneParameters, ...]) -> None:
    """Put the legend under the sphere: body axes above, what the strokes mean below."""
    body = [
        Line2D([], [], color=color, label=f"body {name}")
        for color, name in zip(style.AXIS_COLORS, _COMPONENTS, strict=True)
    ]
    meaning = [
        Line2D([], [], color=style.INK, linestyle=(0, (3.5, 2.0)), label="start"),
        Line2D([], [], color=style.INK, label="end"),
    ]
    for kind, color in (
        (kind, style.ZONE_COLORS[kind]) for kind in sorted({z.kind for z in zones})
    ):
        patch = Line2D([], [], color=color, linewidth=6, alpha=0.5, label=f"{kind} zone")
        meaning.append(patch)
    # A legend is filled column by column: pair the two rows, blanks where one is shorter.
    blank = Line2D([], [], linestyle="none", label=" ")
    pairs = zip_longest(body, meaning, fillvalue=blank)
    axes.legend(
        handles=[handle for pair in pairs for handle in pair],
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        ncols=max(len(body), len(meaning)),
    )


def _held(trajectory: Flight, values: Array) -> tuple[Array, Array]:
    """Return times and values with the last value repeated at the end of its control period."""
    return series.state_times(trajectory), np.concatenate([values, values[-1:]])
