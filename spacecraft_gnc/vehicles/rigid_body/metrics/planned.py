"""Metrics of a planned flight: what its plans cost, and how closely they were flown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.governors.planned.report import Phase
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.planner import series as plan_series

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

_NAMES: Final = (
    "replans", "plan_not_found_steps", "plan_end_time", "plan_cost", "flown_cost",
    "max_plan_error_deg", "max_plan_momentum_error", "bound_use", "max_bound_use",
)  # fmt: skip


def plan_metrics(flight: Flight, scenario: Scenario | None) -> dict[str, Any]:
    """Return the metrics of the plans; None for all of them where nothing was planned.

    Returns
    -------
    dict
        ``replans`` (plans taken after the first one), ``plan_not_found_steps`` (at which none was
        found for the state of then), ``plan_end_time`` (from which on the goal of the last plan is
        held [s]; None: not reached), ``plan_cost`` and ``flown_cost`` (sums of |u|^2 / 2 of the
        torques planned for the steps flown, and of those applied [N^2 m^2]),
        ``max_plan_error_deg`` and ``max_plan_momentum_error`` [N m s] (largest distances from the
        plan), ``bound_use`` (largest share of each bound, by ``torque x``, ``momentum z``; empty
        without a scenario) and ``max_bound_use``. Only planned flights have ``max_components``
        (largest size of each component of ``torque`` [N m] and ``momentum`` [N m s]), and, where
        the scenario is known, ``lower_bounds`` and ``upper_bounds`` of the same.
    """
    if not plan_series.is_planned(flight):
        return dict.fromkeys(_NAMES)
    bounds = plan_series.bounds_of(scenario)
    use = plan_series.bound_use(flight, bounds.real) if bounds is not None else {}
    off = np.linalg.norm(flight.momentum - flight.plan_momentum, axis=1)
    numbers = flight.plan[flight.plan >= 0]
    return {
        "replans": int(np.count_nonzero(np.diff(numbers))),
        "plan_not_found_steps": int(np.count_nonzero(flight.plan_phase == Phase.NOT_FOUND)),
        "plan_end_time": _end_time(flight),
        "plan_cost": _cost(flight.plan_torque),
        "flown_cost": _cost(flight.torque),
        "max_plan_error_deg": _largest(plan_series.plan_error_deg(flight)),
        "max_plan_momentum_error": _largest(off),
        "bound_use": use,
        "max_bound_use": max(use.values(), default=None),
        "max_components": {
            "torque": _largest_components(flight.torque),
            "momentum": _largest_components(series.momenta(flight)),
        },
        **(_bounds(bounds.real) if bounds is not None else {}),
    }


def _bounds(real: Array) -> dict[str, dict[str, list[float]]]:
    low_u, high_u, low_p, high_p = real.tolist()
    return {
        "lower_bounds": {"torque": low_u, "momentum": low_p},
        "upper_bounds": {"torque": high_u, "momentum": high_p},
    }


def _largest_components(values: Array) -> list[float | None]:
    return [_largest(component) for component in np.abs(values).T]


def _end_time(flight: Flight) -> float | None:
    """Return the time from which on the last plan has ended [s]; None: it has not."""
    known = flight.plan_phase >= 0
    held = flight.plan_phase[known] == Phase.ARRIVED
    if not held[-1]:
        return None
    before = np.flatnonzero(~held)
    return float(flight.time[known][before[-1] + 1 if before.size else 0])


def _cost(torque: Array) -> float:
    return 0.5 * float(np.nansum(torque**2))


def _largest(values: Array) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else None
