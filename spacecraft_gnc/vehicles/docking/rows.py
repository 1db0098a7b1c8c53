"""Rows of the summary table of docking flights."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from spacecraft_gnc.drawing.table import NOTHING, Row
from spacecraft_gnc.vehicles.docking.flown import Flown
from spacecraft_gnc.vehicles.docking.summary import counts, kept_text, lost_texts


def _counted(name: str) -> Callable[[Flown], str]:
    """Return what tells a metric that counts by name."""
    return lambda run: counts(run.metrics[name]) or NOTHING


def _never(run: Any) -> str:
    return "never" if run.metrics["final_offset"] is not None else "unknown"


def _unknown(_: Any) -> str:
    return "unknown"


def _held_back(run: Flown) -> str:
    """Return which constraints kept the reference from the target, and at how many steps."""
    return counts(run.telemetry.counts()) or NOTHING


ROWS: Final = (
    Row("Control steps", "steps"),
    Row("Control period", "period", "s"),
    Row("Duration", "duration", "s", 8),
    Row("Docked (2 cm and 1 deg for good) from", "docked_at", "s", absent=_never),
    Row("Ports apart at the end", "final_offset", "m", absent=_unknown),
    Row("Angle at the end", "final_angle_deg", "deg", absent=_unknown),
    Row("Speed of the port at the end", "final_speed", "m/s", absent=_unknown),
    Row("Constraints", text=lambda run: kept_text(run.metrics)),
    Row("Largest component of the force", "max_force", "N"),
    Row("Its limit", "max_force_limit", "N", absent=_unknown),
    Row("Largest component of the moment", "max_moment", "N m"),
    Row("Its limit", "max_moment_limit", "N m", absent=_unknown),
    Row("Least line-of-sight margin", "min_line_of_sight_margin", "m"),
    Row("Least clearance", "min_clearance", "m"),
    Row("Clearance allowed", "min_clearance_limit", "m", absent=_unknown),
    Row("Impulse of the force", "impulse", "N s"),
    Row("Change of velocity", "delta_v", "m/s"),
    Row("Steps with the reference short of the target", "governed_share", "%", factor=100.0),
    Row("Reference at the target from", "reference_settled_at", "s"),
    Row("Kept from it by (steps)", "steps", text=_held_back),
    Row("Steps without an admissible reference", "inadmissible_steps"),
    Row("Governor's answers", text=_counted("answers")),
    Row("Phases", text=_counted("phases")),
    Row("Thruster lost", "thruster_lost",
        text=lambda run: "; ".join(lost_texts(run.metrics)) or NOTHING),
    Row("From the hold point at the end", "hold_distance", "m"),
    Row("Time of the governor, median", "solve_time_median", "ms", factor=1e3),
    Row("Time of the governor, 99 % below", "solve_time_p99", "ms", factor=1e3),
    Row("Time of the governor, longest", "solve_time_max", "ms", factor=1e3),
    Row("Deadlines missed", "missed_deadlines"),
    Row("Steps on a fallback command", "fallback_steps"),
    Row("Incomplete steps", "missing_steps"),
    Row("Command from", text=_counted("sources")),
)  # fmt: skip
