"""Summary metrics of one flight."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.limits import as_dicts
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.metrics.limits import limits_exceeded
from spacecraft_gnc.vehicles.rigid_body.metrics.neighboring import neighboring_metrics
from spacecraft_gnc.vehicles.rigid_body.metrics.planned import plan_metrics

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.controllers.methods import ControllerParameters
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

SETTLE_THRESHOLDS_DEG: Final = (5.0, 1.0, 0.1)
_SATURATION = 1.0 - 1e-6  # share of the limit: the penalty lets the norm end just beside it
_SAME_ATTITUDE = 1e-9  # largest difference of entries


def summarize(trajectory: Flight, scenario: Scenario | None = None) -> dict[str, Any]:
    """Return the metrics of a trajectory, ready for JSON.

    Parameters
    ----------
    trajectory
        What was flown.
    scenario
        Gives limits, weights and pointing zones; without it the metrics that need them are None.

    Returns
    -------
    dict
        ``steps``, ``missing_steps`` (lost by the recording), ``period`` and ``duration`` [s],
        ``final_error_deg``, ``final_momentum`` [N m s], ``settle_time_5deg``, ``_1deg``,
        ``_0.1deg`` (time after which the error stays below for good [s]; None: never): angles to
        the target where a governor shaped the reference, else to the reference, as ``error_to``
        says; ``alpha_one_time`` (from which on the governor allowed the whole way to the target
        for good [s]; None: never, or no governor), ``final_reference_error_deg`` (from the last
        reference to the target), ``inadmissible_steps`` (at which the prediction violated a
        constraint even with the last reference held), ``min_governor_margin`` (of its predictions,
        in the unit of each one's nearest constraint),
        ``max_torque`` [N m], ``torque_limit`` [N m], ``saturated_steps``, with a limit of the
        plant's actuators ``actuator_limit`` [N m] and ``actuator_limit_steps`` (on which one gave
        all that it can), ``cost`` (sum of the
        stage costs as the method counts them; None of a method that reads no weights or plans),
        ``min_zone_margin_deg``, ``zone_margin_deg`` by zone, ``limits_exceeded`` (by more than
        0.1 %, see `audit.limits`; empty without a scenario), ``iterations_median``,
        ``iterations_max``, ``unconverged_steps`` (whose solve failed), ``stalled_steps`` and
        ``escaping_steps`` (at rest away from the target, and leaving there; None of a method that
        makes no solves),
        ``solve_time_median``, ``_p99``, ``_max`` [s],
        ``sources`` (steps by source), ``fallback_steps`` (whose torque stood in for one that
        the method did not find),
        ``neighboring_share`` and ``neighboring_error`` (see `metrics.neighboring`),
        and of a planned flight what `metrics.planned` says.
    """
    controller = scenario.controller if scenario is not None else None
    n = len(trajectory.time)
    rows = np.hstack([trajectory.attitude.reshape(n, 9), trajectory.momentum, trajectory.torque])
    return {
        "steps": n,
        "missing_steps": int(np.count_nonzero(np.isnan(rows).any(axis=1))),
        "period": float(trajectory.period),
        "duration": _number(series.state_times(trajectory)[-1]),
        **_attitude_metrics(trajectory),
        **_governor_metrics(trajectory),
        **_torque_metrics(trajectory, scenario),
        **_actuator_metrics(trajectory, scenario),
        **_zone_metrics(trajectory, controller),
        **_limit_metrics(trajectory, scenario),
        **_solver_metrics(trajectory, scenario),
        **neighboring_metrics(trajectory, scenario),
        **plan_metrics(trajectory, scenario),
    }


def settle_time(times: Array, error: Array, threshold: float) -> float | None:
    """Return the time after which ``error`` stays below ``threshold`` for good.

    Parameters
    ----------
    times, error
        (n,) samples; NaN errors are passed over.
    threshold
        In the unit of ``error``.

    Returns
    -------
    float or None
        The first sample of the last stretch below; None if the last sample is not below.
    """
    known = np.isfinite(error)
    times, error = times[known], error[known]
    above = np.flatnonzero(error >= threshold)
    first = int(above[-1]) + 1 if above.size else 0
    return float(times[first]) if first < times.size else None


def _limit_metrics(trajectory: Flight, scenario: Scenario | None) -> dict[str, Any]:
    if scenario is None:
        return {"limits_exceeded": []}
    states = series.attitudes(trajectory), series.momenta(trajectory)
    return {"limits_exceeded": as_dicts(limits_exceeded(scenario, *states, trajectory.torque))}


def _attitude_metrics(trajectory: Flight) -> dict[str, Any]:
    times = series.state_times(trajectory)
    error = series.settling_error_deg(trajectory)
    settled = {
        f"settle_time_{threshold:g}deg": settle_time(times, error, threshold)
        for threshold in SETTLE_THRESHOLDS_DEG
    }
    return {
        "final_error_deg": _number(error[-1]),
        "final_momentum": _number(np.linalg.norm(trajectory.final_momentum)),
        **settled,
    }


def _governor_metrics(trajectory: Flight) -> dict[str, Any]:
    aims = series.targets(trajectory)
    margins = trajectory.governor_margin[np.isfinite(trajectory.governor_margin)]
    return {
        "error_to": "reference" if aims is None else "target",
        "alpha_one_time": None if aims is None else _alpha_one_time(trajectory, aims),
        "final_reference_error_deg": None if aims is None else _off_target(trajectory, aims),
        "inadmissible_steps": int(np.count_nonzero(margins < 0.0)),
        "min_governor_margin": float(margins.min()) if margins.size else None,
    }


def _off_target(trajectory: Flight, targets: Array) -> float | None:
    """Return the angle from the last reference to the last target [deg]."""
    last = trajectory.final_reference
    if not np.isfinite(last).all():
        return None
    return math.degrees(lie.angle_between(last, targets[-1]))


def _alpha_one_time(trajectory: Flight, targets: Array) -> float | None:
    """Return the time from which on the reference is the target, and alpha 1 [s]."""
    off = np.abs(trajectory.reference - targets[:-1]).max(axis=(1, 2))
    there = (trajectory.alpha == 1.0) & (off < _SAME_ATTITUDE)
    recorded = np.isfinite(trajectory.alpha) & np.isfinite(off)
    away = np.where(recorded, np.where(there, 0.0, 1.0), math.nan)
    return settle_time(trajectory.time, away, 0.5)


def _torque_metrics(trajectory: Flight, scenario: Scenario | None) -> dict[str, Any]:
    norm = series.torque_norm(trajectory)
    limit = series.torque_limit(trajectory, scenario)
    cost = None
    if scenario is not None and _counts_stage_costs(scenario):
        cost = _number(np.nansum(_stage_costs(trajectory, scenario)))
    return {
        "max_torque": _number(_largest(norm)),
        "torque_limit": limit or None,
        "saturated_steps": int(np.count_nonzero(norm >= _SATURATION * limit)) if limit else None,
        "cost": cost,
    }


def _actuator_metrics(trajectory: Flight, scenario: Scenario | None) -> dict[str, Any]:
    limit = 0.0 if scenario is None else scenario.plant.max_torque
    if limit == 0.0:
        return {}
    on_it = (np.abs(trajectory.torque) >= limit).any(axis=1)
    return {"actuator_limit": limit, "actuator_limit_steps": int(np.count_nonzero(on_it))}


def _counts_stage_costs(scenario: Scenario) -> bool:
    """Tell whether a method weighs errors of the reference, rather than those of a plan."""
    reads = scenario.method.reads
    return "weights.stage_attitude" in reads and "plan.duration" not in reads


def _stage_costs(trajectory: Flight, scenario: Scenario) -> Array:
    controller = scenario.controller
    if "weights.stage_rate" in scenario.method.reads:
        return series.terminal_set_stage_costs(trajectory, controller)
    return series.stage_costs(
        trajectory, controller.weights, controller.actuators, controller.inertia
    )


def _zone_metrics(trajectory: Flight, controller: ControllerParameters | None) -> dict[str, Any]:
    zones = controller.zones if controller is not None else ()
    margins = {
        zone.name: _number(-_largest(-series.zone_margin_deg(trajectory, zone))) for zone in zones
    }
    known = [margin for margin in margins.values() if margin is not None]
    return {"min_zone_margin_deg": min(known, default=None), "zone_margin_deg": margins}


def _solver_metrics(trajectory: Flight, scenario: Scenario | None) -> dict[str, Any]:
    source = trajectory.source
    if scenario is not None:  # a reader did so already, unless the file held none
        source = scenario.method.current_sources(source)
    sources = Counter(source.tolist())
    solved = trajectory.status >= 0
    iterations = trajectory.iterations[solved]
    solve_time = trajectory.solve_time[np.isfinite(trajectory.solve_time)]
    return {
        "iterations_median": float(np.median(iterations)) if iterations.size else None,
        "iterations_max": int(iterations.max()) if iterations.size else None,
        "unconverged_steps": _count(series.unconverged(trajectory), solved),
        "stalled_steps": _count(trajectory.status == Status.STALLED, solved),
        "escaping_steps": _count(trajectory.status == Status.ESCAPING, solved),
        **_times(solve_time),
        "sources": {source.name: sources[source] for source in Source if sources[source]},
        "fallback_steps": sum(sources[source] for source in Source if source.is_fallback),
    }


def _count(steps: NDArray[np.bool_], solved: NDArray[np.bool_]) -> int | None:
    """Return how many steps it is; None where no step was solved at all."""
    return int(np.count_nonzero(steps)) if solved.any() else None


def _largest(values: Array) -> float:
    """Return the largest value that is not NaN; NaN where there is none."""
    known = values[~np.isnan(values)]
    return float(known.max()) if known.size else math.nan


def _times(solve_time: Array) -> dict[str, float | None]:
    names = [f"solve_time_{name}" for name in ("median", "p99", "max")]
    if not solve_time.size:
        return dict.fromkeys(names)
    return dict(zip(names, np.quantile(solve_time, [0.5, 0.99, 1.0]).tolist(), strict=True))


def _number(value: float | np.floating[Any]) -> float | None:
    """Return a finite float or None: JSON has neither NaN nor infinity."""
    return float(value) if math.isfinite(value) else None
