"""A plan in words: its summary, and the conditions that it satisfies."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.planner.plan import AXES, Plan

UNITS: Final = {"torque": "N m", "momentum": "N m s"}
_TOLERANCE: Final = 1e-8
_FEWEST: Final = 2  # control steps of a transfer
_CONDITIONS: Final = {
    "momentum": "momentum, from a roll-out of the torque",
    "end_attitude": "attitude at the end [rad]",
    "end_momentum": "momentum at the end",
    "torque": "stationarity of the torque, (3.13)",
    "co_momentum": "co-momentum, (4.11)",
    "bounds": "bounds on torque and momentum",
    "slackness": "signs of the multipliers, and where they act",
}


def summary_rows(m: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the lines of a plan's summary, label and text, from its numbers."""
    least = f"{m['min_curvature']:.3g}"
    return [
        ("transfer", _transfer(m)),
        *_bounds(m, "torque", m["reserves"][0]),
        *_bounds(m, "momentum", m["reserves"][1]),
        ("status", m["status"]),
        ("cost", f"{m['cost']:.10g} N^2 m^2, sum of |u|^2 / 2 over the steps"),
        ("", f"{m['cost_integral']:.10g} N^2 m^2 s, the integral: cost times {m['period']:g} s"),
        ("largest torque", f"{_vector(m['max_torque'])} N m"),
        ("largest momentum", f"{_vector(m['max_momentum'])} N m s"),
        ("residual", f"{m['residual']:.2g}, relative; {m['iterations']} Newton steps"),
        (
            "second order",
            f"least eigenvalue of the reduced Hessian: {least} or more",
        ),
        ("", "(above 0 at a minimum; 1 where the motion is linear)"),
        *_labeled("active bounds", active_texts(m) or ["none"]),
        *_labeled("starts tried", list(_tried(m))),
        *_labeled("shortest time", list(_shortest(m))),
    ]


def active_texts(m: dict[str, Any]) -> list[str]:
    """Return each bound that acts, and when, in words."""
    h = m["period"]
    return [
        f"{one['bound']} {one['axis']} = {one['value']:g} {UNITS[one['bound']]}, "
        f"steps {one['first']} to {one['last']} "
        f"({one['first'] * h:g} to {_end(one) * h:g} s)"
        for one in m["active"]
    ]


def bounds_text(bounds: list[Array]) -> str:
    """Return bounds in words: ``+-20``, ``-1 to 2`` by axis, or ``none``."""
    texts = [_pair(float(low), float(high)) for low, high in zip(*bounds, strict=True)]
    return texts[0] if len(set(texts)) == 1 else f"x {texts[0]}, y {texts[1]}, z {texts[2]}"


def checks(plan: Plan) -> tuple[tuple[str, str, str, str, str], ...]:
    """Return each condition with steps, residual, tolerance and verdict."""
    solution = plan.solution
    rows = [
        (
            _CONDITIONS[name],
            "-" if name.startswith("end") else str(plan.n_steps),
            f"{value:.3g}",
            f"{_TOLERANCE:g}",
            "passed" if value <= _TOLERANCE else "failed",
        )
        for name, value in solution.residuals._asdict().items()
    ]
    curvature = solution.min_curvature
    verdict = "passed" if curvature > 0.0 else "failed"
    least = ("reduced Hessian, least eigenvalue", "-", f"{curvature:.3g}", "> 0", verdict)
    return (*rows, least)


def _transfer(m: dict[str, Any]) -> str:
    steps = f"{m['steps']} control steps of {m['period']:g} s"
    return f"{m['angle_deg']:.6g} deg in {m['duration']:.6g} s, {steps}"


def _bounds(m: dict[str, Any], name: str, reserve: float) -> Iterator[tuple[str, str]]:
    text = bounds_text(m[f"{name}_bounds"])
    yield f"{name} bounds", "none" if text == "none" else f"{text} {UNITS[name]}"
    if reserve > 0.0 and text != "none":
        yield "", f"(already less the reserve of {100.0 * reserve:g} %)"


def _pair(low: float, high: float) -> str:
    if math.isinf(low) and math.isinf(high):
        return "none"
    if math.isinf(low):
        return f"at most {high:g}"
    if math.isinf(high):
        return f"at least {low:g}"
    return f"+-{high:g}" if low == -high else f"{low:g} to {high:g}"


def _end(one: dict[str, Any]) -> int:
    """Return the step at whose start a bound ceases: a torque holds over its last one."""
    return int(one["last"]) + int(one["bound"] == "torque")


def _vector(values: Array) -> str:
    return ", ".join(f"{axis} {value:.6g}" for axis, value in zip(AXES, values, strict=True))


def _tried(m: dict[str, Any]) -> Iterator[str]:
    for one in m["tried"]:
        cost = f", cost {one['cost']:.10g}" if one["status"] == "converged" else ""
        count = one["iterations"]
        steps = f", {count} Newton steps" if count else ", not followed"
        yield f"{one['start']}: {one['status']}{cost}{steps}"


def proves_a_time(m: dict[str, Any]) -> bool:
    """Tell whether a time is proven too short: more than the two steps that every plan has."""
    return bool(m["shortest_possible"] > (_FEWEST + 0.5) * m["period"])


def _shortest(m: dict[str, Any]) -> Iterator[str]:
    if m["is_shortest"] and m["steps"] > _FEWEST:
        yield f"this one: no plan was found in {m['duration'] - m['period']:.6g} s"
    elif m["is_shortest"]:
        yield "this one: no plan has fewer steps"
    if proves_a_time(m):
        yield f"no torque within the bounds makes it in less than {m['shortest_possible']:.6g} s"


def _labeled(label: str, texts: list[str]) -> list[tuple[str, str]]:
    return [("" if i else label, text) for i, text in enumerate(texts)]
