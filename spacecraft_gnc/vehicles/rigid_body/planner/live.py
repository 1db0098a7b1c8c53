"""Live view of a planned flight: phase, distance from the plan and use of its bounds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from spacecraft_gnc.drawing.live import INK, Panel, Readout, Series, number, small
from spacecraft_gnc.governors.planned.report import Phase
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.planner.series import LEAST_DEG, bounds_of, phase_name
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

FIELDS: Final = {"plan_step": "plan_status/plan_step"}
"""Values of a row beside the columns of a flight -> field of a message."""
HISTORY: Final = ("plan_error_deg", "plan_torque", "plan_phase")
_PHASES: Final = {
    phase_name(Phase.FLYING): "#58aef0",
    phase_name(Phase.ARRIVED): "#2fc79b",
    phase_name(Phase.REPLANNING): "#f2b134",
    phase_name(Phase.NOT_FOUND): "#f0554a",
}
"""Color of each phase, on a dark page."""
_MOODS: Final = {phase_name(Phase.REPLANNING): "warn", phase_name(Phase.NOT_FOUND): "bad"}
_TOUCHING: Final = 1.0 + 1e-6  # share of a bound from which it counts as exceeded


def real_bounds(scenario: Scenario) -> Array | None:
    """Return the bounds (4, 3) that a flight of plans must keep; None where none is flown."""
    bounds = bounds_of(scenario)
    return None if bounds is None else bounds.real


def common(sides: Array) -> float:
    """Return the size of bounds (2, 3) that are the same on all axes and sides; else 0."""
    size = np.unique(np.abs(sides))
    return float(size[0]) if size.size == 1 and math.isfinite(size[0]) else 0.0


def panels(bounds: Array) -> list[Panel]:
    """Return the charts of a flight of plans, within bounds (4, 3)."""
    return [
        Panel(
            kind="strip", name="plan_torque", title="Planned torque", unit="N m",
            series=[Series("plan_torque", "xyz")], limit=common(bounds[:2]),
        ),
        Panel(
            kind="strip", name="plan_error", title="Error off the plan", unit="deg", log=True,
            series=[Series("plan_error_deg", ["to plan"], INK)],
        ),
        Panel(
            kind="band", name="plan", title="Plan", series=[Series("plan_phase")], colors=_PHASES,
        ),
    ]  # fmt: skip


def values(row: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is shown of a step along a plan; ``plan`` is -1 where none is flown."""
    plan, phase, error = (row.get(name) for name in ("plan", "plan_phase", "plan_error"))
    error_deg = math.nan if error is None else math.degrees(error)
    planned = row.get("plan_momentum")
    momentum, torque, bounds = row.get("momentum"), row.get("torque"), constants.get("bounds")
    return {
        "plan": -1 if plan is None else int(plan),
        "plan_phase": phase_name(-1 if phase is None else int(phase)),
        "plan_step": row.get("plan_step"),
        "plan_error_deg": max(LEAST_DEG, error_deg) if math.isfinite(error_deg) else math.nan,
        "plan_torque": row.get("plan_torque"),
        "plan_momentum_error": math.nan
        if planned is None or momentum is None
        else float(np.linalg.norm(momentum - planned)),
        "torque_use": math.nan if bounds is None else _use(torque, bounds[:2]),
        "momentum_use": math.nan if bounds is None else _use(momentum, bounds[2:]),
    }


def readouts(values: Mapping[str, Any]) -> Iterator[Readout]:
    """Yield the lines about the plan."""
    if values.get("plan", -1) < 0:
        return
    yield Readout("plan", f"{values['plan']}")
    yield Readout("phase", values["plan_phase"], _MOODS.get(values["plan_phase"], ""))
    step = values["plan_step"]
    yield Readout("plan step", "" if step is None else f"{int(step)}")
    yield Readout("off the plan", f"{small(values['plan_error_deg'])}°")
    off = small(values["plan_momentum_error"])
    yield Readout("momentum off it", off and f"{off} N m s")
    for name in ("torque", "momentum"):
        share = values[f"{name}_use"]
        mood = "bad" if share > _TOUCHING else ""
        yield Readout(f"{name} used", number(100.0 * share, 4, " %"), mood)


def line(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield a few words about the plan, for logs."""
    if values.get("plan", -1) >= 0:
        off = f"{values['plan_error_deg']:.3g} deg off it"
        yield f"plan {values['plan']} {values['plan_phase']}, {off}"


def _use(value: Array | None, sides: Array) -> float:
    """Return the largest share of bounds (2, 3) that a vector uses; NaN: none, or not known."""
    if value is None or not np.isfinite(sides).any() or not np.isfinite(value).all():
        return math.nan
    return float(max(0.0, np.max(value / sides)))
