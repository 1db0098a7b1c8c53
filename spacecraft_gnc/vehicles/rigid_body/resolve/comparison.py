"""Comparison of a flight with the commands of another controller, in numbers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.metrics.summary import summarize
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import makes_plans

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.resolve.replay import Resolved
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

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
        ``tracks_plans``: whether the motion of the plans that flew was tracked, and not the
        recorded reference;
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
        "tracks_plans": makes_plans(recorded.method) and not makes_plans(revised.method),
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


def _side(trajectory: Flight, scenario: Scenario) -> dict[str, Any]:
    metrics = summarize(trajectory, scenario)
    residual = trajectory.residual[np.isfinite(trajectory.residual)]
    return {
        "method": scenario.controller.method,
        "residual_max": float(residual.max()) if residual.size else None,
        **{name: metrics[name] for name in _OF_A_SIDE},
    }


def _rms(values: Array) -> float:
    return math.sqrt(float(np.mean(values**2)))
