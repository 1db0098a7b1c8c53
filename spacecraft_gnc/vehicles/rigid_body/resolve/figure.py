"""Comparison of a flight with the commands of another controller: a figure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import TIME_LABEL, positive
from spacecraft_gnc.vehicles.rigid_body import series

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.vehicles.rigid_body.resolve.replay import Resolved

_SIZE: Final = (6.3, 8.6)  # [inch]


def figure(resolved: Resolved, names: tuple[str, str], title: str = "") -> Figure:
    """Draw recorded and replayed torque, their difference, iterations and solve times.

    Parameters
    ----------
    resolved
        From `resolve`.
    names
        Of the recorded and the replayed method.
    title
        Heading.
    """
    with style.applied():
        drawn = Figure(_SIZE, layout="constrained")
        torque, difference, iterations, time = drawn.subplots(
            4, 1, sharex=True, height_ratios=[1.6, 1.0, 1.0, 1.0]
        )
        _torques(torque, resolved, names)
        _difference(difference, resolved)
        _solver(iterations, resolved, names, "iterations")
        _solver(time, resolved, names, "solve_time")
        time.set_xlabel(TIME_LABEL)
        time.set_xlim(resolved.recorded.time[0], series.state_times(resolved.recorded)[-1])
        if title:
            drawn.suptitle(title, fontsize=12, fontweight="bold")
        return drawn


def _torques(axes: Axes, resolved: Resolved, names: tuple[str, str]) -> None:
    old, new = resolved.recorded, resolved.replayed
    unit = style.prefixed("N m", old.torque, new.torque)
    for i, component in enumerate("xyz"):
        color = style.AXIS_COLORS[i]
        label = f"$u_{component}$"
        for side, width, alpha in ((old, 3.2, 0.35), (new, 1.2, 1.0)):
            axes.step(
                side.time,
                unit.factor * side.torque[:, i],
                where="post",
                color=color,
                linewidth=width,
                alpha=alpha,
                label=label if side is new else None,
            )
    axes.set(
        title=f"Torque, body frame: {names[0]} as flown (wide), {names[1]} (thin)",
        ylabel=f"torque [{unit.label}]",
    )
    axes.legend(loc="upper right", ncols=3)


def _difference(axes: Axes, resolved: Resolved) -> None:
    values = resolved.torque_difference
    axes.set_title("Norm of the difference of the torques")
    axes.set_ylabel("difference [N m]")
    if not values.any():
        axes.set_ylim(0.0, 1.0)
        axes.set_yticks([0.0])
        text = "zero in every step, bit for bit"
        axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center")
    positive = np.where(values > 0.0, values, math.nan)  # zero has no place on this scale
    if np.isfinite(positive).any():
        axes.set_yscale("log")
        axes.plot(resolved.recorded.time, positive, ".", markersize=3, color=style.INK)


def _solver(axes: Axes, resolved: Resolved, names: tuple[str, str], what: str) -> None:
    sides = (resolved.recorded, resolved.replayed)
    values = [np.asarray(getattr(side, what), dtype=np.float64) for side in sides]
    unit = style.prefixed("s", *values) if what == "solve_time" else style.Unit("", 1.0)
    solved = [
        np.where(side.status >= 0, v, math.nan) for side, v in zip(sides, values, strict=True)
    ]
    drawn = zip(solved, names, ("o", "."), (style.MUTED, style.AXIS_COLORS[0]), strict=True)
    for numbers, name, marker, color in drawn:
        if np.isfinite(numbers).any():
            face = "none" if marker == "o" else color
            axes.plot(
                resolved.recorded.time,
                unit.factor * numbers,
                marker,
                markersize=4,
                color=color,
                markerfacecolor=face,
                label=name if marker == "." else f"{name}, as flown",
            )
    known = np.concatenate(solved)
    known = positive(known)
    if known.size and known.max() > 20.0 * known.min():
        axes.set_yscale("log")
    elif known.size:
        axes.set_ylim(bottom=0.0)
    if known.size:
        axes.legend(loc="upper right", ncols=2)
    if what == "iterations":
        axes.set(title="Iterations of the solve", ylabel="iterations")
    else:
        axes.set(title="Solve time, wall clock", ylabel=f"time [{unit.label}]")
