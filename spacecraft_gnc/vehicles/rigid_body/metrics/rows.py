"""Summary of a rigid body's flight in words."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from spacecraft_gnc.vehicles.rigid_body.planner.rows import bounds_text

_UNITS: Final = {"torque": "N m", "momentum": "N m s"}
_NOTHING: Final = "-"  # a row without a value is left out


def summary_rows(m: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the lines of a flight's summary, label and text, from its metrics."""
    never = "unknown" if m["final_error_deg"] is None else "never"
    settled = [(f"under {x} deg for good", m[f"settle_time_{x}deg"]) for x in ("5", "1", "0.1")]
    iterations = f"{_text(m['iterations_median'], 3)} median, {_text(m['iterations_max'], 3)} most"
    work = "command" if m["iterations_median"] is None else "solve"
    sources = ", ".join(f"{name} {count}" for name, count in m["sources"].items())
    rows = [
        ("error at the end", _final_error(m)),
        *((label, never if at is None else f"from {at:g} s") for label, at in settled),
        *_governor_rows(m),
        *_plan_rows(m),
        _largest_torque(m),
        ("sum of stage costs", _stage_costs(m)),
        ("least zone margin", f"{_text(m['min_zone_margin_deg'], 4)} deg"),
        ("iterations a solve", iterations),
        (f"time a {work}", _solve_times(m)),
        ("steps not solved", _text(m["unconverged_steps"], 10)),
        ("torque from", sources),
    ]
    if m["neighboring_share"] is not None:
        share = f"{100.0 * m['neighboring_share']:.1f} % of the steps"
        error = f", off the exact torque by {_text(m['neighboring_error'], 3)} N m at most"
        rows.append(("neighboring extremals", share + error))
    if m["stalled_steps"]:
        rows.append(("steps at a standstill", f"{m['stalled_steps']}, away from the target"))
    if m["escaping_steps"]:
        text = f"{m['escaping_steps']}, by a small torque added to the optimal one"
        rows.append(("standstill escapes", text))
    if m.get("actuator_limit_steps"):
        text = f"the actuators gave all they can, {m['actuator_limit']:g} N m about an axis, at "
        rows.append(("warning", f"{text}{m['actuator_limit_steps']} of {m['steps']} steps"))
    # A row without a value starts with the dash alone; a negative number is a value.
    return [row for row in rows if row[1].split(" ")[0] != _NOTHING]


def _governor_rows(m: dict[str, Any]) -> list[tuple[str, str]]:
    if m["min_governor_margin"] is None:
        return []
    at, off = m["alpha_one_time"], m["final_reference_error_deg"]
    if at is not None:
        return [("target admitted", f"from {at:g} s (alpha = 1)")]
    where = "" if off is None else f", reference {_text(off, 5)} deg from the target at the end"
    return [("target admitted", f"never{where}")]


def _largest_torque(m: dict[str, Any]) -> tuple[str, str]:
    """Return the largest norm; that of a plan has bounds on its components, told of elsewhere."""
    largest = f"{_text(m['max_torque'], 8)} N m"
    if m["replans"] is None:
        return "largest torque", f"{largest}, {_limit(m)}"
    return "largest torque norm", f"{largest}, {_limit(m)}" if m["torque_limit"] else largest


def _plan_rows(m: dict[str, Any]) -> list[tuple[str, str]]:
    if m["replans"] is None:
        return []
    end, more = m["plan_end_time"], m["replans"]
    times = "once" if more == 1 else f"{more} times"
    lost = m["plan_not_found_steps"]
    told = [
        f"at its goal from {end:g} s" if end is not None else "not flown to its end",
        *([f"replanned {times}"] if more else []),
        *([f"no plan found at {lost} steps"] if lost else []),
    ]
    angle, momentum = _text(m["max_plan_error_deg"], 4), _text(m["max_plan_momentum_error"], 4)
    costs = f"{m['plan_cost']:.10g} N^2 m^2 planned, {m['flown_cost']:.10g} flown"
    return [
        ("plan", ", ".join(told)),
        ("cost of the plan", costs),
        ("off the plan", f"{angle} deg and {momentum} N m s at most"),
        *((f"largest {name}", components_text(m, name)) for name in _UNITS),
        *_use_rows(m["bound_use"]),
    ]


def components_text(m: dict[str, Any], name: str) -> str:
    """Return the largest components of ``torque`` or ``momentum``, and their bounds if known."""
    largest = " ".join(_text(value, 5) for value in m["max_components"][name])
    if "lower_bounds" not in m:
        return f"{largest} {_UNITS[name]}"
    sides = [np.array(m[side][name]) for side in ("lower_bounds", "upper_bounds")]
    return f"{largest} {_UNITS[name]}, bounds {bounds_text(sides)}"


def _use_rows(use: dict[str, float]) -> list[tuple[str, str]]:
    """Return the largest share of each bound, of torque and momentum."""
    found = []
    for name in _UNITS:
        shares = {key[-1]: share for key, share in use.items() if key.startswith(name)}
        if shares:
            text = ", ".join(f"{axis} {100.0 * share:.4g} %" for axis, share in shares.items())
            found.append((f"use of {name} bounds", text))
    return found


def _stage_costs(m: dict[str, Any]) -> str:
    """Return the cost; a governor's moving reference makes it none of the way to the target."""
    text = _text(m["cost"], 10)
    return text if text == _NOTHING or m["error_to"] != "target" else f"{text}, to the reference"


def _limit(m: dict[str, Any]) -> str:
    if not m["torque_limit"]:
        return "no limit"
    return f"limit {m['torque_limit']:g} N m, {m['saturated_steps']} steps on it"


def _final_error(m: dict[str, Any]) -> str:
    if m["final_error_deg"] is None:
        return "unknown: the last state or reference was not recorded"
    return f"{m['final_error_deg']:.5g} deg to the {m['error_to']}"


def _solve_times(m: dict[str, Any]) -> str:
    keys = {"solve_time_median": "median", "solve_time_p99": "99 %", "solve_time_max": "longest"}
    if any(m[key] is None for key in keys):
        return _NOTHING
    return ", ".join(f"{m[key] * 1e6:.0f} us {word}" for key, word in keys.items())


def _text(value: float | None, digits: int) -> str:
    return _NOTHING if value is None else f"{value:.{digits}g}"
