"""A flight beside what another controller would have commanded: numbers and a figure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import TIME_LABEL, positive
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.metrics.summary import summarize

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.loop.trajectory import Trajectory
    from spacecraft_gnc.vehicles.rigid_body.resolve.replay import Resolved
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

_SIZE: Final = (6.3, 8.6)  # [inch]
_OF_A_PENALTY: Final = (
    "penalty_side",
    "penalty_step",
    "penalty_max",
    "penalty_torque_excess",
    "penalty_zone_excess_deg",
)
_OF_A_SIDE: Final = (
    "max_torque",
    "iterations_median",
    "iterations_max",
    "unconverged_steps",
    "stalled_steps",
    "escaping_steps",
    "fallback_steps",
    "solve_time_median",
    "solve_time_p99",
    "solve_time_max",
    "sources",
)


def compare(resolved: Resolved, recorded: Scenario, revised: Scenario) -> dict[str, Any]:
    """Return the comparison in numbers, ready for JSON.

    Returns
    -------
    dict
        ``steps`` compared, ``first_step``, ``last_step``; ``identical_steps`` (torques equal bit
        for bit) and ``first_difference`` (a step, or None); ``torque_difference_max``,
        ``_rms`` [N m] and ``_max_step``; ``cost_difference_max`` (of the largest size, with its
        sign), ``_max_step``, ``_rms`` by the recorded problem, None where plans cannot be compared;
        ``plain_cost_difference_max``, ``_max_step``, ``_rms``: the same without penalties;
        ``penalty_side``, ``_step``, ``_max``, ``_torque_excess`` [N m] and ``_zone_excess_deg``:
        the plan that pays most for leaving a limit, and by how much it does (None, as the three
        before: both solve the same problem, or no plan is known);
        ``recorded`` and ``replayed``: ``method``, ``residual_max`` and, as `summarize` has them,
        ``max_torque``, iterations, solve times, failed steps and sources.
    """
    torque = resolved.torque_difference
    worst = int(np.argmax(torque))
    equal = (resolved.replayed.torque == resolved.recorded.torque).all(axis=1)
    return {
        "steps": len(resolved.steps),
        "first_step": int(resolved.steps[0]),
        "last_step": int(resolved.steps[-1]),
        "identical_steps": int(np.count_nonzero(equal)),
        "first_difference": resolved.first_difference,
        "torque_difference_max": float(torque[worst]),
        "torque_difference_max_step": int(resolved.steps[worst]),
        "torque_difference_rms": _rms(torque),
        **_largest("cost_difference", resolved.cost_difference, resolved),
        **_penalty_metrics(resolved),
        "recorded": _side(resolved.recorded, recorded),
        "replayed": _side(resolved.replayed, revised),
    }


def _largest(name: str, values: Array, resolved: Resolved) -> dict[str, Any]:
    """Return the largest of (m,) values with its sign, its step, and their root mean square."""
    known = np.flatnonzero(np.isfinite(values))
    if not known.size:
        return dict.fromkeys(f"{name}_{what}" for what in ("max", "max_step", "rms"))
    worst = known[np.argmax(np.abs(values[known]))]
    return {
        f"{name}_max": float(values[worst]),
        f"{name}_max_step": int(resolved.steps[worst]),
        f"{name}_rms": _rms(values[known]),
    }


def _penalty_metrics(resolved: Resolved) -> dict[str, Any]:
    plain = _largest("plain_cost_difference", resolved.plain_cost_difference, resolved)
    penalties = np.array([[price.penalty for price in pair] for pair in resolved.prices])
    if not np.isfinite(penalties).any():
        return plain | dict.fromkeys(_OF_A_PENALTY)
    row, side = np.unravel_index(np.nanargmax(penalties), penalties.shape)
    price = resolved.prices[row][side]
    found = (
        ("recorded", "replayed")[side],
        int(resolved.steps[row]),
        price.penalty,
        price.torque_excess,
        price.zone_excess_deg,
    )
    return plain | dict(zip(_OF_A_PENALTY, found, strict=True))


def _side(trajectory: Trajectory, scenario: Scenario) -> dict[str, Any]:
    metrics = summarize(trajectory, scenario)
    residual = trajectory.residual[np.isfinite(trajectory.residual)]
    return {
        "method": scenario.controller.method,
        "residual_max": float(residual.max()) if residual.size else None,
        **{name: metrics[name] for name in _OF_A_SIDE},
    }


def _rms(values: Array) -> float:
    return math.sqrt(float(np.mean(values**2)))


# The figure.


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
        color = style.AXIS_COLOURS[i]
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
    drawn = zip(solved, names, ("o", "."), (style.MUTED, style.AXIS_COLOURS[0]), strict=True)
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
