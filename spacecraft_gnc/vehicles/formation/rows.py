"""Rows of the summary table of flights in formation."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from spacecraft_gnc.drawing.table import NOTHING, Row, rounded
from spacecraft_gnc.vehicles.formation.flown import Flown
from spacecraft_gnc.vehicles.formation.summary import counts, deadlock_text, kept_text, lost_texts
from spacecraft_gnc.vehicles.formation.telemetry import counts as word_counts


def _counted(name: str) -> Callable[[Flown], str]:
    """Return what tells a metric that counts by name."""
    return lambda run: counts(run.metrics[name]) or NOTHING


def _by_craft(name: str) -> Callable[[Flown], str]:
    """Return what tells a metric that has a number for each craft."""
    return lambda run: ", ".join(
        "unknown" if value is None else rounded(value, 4) for value in run.metrics[name]
    )


def _never(run: Any) -> str:
    return "never" if run.metrics["final_position_error"] is not None else "unknown"


def _unknown(_: Any) -> str:
    return "unknown"


def _nearest_limit(run: Flown) -> str:
    """Return which constraint had the least room, and at how many steps."""
    return counts(word_counts(run.telemetry.constraint)) or NOTHING


def _refused(run: Flown) -> str:
    """Return which constraint kept the governor from the cheapest shifts, likewise."""
    return counts(word_counts(run.telemetry.refused)) or NOTHING


def _deadlocks(run: Flown) -> str:
    return deadlock_text(run.metrics) if run.metrics["deadlocks"] else NOTHING


ROWS: Final = (
    Row("Control steps", "steps"),
    Row("Control period", "period", "s"),
    Row("Duration", "duration", "s", 8),
    Row("Formed (equal shifts, every craft at its place, for good) from step", "formed_at_step",
        absent=_never),
    Row("Farthest craft from its place at the end", "final_position_error", "m", absent=_unknown),
    Row("Constraints", text=lambda run: kept_text(run.metrics)),
    Row("Largest delta-v", "max_delta_v", "m/s", absent=_unknown),
    Row("Its limit", "max_delta_v_limit", "m/s", absent=_unknown),
    Row("Least separation", "min_separation", "m", absent=_unknown),
    Row("Least one allowed", "min_separation_limit", "m", absent=_unknown),
    Row("Largest communication angle", "max_communication_angle_deg", "deg", absent=_unknown),
    Row("Its limit", "max_communication_angle_deg_limit", "deg", absent=_unknown),
    Row("Delta-v of all craft", "total_delta_v", "m/s"),
    Row("Delta-v by craft", unit="m/s", text=_by_craft("craft_delta_v")),
    Row("Largest delta-v by craft", unit="m/s", text=_by_craft("craft_max_delta_v")),
    Row("Least separation by craft", unit="m", text=_by_craft("craft_min_separation")),
    Row("Distance from its place at the end by craft", unit="m",
        text=_by_craft("craft_final_error")),
    Row("Deadlocks", "deadlocks", text=_deadlocks),
    Row("Passages", "passages"),
    Row("Craft lost", "spacecraft_lost",
        text=lambda run: "; ".join(lost_texts(run.metrics)) or NOTHING),
    Row("Steps without admissible shifts", "inadmissible_steps"),
    Row("Governor's answers", text=_counted("answers")),
    Row("Least room along a prediction", "min_margin", "% of the limit", factor=100.0),
    Row("Least room ahead of (steps)", "steps", text=_nearest_limit),
    Row("Cheapest shifts refused for (steps)", "steps", text=_refused),
    Row("Time of the governor, median", "solve_time_median", "ms", factor=1e3),
    Row("Time of the governor, 99 % below", "solve_time_p99", "ms", factor=1e3),
    Row("Time of the governor, longest", "solve_time_max", "ms", factor=1e3),
    Row("Deadlines missed", "missed_deadlines"),
    Row("Steps on a fallback command", "fallback_steps"),
    Row("Incomplete steps", "missing_steps"),
    Row("Command from", text=_counted("sources")),
)  # fmt: skip
