"""Summary of a flight of a spacecraft with wheels, in numbers and in words."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Mode, Rest, Terminal
from spacecraft_gnc.vehicles.two_wheel.metrics import SETTLED_ANGLE, SETTLED_RATE, summarize

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight
    from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario

_BEYOND: Final = 1.0 + 1e-9  # share of a limit: a law may be on it but for rounding


def metrics(flight: WheelFlight, scenario: Scenario | None = None) -> dict[str, Any]:
    """Return the metrics of a flight, ready for JSON.

    Returns
    -------
    dict
        ``steps``, ``missing_steps`` (lost by the recording), ``period`` and ``duration`` [s], those
        of `metrics.summarize`, ``max_wheel_speed_limit`` and ``max_wheel_acceleration_limit`` (None
        where there is none, or no scenario), ``momentum_drift`` (largest change of the total
        momentum [N m s]), ``sources`` (steps by source), ``plans`` (plans found, by what
        they have to end at: names of `Terminal`), ``modes`` (steps by mode),
        ``rest`` (where it can come to rest, at the end: `RESTS`), ``remaining_rate`` [rad/s],
        ``remaining_axis`` (3 numbers, body frame; None: it comes to rest) and
        ``pointing_loss_deg`` of what is held then (of the axis, where it keeps turning),
        ``fallback_steps``,
        ``limits_exceeded`` (none: a wheel saturates), ``acceleration_cut_steps`` where there are
        any (on which a wheel was asked for more than its limit), ``solve_time_median``, ``_p99``,
        ``_max`` [s] (None where nothing is solved).
    """
    n = flight.n_steps
    times, attitude, rate, speed = states(flight)
    known = [flight.attitude.reshape(n, 9), flight.angular_velocity, flight.wheel_acceleration]
    sources = Counter(flight.source.tolist())
    solve_time = flight.solve_time[np.isfinite(flight.solve_time)]
    quantiles = {"median": 0.5, "p99": 0.99, "max": 1.0}
    wheels = [np.vstack([known, known[-1:]]) for known in (flight.healthy, flight.diagnosed)]
    target, modes = flight.target[-1], Counter(flight.mode.tolist())
    ends = Counter(flight.terminal[flight.status == Status.CONVERGED].tolist())
    return {
        "steps": n,
        "missing_steps": int(np.count_nonzero(np.isnan(np.hstack(known)).any(axis=1))),
        "period": float(flight.period),
        "duration": float(times[-1]),
        **summarize(times, attitude, rate, speed, flight.wheel_acceleration, target, *wheels),
        "max_wheel_speed_limit": (scenario and scenario.plant.max_wheel_speed) or None,
        "max_wheel_acceleration_limit": (
            (scenario and scenario.plant.max_wheel_acceleration) or None
        ),
        "momentum_drift": _drift(flight.total_momentum),
        "sources": {_named(source): count for source, count in sorted(sources.items())},
        "plans": {end.name.lower(): ends[end] for end in Terminal if ends[end]},
        **_held(flight),
        "modes": {mode_name(mode): count for mode, count in sorted(modes.items())},
        "fallback_steps": sum(sources[source] for source in Source if source.is_fallback),
        "limits_exceeded": [],
        **_cut(flight, scenario),
        **{
            f"solve_time_{name}": float(np.quantile(solve_time, q)) if solve_time.size else None
            for name, q in quantiles.items()
        },
    }


def _cut(flight: WheelFlight, scenario: Scenario | None) -> dict[str, Any]:
    """Return the steps on which the plant cut a command; nothing where it never did."""
    limit = math.inf if scenario is None else scenario.plant.max_wheel_acceleration or math.inf
    beyond = np.abs(flight.wheel_acceleration) > limit * _BEYOND
    steps = int(np.count_nonzero(beyond.any(axis=1)))
    return {"acceleration_cut_steps": steps} if steps else {}


def states(flight: WheelFlight) -> tuple[Array, Array, Array, Array]:
    """Return times (n + 1,), attitudes, rates and wheel speeds of the states, the last included."""
    end = flight.time[-1] + flight.period
    return (
        np.append(flight.time, end),
        np.concatenate([flight.attitude, flight.final_attitude[None]]),
        np.vstack([flight.angular_velocity, flight.final_angular_velocity]),
        np.vstack([flight.wheel_speed, flight.final_wheel_speed]),
    )


def lines(m: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the lines of a flight's summary, label and text, from its metrics."""
    error, settled = m["final_error_deg"], m["settle_time"]
    rows = [
        ("error at the end", "unknown" if error is None else f"{error:.5g} deg to the target"),
        (
            f"under {SETTLED_ANGLE:g} rad, {SETTLED_RATE:g} rad/s for good",
            "never" if settled is None else f"from {settled:g} s",
        ),
        ("largest wheel speed", _beside_limit(m, "max_wheel_speed", "rad/s")),
        ("largest acceleration", _beside_limit(m, "max_wheel_acceleration", "rad/s^2")),
        ("drift of the momentum", f"{m['momentum_drift']:.2g} N m s"),
        ("command from", counts(m["sources"])),
    ]
    if m["plans"]:
        rows.append(("plans by their end", counts(m["plans"])))
    if any(name != mode_name(Mode.NOMINAL) for name in m["modes"]):
        rows.append(("flown", counts(m["modes"])))
    if m["rest"] not in (None, RESTS[Rest.AT_TARGET]):
        rows.append(("rest", f"{m['rest']}; {_kept(m)}"))
    if m.get("acceleration_cut_steps"):
        text = f"a wheel was asked for more than it can, at {m['acceleration_cut_steps']} of "
        rows.append(("warning", f"{text}{m['steps']} steps"))
    rows += [("wheel lost", text) for text in lost_texts(m)]
    return rows + [("false alarm", text) for text in alarm_texts(m)]


def counts(numbers: dict[str, int]) -> str:
    """Return numbers by name in words."""
    return ", ".join(f"{name} {count}" for name, count in numbers.items())


def lost_texts(m: dict[str, Any]) -> list[str]:
    """Return a line for each wheel lost: which, when, and when it was noticed."""
    found = []
    for loss in m["wheel_losses"]:
        noticed = loss["detected_at"]
        told = "not noticed" if noticed is None else f"noticed at {noticed:g} s"
        found.append(f"{loss['wheel']} at {loss['lost_at']:g} s, {told}")
    return found


def alarm_texts(m: dict[str, Any]) -> list[str]:
    """Return a line for each wheel that was excluded though it answered."""
    return [f"{alarm['wheel']} excluded at {alarm['at']:g} s" for alarm in m["false_alarms"]]


def _kept(m: dict[str, Any]) -> str:
    """Return what is held where rest at the target is impossible."""
    loss = f"{m['pointing_loss_deg']:.4g} deg off"
    if m["remaining_axis"] is None:
        return f"held {loss} the target"
    axis = direction(m["remaining_axis"], " ")
    turns = f"turns at {m['remaining_rate']:.3g} rad/s about body axis ({axis})"
    return f"{turns}, which points {loss} where the target attitude has it"


def direction(axis: Iterable[float], between: str = ", ") -> str:
    """Return a unit vector in words, to three decimals: what is rounding is zero."""
    return between.join(f"{round(part, 3) + 0.0:g}" for part in axis)


def _beside_limit(m: dict[str, Any], name: str, unit: str) -> str:
    value, limit = m[name], m[f"{name}_limit"]
    text = "unknown" if value is None else f"{value:.6g} {unit}"
    return f"{text}, no limit" if limit is None else f"{text}, limit {limit:g} {unit}"


def _drift(momentum: Array) -> float:
    known = momentum[np.isfinite(momentum).all(axis=1)]
    return float(np.linalg.norm(known - known[0], axis=1).max()) if len(known) else 0.0


RESTS: Final = {
    Rest.AT_TARGET: "at the target",
    Rest.ELSEWHERE: "elsewhere only",
    Rest.NOWHERE: "impossible",
}


def _held(flight: WheelFlight) -> dict[str, Any]:
    """Return where it can come to rest at the end, and what is held; None: not known."""
    rest, rate = int(flight.rest[-1]), float(np.linalg.norm(flight.remaining_rate[-1]))
    turns = math.isfinite(rate) and rate > 0.0
    loss = math.degrees(flight.pointing_loss[-1])
    return {
        "rest": RESTS[Rest(rest)] if 0 <= rest < len(Rest) else None,
        "remaining_rate": rate if math.isfinite(rate) else None,
        "remaining_axis": (flight.remaining_rate[-1] / rate).tolist() if turns else None,
        "pointing_loss_deg": loss if math.isfinite(loss) else None,
    }


def mode_name(mode: int) -> str:
    """Return how a spacecraft is flown, in a word; unknown where it is no mode."""
    return Mode(mode).name.lower() if 0 <= mode < len(Mode) else "unknown"


def _named(source: int) -> str:
    known = 0 <= source < len(Source)
    return Source(source).name.lower().replace("_", " ") if known else "unknown"
