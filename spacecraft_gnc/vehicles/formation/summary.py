"""Summary of a flight in formation, in numbers and in words."""

from __future__ import annotations

from collections import Counter
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.limits import as_dicts
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.limits import (
    all_separations,
    communication_angles,
    limits_exceeded,
)
from spacecraft_gnc.vehicles.formation.metrics import (
    delta_v_norms,
    equal_shifts,
    formed_at_step,
    largest,
    last_known,
    least,
    loss,
    occurrences,
    passages,
    position_errors,
)

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.formation.flight import FormationFlight
    from spacecraft_gnc.vehicles.formation.scenario import Scenario

_QUANTILES: Final = {"median": 0.5, "p99": 0.99, "max": 1.0}
_WITHOUT: Final = (Answer.HELD, Answer.LONGEST_KEPT, Answer.LEAST_VIOLATING)
"""Answers of steps at which no shifts were admissible."""


def metrics(flight: FormationFlight, scenario: Scenario | None = None) -> dict[str, Any]:
    """Return the metrics of a flight, ready for JSON.

    Returns
    -------
    dict
        ``steps``, ``missing_steps`` (lost by the recording), ``period`` and ``duration`` [s];
        ``formed_at_step`` (all shifts equal and every position error below ``formed_error`` for
        good; None: never, or without a scenario), ``final_position_error`` [m] (largest, at the
        last step);
        ``max_delta_v`` [m/s] (largest norm commanded), ``min_separation`` [m] and
        ``max_communication_angle_deg`` at the steps, each with its ``_limit`` (None without a
        scenario), ``limits_exceeded`` and ``constraints_kept`` (None without a scenario);
        ``total_delta_v`` [m/s] (sum of all norms, each within the limit where the plant has one),
        ``craft_delta_v``, ``craft_max_delta_v`` [m/s], ``craft_final_error`` [m] and
        ``craft_min_separation`` [m] (to any other one), lists with a number for each craft;
        ``deadlocked`` (parked in another formation at the end), ``deadlocks`` (times that this
        began), ``passages`` (steps to another parked one on the way out), ``inadmissible_steps``
        (no shifts were admissible), ``answers`` (steps by name), ``min_margin`` (least room along
        the predictions, as a share of the limit); those of `metrics.Loss`; ``fallback_steps``,
        ``sources``, ``solve_time_median``, ``_p99``, ``_max`` [s] of the governor (None: not
        known).
    """
    errors = position_errors(flight.position, flight.reference_position, flight.healthy)
    equal = equal_shifts(flight.time_shift, flight.healthy)
    sources, answers = _counted(flight.source, Source), _counted(flight.status, Answer)
    limit = None if scenario is None else scenario.governor.formed_error
    return {
        "steps": flight.n_steps,
        "missing_steps": int(np.count_nonzero(_is_missing(flight))),
        "period": float(flight.period),
        "duration": float(flight.time[-1] - flight.time[0] + flight.period),
        "formed_at_step": None if limit is None else formed_at_step(errors, equal, limit),
        "final_position_error": last_known(errors),
        **_extremes(flight, scenario),
        **_spent(flight, scenario),
        **_by_craft(flight),
        "deadlocked": bool(flight.deadlocked[-1]),
        "deadlocks": occurrences(flight.deadlocked),
        "passages": passages(flight.status == Answer.PASSAGE, flight.time_shift),
        "inadmissible_steps": sum(answers[answer] for answer in _WITHOUT),
        "answers": {answer.name.lower(): count for answer, count in answers.items()},
        "min_margin": least(flight.governor_margin),
        **loss(flight.time, flight.healthy, flight.lost, names(flight, scenario))._asdict(),
        "fallback_steps": sum(sources[source] for source in Source if source.is_fallback),
        "sources": {source.name: count for source, count in sources.items() if count},
        **_solve_times(flight.solve_time[np.isfinite(flight.solve_time)]),
    }


def names(flight: FormationFlight, scenario: Scenario | None) -> tuple[str, ...]:
    """Return the name of each craft; 1, 2, ... where they are not known."""
    if scenario is None:
        return tuple(str(i + 1) for i in range(flight.n_craft))
    return scenario.plant.spacecraft


def _is_missing(flight: FormationFlight) -> Array:
    """Tell of each step (n,) whether state or command is not known."""
    known = (flight.position, flight.velocity, flight.delta_v)
    rows = np.hstack([array.reshape(flight.n_steps, -1) for array in known])
    return np.asarray(~np.isfinite(rows).all(axis=1))


def _extremes(flight: FormationFlight, scenario: Scenario | None) -> dict[str, Any]:
    """Return what the constraints are on, their limits, and which were broken."""
    p = None if scenario is None else scenario.plant
    broken = None if scenario is None else as_dicts(limits_exceeded(flight, scenario))
    return {
        "max_delta_v": largest(delta_v_norms(flight.delta_v, flight.healthy)),
        "max_delta_v_limit": None if p is None else p.max_delta_v,
        "min_separation": least(all_separations(flight)),
        "min_separation_limit": None if p is None else p.min_separation,
        "max_communication_angle_deg": largest(communication_angles(flight)),
        "max_communication_angle_deg_limit": None if p is None else p.max_communication_angle_deg,
        "limits_exceeded": broken or [],
        "constraints_kept": None if broken is None else not broken,
    }


def _spent(flight: FormationFlight, scenario: Scenario | None) -> dict[str, Any]:
    p = None if scenario is None else scenario.plant
    norms = delta_v_norms(flight.delta_v, flight.healthy)
    made = np.minimum(norms, p.max_delta_v) if p is not None and p.saturates else norms
    by_craft = np.nansum(made, axis=0)
    return {"total_delta_v": float(by_craft.sum()), "craft_delta_v": by_craft.tolist()}


def _by_craft(flight: FormationFlight) -> dict[str, Any]:
    """Return what each craft has of its own, a list by name."""
    norms, m = delta_v_norms(flight.delta_v, flight.healthy), flight.n_craft
    away = np.linalg.norm(flight.position - flight.reference_position, axis=-1)
    positions = np.concatenate([flight.position, flight.final_position[None]])
    return {
        "craft_max_delta_v": [largest(norms[:, i]) for i in range(m)],
        "craft_final_error": [last_known(away[:, i]) for i in range(m)],
        "craft_min_separation": [_nearest(positions, i) for i in range(m)],
    }


def _nearest(positions: Array, i: int) -> float | None:
    """Return how near another craft comes to one, of positions (n, m, 3)."""
    others = np.delete(positions, i, axis=1)
    return least(np.linalg.norm(others - positions[:, i : i + 1], axis=-1))


def _solve_times(times: Array) -> dict[str, float | None]:
    return {
        f"solve_time_{name}": float(np.quantile(times, q)) if times.size else None
        for name, q in _QUANTILES.items()
    }


def lines(m: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the lines of a flight's summary, label and text, from its metrics."""
    rows = [
        ("formed", formed_text(m)),
        ("at the end", _end(m)),
        ("constraints", kept_text(m)),
        ("largest delta-v", beside_limit(m, "max_delta_v", "m/s")),
        ("least separation", beside_limit(m, "min_separation", "m")),
        ("widest angle", beside_limit(m, "max_communication_angle_deg", "deg")),
        ("total delta-v", _spent_text(m)),
    ]
    if m["deadlocks"]:
        rows.append(("deadlock", deadlock_text(m)))
    rows += [("craft lost", text) for text in lost_texts(m)]
    rows += [("false alarm", f"{a['spacecraft']} at {a['at']:.5g} s") for a in m["false_alarms"]]
    if m["solve_time_median"] is not None:
        rows.append(("governor takes", _times(m)))
    return rows


def formed_text(m: dict[str, Any]) -> str:
    """Return from when on the formation is formed, in words."""
    step = m["formed_at_step"]
    if step is None:
        return "NO"
    return f"from step {step} on ({step * m['period']:.5g} s), for good"


def kept_text(m: dict[str, Any]) -> str:
    """Return whether the constraints were kept, and which were broken."""
    if m["constraints_kept"] is None:
        return "not known without a scenario"
    broken = "; ".join(each["limit"] for each in m["limits_exceeded"])
    return f"BROKEN: {broken}" if broken else "all kept, at every control step"


def deadlock_text(m: dict[str, Any]) -> str:
    """Return how often the craft were parked in another formation, and how they got out."""
    times = "once" if m["deadlocks"] == 1 else f"{m['deadlocks']} times"
    passed = f"{m['passages']} passage{'s' if m['passages'] != 1 else ''}"
    if m["deadlocked"]:
        return f"{times}, NOT resolved"
    return f"{times}, {'left' if m['formed_at_step'] is None else 'resolved'} by {passed}"


def lost_texts(m: dict[str, Any]) -> list[str]:
    """Return which craft was lost, when, and when it was noticed; empty: none."""
    if m["spacecraft_lost"] is None:
        return []
    noticed = m["spacecraft_loss_detected_at"]
    told = "not noticed" if noticed is None else f"noticed at {noticed:.5g} s"
    return [f"{m['spacecraft_lost']} at {m['spacecraft_lost_at']:.5g} s, {told}"]


def beside_limit(m: dict[str, Any], name: str, unit: str) -> str:
    """Return a metric with its limit."""
    value, limit = m[name], m[f"{name}_limit"]
    text = "not known" if value is None else f"{value:.4g} {unit}"
    if limit is None:
        return text
    kind = "at least" if name.startswith("min") else "limit"
    return f"{text}, {kind} {limit:g} {unit}"


def counts(numbers: dict[str, int]) -> str:
    """Return numbers by name in words, without those that are 0."""
    shown = ((name.lower().replace("_", " "), count) for name, count in numbers.items() if count)
    return ", ".join(f"{name} {count}" for name, count in shown)


def answer_name(answer: int) -> str:
    """Return an answer of the governor in words; unknown where it is none."""
    if not 0 <= answer < len(Answer):
        return "unknown"
    return Answer(answer).name.lower().replace("_", " ")


def _end(m: dict[str, Any]) -> str:
    error = m["final_position_error"]
    return "not known" if error is None else f"up to {length(error)} from the commanded positions"


def length(value: float) -> str:
    """Return a length [m] in the unit that suits it."""
    for unit, size in (("km", 1e3), ("m", 1.0), ("mm", 1e-3)):
        if value >= size:
            return f"{value / size:.4g} {unit}"
    return f"{value / 1e-6:.3g} um" if value >= 1e-8 else "0 m"


def _spent_text(m: dict[str, Any]) -> str:
    parts = ", ".join(f"{value:.3g}" for value in m["craft_delta_v"])
    return f"{m['total_delta_v']:.4g} m/s (by craft {parts})"


def _times(m: dict[str, Any]) -> str:
    parts = (f"{1e3 * m[f'solve_time_{name}']:.3g} ms {name}" for name in _QUANTILES)
    return ", ".join(parts)


_Named = TypeVar("_Named", bound=IntEnum)


def _counted(numbers: NDArray[Any], kind: type[_Named]) -> dict[_Named, int]:
    """Return the steps of each member of an enumeration."""
    found = Counter(numbers.tolist())
    return {member: found[member] for member in kind}
