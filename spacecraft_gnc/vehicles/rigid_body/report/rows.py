"""Rows of the summary table."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from spacecraft_gnc.drawing.table import NOTHING, Row
from spacecraft_gnc.vehicles.rigid_body.flown import Flown
from spacecraft_gnc.vehicles.rigid_body.metrics.rows import components_text


def _unknown(_: Flown) -> str:
    return "unknown"


def _never_settled(run: Flown) -> str:
    return "never" if run.metrics["final_error_deg"] is not None else "unknown"


def _never_allowed(run: Flown) -> str:
    return "never" if run.metrics["error_to"] == "target" else NOTHING


def _unpriced(run: Flown) -> str:
    return NOTHING if run.metrics["neighboring_share"] is None else "unknown"


def _of_scenario(text: str) -> Callable[[Flown], str]:
    """Return what says ``text`` where the scenario is known, and is without it."""
    return lambda run: "unknown" if run.scenario is None else text


def _sources(run: Flown) -> str:
    counts = run.metrics["sources"].items()
    return ", ".join(f"{name.lower().replace('_', ' ')} {count}" for name, count in counts)


def _never_ended(run: Flown) -> str:
    return NOTHING if run.metrics["replans"] is None else "not flown to its end"


def _unlimited(run: Flown) -> str:
    if run.scenario is None:
        return "unknown"
    return "none" if run.metrics["replans"] is None else "on components"


def _components(name: str) -> Callable[[Flown], str]:
    """Return what tells the largest components of a planned flight, and their bounds."""

    def text(run: Flown) -> str:
        m = run.metrics
        return NOTHING if m["replans"] is None else components_text(m, name)

    return text


ROWS: Final = (
    Row("Error is the angle to the", text=lambda run: str(run.metrics["error_to"])),
    Row("Control steps", "steps"),
    Row("Control period", "period", "s"),
    Row("Duration", "duration", "s", 8),
    Row("Error at the end", "final_error_deg", "deg", absent=_unknown),
    Row("Error below 5° for good from", "settle_time_5deg", "s", absent=_never_settled),
    Row("Error below 1° for good from", "settle_time_1deg", "s", absent=_never_settled),
    Row("Error below 0.1° for good from", "settle_time_0.1deg", "s", absent=_never_settled),
    Row("Momentum at the end", "final_momentum", "N m s", absent=_unknown),
    Row("Whole way allowed from", "alpha_one_time", "s", absent=_never_allowed),
    Row("Last reference to the target", "final_reference_error_deg", "deg"),
    Row("Steps without an admissible reference", "inadmissible_steps"),
    Row("Least governor margin", "min_governor_margin"),
    Row("Largest torque, norm", "max_torque", "N m", 8, absent=_unknown),
    Row("Torque limit", "torque_limit", "N m", 8, absent=_unlimited),
    Row("Steps on the limit", "saturated_steps", absent=_of_scenario(NOTHING)),
    Row("Sum of stage costs", "cost", "", 8, absent=_of_scenario(NOTHING)),
    Row("Plans taken after the first", "replans"),
    Row("Last plan ends at", "plan_end_time", "s", absent=_never_ended),
    Row("Planned cost, sum of |u|²/2", "plan_cost", "N² m²", 8),
    Row("Flown cost, the same", "flown_cost", "N² m²", 8),
    Row("Largest error off the plan", "max_plan_error_deg", "deg"),
    Row("Largest momentum off the plan", "max_plan_momentum_error", "N m s"),
    Row("Largest torque x, y, z", "replans", text=_components("torque")),
    Row("Largest momentum x, y, z", "replans", text=_components("momentum")),
    Row("Largest use of a bound", "max_bound_use", "%", 5, 100.0),
    Row("Steps without a new plan that was sought", "plan_not_found_steps"),
    Row("Least zone margin", "min_zone_margin_deg", "deg", absent=_of_scenario(NOTHING)),
    Row("Iterations a solve, median", "iterations_median"),
    Row("Iterations a solve, most", "iterations_max"),
    Row("Solve time, median", "solve_time_median", "µs", 4, 1e6),
    Row("Solve time, 99 %", "solve_time_p99", "µs", 4, 1e6),
    Row("Solve time, longest", "solve_time_max", "µs", 4, 1e6),
    Row("Deadlines missed", "missed_deadlines"),
    Row("Solves not converged", "unconverged_steps"),
    Row("Steps at a standstill", "stalled_steps"),
    Row("Steps escaping from a standstill", "escaping_steps"),
    Row("Steps on a fallback torque", "fallback_steps"),
    Row("Steps answered by neighboring extremals", "neighboring_share", "%", 4, 100.0),
    Row("Largest error of those", "neighboring_error", "N m", absent=_unpriced),
    Row("Incomplete steps", "missing_steps"),
    Row("Torque from", text=_sources),
)
