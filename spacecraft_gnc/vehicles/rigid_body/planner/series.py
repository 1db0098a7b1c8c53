"""Time series of planned flights, shared by metrics and figures."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.marks import Mark
from spacecraft_gnc.drawing.sources import Stretch
from spacecraft_gnc.governors.planned.report import Phase
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.planner.plan import AXES
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import planned_limits, plans, real_limits

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

PHASES: Final = {
    Phase.FLYING: "flying",
    Phase.ARRIVED: "arrived",
    Phase.REPLANNING: "replanning",
    Phase.NOT_FOUND: "not found",
}
"""What becomes of a plan, in words."""
_COLORS: Final = {
    Phase.FLYING: style.AXIS_COLORS[0],
    Phase.ARRIVED: style.AXIS_COLORS[2],
    Phase.REPLANNING: style.RUN_COLORS[4],
    Phase.NOT_FOUND: style.LIMIT_COLOR,
}
LEAST_DEG: Final = 1e-6
"""Least error off a plan that is drawn: on the plan, rounding errors remain."""
_LEAST_SHARE: Final = 1e-4


class Bounds(NamedTuple):
    """Bounds of a planned flight: (4, 3), lower and upper torque [N m] and momentum [N m s]."""

    real: Array
    """That the flight must keep."""
    planned: Array
    """That the plan keeps: with a reserve for the tracking."""


class DrawnBound(NamedTuple):
    """A bound as a line in a diagram."""

    value: float
    """In the unit of the diagram."""
    text: str
    """Empty where the line of the other side says it."""
    is_real: bool
    """Else it is what the plan keeps."""


def is_planned(flight: Flight) -> bool:
    """Tell whether any step was flown along a plan."""
    return bool((flight.plan >= 0).any())


def bounds_of(scenario: Scenario | None) -> Bounds | None:
    """Return the bounds of a scenario; None where nothing is planned, or it is not known."""
    if scenario is None or not plans(scenario):
        return None
    return Bounds(real_limits(scenario), planned_limits(scenario))


def drawn_bounds(bounds: Bounds, row: int, unit: style.Unit) -> list[DrawnBound]:
    """Return the bounds of rows ``row`` (lower) and ``row`` + 1 as lines, each value once.

    The planned ones too where they keep a reserve.
    """
    found = []
    kinds = {"bound": bounds.real, "planned bound": bounds.planned}
    for what, limits in kinds.items():
        if what != "bound" and np.array_equal(bounds.real, bounds.planned):
            continue
        sides = limits[row : row + 2]
        for value in np.unique(sides[np.isfinite(sides)])[::-1].tolist():
            axes = _bounded_by(value, sides)
            two_sided = axes == _bounded_by(-value, sides)
            text = f"{what} {'±' if two_sided else ''}{unit.factor * value:g} {unit.label}"
            text += "" if axes == AXES else f", {axes}"
            is_named = value > 0.0 or not two_sided
            found.append(DrawnBound(unit.factor * value, text if is_named else "", what == "bound"))
    return found


def _bounded_by(value: float, sides: Array) -> str:
    """Return the axes of which a value is a bound; ``sides`` (2, 3)."""
    return "".join(axis for axis, each in zip(AXES, sides.T, strict=True) if value in each)


def bound_use(flight: Flight, real: Array) -> dict[str, float]:
    """Return the largest share of each bound (4, 3) that a flight used, by ``torque x``, ...

    Of a component with bounds to both sides it is the larger share. Components without a bound, and
    those of which nothing is known, are left out.
    """
    found = {}
    for name, values, (low, high) in (
        ("torque", flight.torque, real[:2]),
        ("momentum", series.momenta(flight), real[2:]),
    ):
        shares = np.maximum(values / low, values / high)
        for i, axis in enumerate(AXES):
            known = shares[np.isfinite(shares[:, i]), i]
            if known.size and np.isfinite([low[i], high[i]]).any():
                found[f"{name} {axis}"] = max(0.0, float(known.max()))
    return found


def planned_momenta(flight: Flight) -> Array:
    """Return (n + 1, 3) planned momenta [N m s]; NaN where nothing is planned, as of the end."""
    return np.concatenate([flight.plan_momentum, np.full((1, 3), np.nan)])


def plan_error_deg(flight: Flight) -> Array:
    """Return (n,) angles from the planned attitude to the attitude [deg]."""
    return np.asarray(np.degrees(flight.plan_error))


def drawn_error_deg(flight: Flight) -> Array:
    """Return `plan_error_deg` for a logarithmic scale, no less than `LEAST_DEG`.

    Nor less than a share of the largest one.
    """
    error = plan_error_deg(flight)
    least = max(LEAST_DEG, _LEAST_SHARE * float(np.nanmax(error, initial=0.0)))
    return np.asarray(np.maximum(error, least))


def plan_marks(flight: Flight) -> list[Mark]:
    """Return when each of several plans was taken, when none was found, and when one ended."""
    known = np.flatnonzero(flight.plan >= 0).tolist()
    numbers = flight.plan[known]
    found = [_taken(flight, known[0])] if len(known) and np.ptp(numbers) else []
    for before, k in pairwise(known):
        time, phase = float(flight.time[k]), int(flight.plan_phase[k])
        if flight.plan[k] != flight.plan[before]:
            found.append(_taken(flight, k))
        if phase != flight.plan_phase[before] and phase in _MARKED:
            found.append(Mark(time, *_MARKED[phase]))
    return found


def _taken(flight: Flight, step: int) -> Mark:
    number = int(flight.plan[step])
    name = f"{_ORDINALS[number]} plan" if number < len(_ORDINALS) else f"plan number {number}"
    return Mark(float(flight.time[step]), name, style.INK)


_ORDINALS: Final = ("first", "second", "third", "fourth", "fifth")
"""Of the numbers of plans, which begin with 0."""
_MARKED: Final = {
    int(Phase.ARRIVED): ("plan ends", style.MUTED),
    int(Phase.NOT_FOUND): ("no plan found", style.LIMIT_COLOR),
}


def phase_stretches(flight: Flight, times: Array) -> list[Stretch]:
    """Return the stretches of one phase, in order; ``times`` (n + 1,) of the states [s]."""
    phase = flight.plan_phase
    begins = np.flatnonzero(np.append(True, phase[1:] != phase[:-1])).tolist()
    ends = [*begins[1:], len(phase)]
    return [
        Stretch(int(phase[begin]), float(times[begin]), float(times[end]), end - begin)
        for begin, end in zip(begins, ends, strict=True)
    ]


def phase_name(phase: int) -> str:
    """Return what becomes of a plan, in words."""
    return PHASES[Phase(phase)] if phase >= 0 else "no plan"


def phase_color(phase: int) -> str:
    """Return the color of a phase."""
    return _COLORS[Phase(phase)] if phase >= 0 else style.MUTED
