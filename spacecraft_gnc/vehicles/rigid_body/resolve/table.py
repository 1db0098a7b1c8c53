"""Rows of the comparison's table."""

from __future__ import annotations

from typing import Any, Final

_MOTION: Final = "the motion of the plans that flew, tracked"
_COUNTS: Final = 1e-3  # share of the largest difference of the costs


def sides(old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return the rows of a table: what it is, as flown, as replayed."""
    return [
        ("method", old["method"], new["method"]),
        ("largest torque", _number(old["max_torque"], "N m"), _number(new["max_torque"], "N m")),
        ("iterations a solve", _iterations(old), _iterations(new)),
        ("largest residual", _number(old["residual_max"]), _number(new["residual_max"])),
        ("time a solve", _time(old), _time(new)),
        ("steps not solved", _count(old["unconverged_steps"]), _count(new["unconverged_steps"])),
        ("torque from", _sources(old), _sources(new)),
        *_standstills(old, new),
    ]


def _standstills(old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return the rows on standstills away from the target, where either side had one."""
    rows = {"steps at a standstill": "stalled_steps", "standstill escapes": "escaping_steps"}
    return [
        (label, _count(old[name]), _count(new[name]))
        for label, name in rows.items()
        if old[name] or new[name]
    ]


def differences(m: dict[str, Any], period: float) -> list[tuple[str, str]]:
    """Return the rows that hold for both together."""
    steps, same = m["steps"], m["identical_steps"]
    equal = f"{same} of {steps} steps, bit for bit"
    if m["check"] == "exact":
        equal += ": the flight is repeated exactly, as a lockstep flight has to be"
    elif same < steps:
        equal += f"; the first other one at step {m['first_difference']}"
    rows = [("equal torques", equal)]
    if m["tracks_plans"]:
        method = m["replayed"]["method"]
        rows.append(("reference", f"{_MOTION}: {method} keeps no bounds of a plan"))
    torque = _at(m, "torque_difference", "N m", period)
    rows.append(("torque difference", torque))
    if m["cost_difference_max"] is None:
        rows.append(("cost difference", "-, no plans to compare by the recorded problem"))
    elif not _penalties_count(m):
        rows.append(("cost difference", _at(m, "cost_difference", "", period)))
    else:
        without = f"{_at(m, 'plain_cost_difference', '', period)}, without penalties"
        rows += [("cost difference", without), ("penalties", _penalties(m, period))]
    return rows


def _penalties_count(m: dict[str, Any]) -> bool:
    """Tell whether a penalty is so large beside the cost that it would blur the comparison."""
    penalty, plain = m["penalty_max"], m["plain_cost_difference_max"]
    return penalty is not None and plain is not None and penalty > _COUNTS * abs(plain)


def _penalties(m: dict[str, Any], period: float) -> str:
    """Say which plan pays most for leaving a limit of the recorded problem, and by how much."""
    step, torque, zone = (m[f"penalty_{n}"] for n in ("step", "torque_excess", "zone_excess_deg"))
    text = f"{_number(m['penalty_max'])} at the most (step {step}, {step * period:g} s)"
    excess = [f"{torque:.2g} N m above the torque limit"] if torque and torque > 0.0 else []
    excess += [f"{zone:.2g} deg inside a zone"] if zone and zone > 0.0 else []
    which = "the plan as flown" if m["penalty_side"] == "recorded" else "the plan replayed"
    return f"{text}: {which} is {' and '.join(excess)}" if excess else text


def _at(m: dict[str, Any], name: str, unit: str, period: float) -> str:
    step = m[f"{name}_max_step"]
    largest, rms = _number(m[f"{name}_max"], unit), _number(m[f"{name}_rms"], unit)
    if m[f"{name}_rms"] == 0.0:
        return f"{largest} in every step"
    return f"{largest} at the most (step {step}, {step * period:g} s), {rms} rms"


def _number(value: float | None, unit: str = "") -> str:
    return "-" if value is None else f"{value:.6g} {unit}".rstrip()


def _iterations(side: dict[str, Any]) -> str:
    if side["iterations_median"] is None:
        return "-"
    return f"{side['iterations_median']:.3g} median, {side['iterations_max']} most"


def _count(steps: int | None) -> str:
    return "-" if steps is None else str(steps)


def _time(side: dict[str, Any]) -> str:
    median, p99 = side["solve_time_median"], side["solve_time_p99"]
    if median is None:
        return "-"
    return f"{1e6 * median:.0f} us median, {1e6 * p99:.0f} us 99 %"


def _sources(side: dict[str, Any]) -> str:
    return ", ".join(f"{name} {count}" for name, count in side["sources"].items())
