"""Summary of a docking flight, in numbers and in words."""

from __future__ import annotations

import math
from collections import Counter
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.limits import as_dicts
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.decision import Answer, Phase
from spacecraft_gnc.vehicles.docking.limits import clearances, limits_exceeded, margins
from spacecraft_gnc.vehicles.docking.metrics import (
    angles,
    docked_at,
    impulse,
    largest,
    last_known,
    least,
    loss,
    settled_at,
)

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.docking.flight import DockingFlight
    from spacecraft_gnc.vehicles.docking.scenario import Scenario

_QUANTILES: Final = {"median": 0.5, "p99": 0.99, "max": 1.0}
_WITHOUT: Final = (Answer.INFEASIBLE, Answer.NOT_SOLVED, Answer.LEAST_VIOLATION)
"""Answers of steps at which no reference was admissible, or none was found."""


def metrics(flight: DockingFlight, scenario: Scenario | None = None) -> dict[str, Any]:
    """Return the metrics of a flight, ready for JSON.

    Returns
    -------
    dict
        ``steps``, ``missing_steps`` (lost by the recording), ``period`` and ``duration`` [s];
        ``docked_at`` [s] (2 cm and 1 deg for good; None: never), ``final_offset`` [m] between the
        ports, ``final_angle_deg``, ``final_speed`` [m/s] of the port;
        ``max_force`` [N] and ``max_moment`` [N m] (largest component commanded),
        ``min_line_of_sight_margin`` and ``min_clearance`` [m], each with its ``_limit`` (None
        without a scenario), ``limits_exceeded`` and ``constraints_kept`` (None without a scenario);
        ``reference_settled_at`` [s] (reference at the target for good), ``governed_share`` (of the
        steps, with the reference short of the target), ``inadmissible_steps`` (no admissible
        reference was found), ``answers`` and ``phases`` (steps by name), ``phase`` (at the end),
        ``min_slack``; ``impulse`` [N s] of the force commanded, within its limit where the plant
        has one, and ``delta_v`` [m/s]; those of `metrics.Loss`; ``hold_distance`` [m] from the hold
        point at the end (None unless the docking was given up); ``fallback_steps``, ``sources``,
        ``solve_time_median``, ``_p99``, ``_max`` [s] of the governor (None: not known).
    """
    times, offset, attitude = states(flight)
    distance = np.linalg.norm(offset, axis=1)
    sources, answers = _counted(flight.source, Source), _counted(flight.status, Answer)
    known = np.isfinite(flight.reference).all(axis=1)
    away = np.abs(flight.reference - flight.target).max(axis=1, initial=0.0) > 1e-6
    return {
        "steps": flight.n_steps,
        "missing_steps": int(np.count_nonzero(_is_missing(flight))),
        "period": float(flight.period),
        "duration": float(times[-1] - times[0]),
        "docked_at": docked_at(times, offset, attitude),
        "final_offset": last_known(distance),
        "final_angle_deg": _degrees(last_known(angles(attitude))),
        "final_speed": last_known(np.linalg.norm(velocities(flight), axis=1)),
        **_extremes(flight, scenario),
        "reference_settled_at": settled_at(flight.time, flight.reference, flight.target),
        "governed_share": float(np.mean(away[known])) if known.any() else None,
        "inadmissible_steps": sum(answers[answer] for answer in _WITHOUT),
        "answers": {answer.name.lower(): count for answer, count in answers.items()},
        "phases": {
            phase.name.lower(): count for phase, count in _counted(flight.phase, Phase).items()
        },
        "phase": phase_name(int(flight.phase[-1])),
        "min_slack": least(flight.slack),
        **_spent(flight, scenario),
        **loss(flight.time, flight.thrusters, flight.lost_thruster)._asdict(),
        "hold_distance": _hold_distance(flight, scenario),
        "fallback_steps": sum(sources[source] for source in Source if source.is_fallback),
        "sources": {source.name: count for source, count in sources.items() if count},
        **_solve_times(flight.solve_time[np.isfinite(flight.solve_time)]),
    }


def states(flight: DockingFlight) -> tuple[Array, Array, Array]:
    """Return times (n + 1,), port offsets and attitudes of the states, the last included."""
    return (
        np.append(flight.time, flight.time[-1] + flight.period),
        np.vstack([flight.port_offset, flight.final_port_offset]),
        np.concatenate([flight.attitude, flight.final_attitude[None]]),
    )


def velocities(flight: DockingFlight) -> Array:
    """Return the port velocities (n + 1, 3) of the states [m/s]."""
    return np.vstack([flight.port_velocity, flight.final_port_velocity])


def _is_missing(flight: DockingFlight) -> Array:
    """Tell of each step (n,) whether state or command is not known."""
    n = flight.n_steps
    known = (flight.port_offset, flight.attitude.reshape(n, 9), flight.force)
    return np.asarray(~np.isfinite(np.hstack(known)).all(axis=1))


def _extremes(flight: DockingFlight, scenario: Scenario | None) -> dict[str, Any]:
    """Return what the constraints are on, their limits, and which were broken."""
    p = None if scenario is None else scenario.plant
    broken = None if scenario is None else as_dicts(limits_exceeded(flight, scenario))
    return {
        "max_force": largest(flight.force),
        "max_force_limit": None if p is None else p.max_force,
        "max_moment": largest(flight.moment),
        "max_moment_limit": None if p is None else p.max_moment,
        "min_line_of_sight_margin": least(margins(flight)),
        "min_line_of_sight_margin_limit": None if p is None else 0.0,
        "min_clearance": least(clearances(flight)),
        "min_clearance_limit": None if p is None else -p.clearance_tolerance,
        "limits_exceeded": broken or [],
        "constraints_kept": None if broken is None else not broken,
    }


def _spent(flight: DockingFlight, scenario: Scenario | None) -> dict[str, Any]:
    p = None if scenario is None else scenario.plant
    limit = p.max_force if p is not None and p.saturates else math.inf
    total = impulse(flight.force, flight.period, limit)
    return {"impulse": total, "delta_v": None if p is None else total / p.mass}


def _hold_distance(flight: DockingFlight, scenario: Scenario | None) -> float | None:
    if scenario is None or flight.phase[-1] in (Phase.DOCKING, -1):
        return None
    offset = states(flight)[1]
    return last_known(np.linalg.norm(offset - scenario.governor.hold_port_offset, axis=1))


def _solve_times(times: Array) -> dict[str, float | None]:
    return {
        f"solve_time_{name}": float(np.quantile(times, q)) if times.size else None
        for name, q in _QUANTILES.items()
    }


def lines(m: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the lines of a flight's summary, label and text, from its metrics."""
    rows = [
        ("docked", docked_text(m)),
        ("at the end", _end(m)),
        ("constraints", kept_text(m)),
        ("largest force", beside_limit(m, "max_force", "N")),
        ("largest moment", beside_limit(m, "max_moment", "N m")),
        ("least line of sight", beside_limit(m, "min_line_of_sight_margin", "m")),
        ("least clearance", beside_limit(m, "min_clearance", "m")),
        ("impulse, delta-v", _spent_text(m)),
    ]
    rows += [("reference", text) for text in [governed_text(m)] if text]
    rows += [("thruster lost", text) for text in lost_texts(m)]
    rows += [("false alarm", f"{a['thruster']} at {a['at']:g} s") for a in m["false_alarms"]]
    if _is_given_up(m):
        rows.append(("given up", abort_text(m)))
    if m["solve_time_median"] is not None:
        rows.append(("governor takes", _times(m)))
    return rows


def docked_text(m: dict[str, Any]) -> str:
    """Return from when on it is docked, in words."""
    at = m["docked_at"]
    if at is None:
        return "no" if _is_given_up(m) else "NO"
    return f"from {at:g} s on (2 cm and 1 deg for good)"


def kept_text(m: dict[str, Any]) -> str:
    """Return whether the constraints were kept, and which were broken."""
    if m["constraints_kept"] is None:
        return "not known without a scenario"
    broken = "; ".join(each["limit"] for each in m["limits_exceeded"])
    return f"BROKEN: {broken}" if broken else "all kept, between the steps too"


def lost_texts(m: dict[str, Any]) -> list[str]:
    """Return which direction was lost, when, and when it was noticed; empty: none."""
    if m["thruster_lost"] is None:
        return []
    noticed = m["thruster_loss_detected_at"]
    told = "not noticed" if noticed is None else f"noticed at {noticed:g} s"
    return [f"{m['thruster_lost']} at {m['thruster_lost_at']:g} s, {told}"]


def abort_text(m: dict[str, Any]) -> str:
    """Return how a docking that was given up ended."""
    distance = m["hold_distance"]
    where = "" if distance is None else f", {distance:.3g} m from the hold point"
    return f"{m['phase']} at the end{where}"


def governed_text(m: dict[str, Any]) -> str:
    """Return how long the reference was short of the target; empty where it says nothing."""
    if not m["governed_share"] or _is_given_up(m):
        return ""
    at = m["reference_settled_at"]
    until = "to the end" if at is None else f"until {at:g} s"
    return f"short of the target at {100.0 * m['governed_share']:.0f} % of the steps, {until}"


def beside_limit(m: dict[str, Any], name: str, unit: str) -> str:
    """Return a metric with its limit; one that is beyond it says so."""
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


def phase_name(phase: int) -> str:
    """Return a phase in a word; unknown where it is none."""
    return _word(Phase(phase)) if 0 <= phase < len(Phase) else _UNKNOWN


def answer_name(answer: int) -> str:
    """Return an answer of the governor in words; unknown where it is none."""
    return _word(Answer(answer)) if 0 <= answer < len(Answer) else _UNKNOWN


def _is_given_up(m: dict[str, Any]) -> bool:
    return m["phase"] not in (_word(Phase.DOCKING), _UNKNOWN)


def _end(m: dict[str, Any]) -> str:
    offset, angle, speed = m["final_offset"], m["final_angle_deg"], m["final_speed"]
    if offset is None or angle is None:
        return "not known"
    moving = "" if speed is None else f", port at {_length(speed)}/s"
    return f"ports {_length(offset)} apart, {angle:.3g} deg{moving}"


def _length(value: float) -> str:
    """Return a length [m] in the unit that suits it."""
    for unit, size in (("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-6:.3g} um" if value >= 1e-8 else "0 m"


def _spent_text(m: dict[str, Any]) -> str:
    text = f"{m['impulse']:.4g} N s"
    return text if m["delta_v"] is None else f"{text}, {m['delta_v']:.3g} m/s"


def _times(m: dict[str, Any]) -> str:
    parts = (f"{1e3 * m[f'solve_time_{name}']:.3g} ms {name}" for name in _QUANTILES)
    return ", ".join(parts)


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else math.degrees(angle)


_UNKNOWN: Final = "unknown"
_Named = TypeVar("_Named", bound=IntEnum)


def _word(member: IntEnum) -> str:
    return member.name.lower().replace("_", " ")


def _counted(numbers: NDArray[Any], kind: type[_Named]) -> dict[_Named, int]:
    """Return the steps of each member of an enumeration."""
    found = Counter(numbers.tolist())
    return {member: found[member] for member in kind}
