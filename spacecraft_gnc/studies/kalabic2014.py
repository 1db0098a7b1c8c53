"""Kalabic et al. 2014, section V: reference governor, terminal-set NMPC, half a turn.

The paper prints neither the start nor a figure: it has plots and statements. The start (57 deg
about (0.8, 0.6, 0), at rest) and the expected figures come from an independent implementation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.loop import Flight
from spacecraft_gnc.studies.flights import Flown, fly
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.report import Check, Report, Table, seconds, times
from spacecraft_gnc.studies.speed import machine, machine_line
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.metrics.summary import settle_time

NAME: Final = "kalabic2014"
TITLE: Final = (
    "Kalabic, Gupta, Di Cairano, Bloch, Kolmanovsky (ACC 2014): reference governor and NMPC on "
    "SO(3), section V"
)
GOVERNED: Final = "governed"
UNGOVERNED: Final = "ungoverned"
NMPC: Final = "NMPC"
FLIP_PLUS: Final = "half a turn, pi"
FLIP_MINUS: Final = "half a turn, -0.99 pi"
OVER_NMPC: Final = "governor over NMPC"
ALONE: Final = "NMPC alone"
PARKED: Final = "NMPC alone, no escape"
_ALONE: Final = "reference_governor.governor=none"
_HORIZON: Final = "reference_governor.prediction_horizon={}"
FLIGHTS: Final = {
    GOVERNED: ("kalabic2014_governor", ()),
    UNGOVERNED: ("kalabic2014_ungoverned", ()),
    "governed, 60 steps": ("kalabic2014_governor", (_HORIZON.format(60),)),
    "governed, 50 steps": ("kalabic2014_governor", (_HORIZON.format(50),)),
    "governed, 20 steps": ("kalabic2014_governor", (_HORIZON.format(20),)),
    "governed, coarse": (
        "kalabic2014_governor",
        (_HORIZON.format(100), "reference_governor.alpha_tolerance=0.01"),
    ),
    NMPC: ("kalabic2014_nmpc", ()),
    FLIP_PLUS: ("kalabic2014_flip_plus", ()),
    FLIP_MINUS: ("kalabic2014_flip_minus", ()),
    OVER_NMPC: ("governed_nmpc", ()),
    ALONE: ("governed_nmpc", (_ALONE,)),
    PARKED: ("governed_nmpc", (_ALONE, "nmpc_controller.standstill_error_deg=0.0")),
}
"""Name -> scenario, and what is laid over it."""
LIMIT: Final = 0.02  # (34) [N m]
INCLUSION: Final = 0.5  # (33)


@dataclass(slots=True)
class Flights:
    """Every flight of the paper, by name."""

    by_name: dict[str, Flown] = field(default_factory=dict)

    def of(self, name: str) -> Flight:
        """Return a flight."""
        return self.by_name[name].trajectory


def run(options: Options) -> Report:
    """Fly the cases; return the report."""
    flights = Flights(
        {
            name: fly(scenario, overrides, repeats=1, progress=options.progress)
            for name, (scenario, overrides) in FLIGHTS.items()
        }
    )
    groups = (_governor, _short_predictions, _nmpc, _flip, _over_nmpc)
    checks = [check for group in groups for check in group(flights)]

    tables = [_statements(flights), _side_by_side(flights), _times(flights)]
    return Report(NAME, TITLE, tables, checks, _values(flights), (flights,))


def error_deg(flight: Flight) -> Array:
    """Return (n + 1,) angles from the target, the identity, to the attitude [deg]."""
    return np.degrees(lie.angles_between(series.attitudes(flight), np.eye(3)))


def inclusion(flight: Flight) -> Array:
    """Return (n + 1,) C_33, the cosine that (33) bounds."""
    return series.attitudes(flight)[:, 2, 2]


def first_time_admitted(flight: Flight) -> float:
    """Return the time at which the governor first admits the target itself [s]; NaN: never."""
    admitted = np.flatnonzero(flight.alpha == 1.0)
    return float(flight.time[admitted[0]]) if admitted.size else math.nan


def _settled(flight: Flight, threshold: float) -> float:
    time = settle_time(series.state_times(flight), error_deg(flight), threshold)
    return math.nan if time is None else time


def _largest_torque(flight: Flight) -> float:
    return float(series.torque_norm(flight).max())


def _governor(flights: Flights) -> list[Check]:
    governed, ungoverned = flights.of(GOVERNED), flights.of(UNGOVERNED)
    largest, cosine = _largest_torque(governed), float(inclusion(governed).min())
    return [
        Check("governor: alpha at the first step", 0.043, float(governed.alpha[0]), 5e-4),
        Check("governor: alpha = 1 from", 60.5, first_time_admitted(governed), 0.3, "s"),
        Check("governor: under 1 deg for good from", 75.1, _settled(governed, 1.0), 0.3, "s"),
        Check("governor: under 0.1 deg for good from", 93.3, _settled(governed, 0.1), 0.3, "s"),
        Check("governor: largest |T|", 0.01999, largest, 1.1e-5, "N m"),
        Check("governor: |T| beyond 0.02", 0.0, max(0.0, largest - LIMIT), 0.0, "N m"),
        Check("governor: smallest C33", 0.5446, cosine, 5e-4),
        Check("governor: C33 below 0.5", 0.0, max(0.0, INCLUSION - cosine), 0.0),
        Check("ungoverned: largest |T|", 0.392, _largest_torque(ungoverned), 2e-3, "N m"),
    ]


def _short_predictions(flights: Flights) -> list[Check]:
    """Check what becomes of a horizon that does not suffice, and of a coarse bisection."""
    coarse = flights.of("governed, coarse")
    before = coarse.alpha[: max(1, int(np.argmax(coarse.alpha == 1.0)))]
    idle = float((before == 0.0).mean())
    # Of 50 steps the excess hangs on the last bits of alpha: 0.020 to 0.024 for 49 to 55.
    expected = {60: (0.02, 2e-5), 50: (0.0232, 1e-3), 20: (0.051, 1e-3)}
    checks = [
        Check(
            f"{steps} predicted steps: largest |T|",
            torque,
            _largest_torque(flights.of(f"governed, {steps} steps")),
            tolerance,
            "N m",
        )
        for steps, (torque, tolerance) in expected.items()
    ]
    return [*checks, Check("bisection to 0.01: share of steps with alpha 0", 0.5, idle, 0.2)]


def _nmpc(flights: Flights) -> list[Check]:
    flight = flights.of(NMPC)
    largest = _largest_torque(flight)
    return [
        Check("NMPC: under 5 deg for good from", 56.2, _settled(flight, 5.0), 0.3, "s"),
        Check("NMPC: under 1 deg for good from", 87.1, _settled(flight, 1.0), 0.3, "s"),
        Check("NMPC: |T| beyond 0.02", 0.0, max(0.0, largest - LIMIT), 1e-15, "N m"),
        Check("NMPC: steps that failed", 0, int(series.unconverged(flight).sum()), 0),
    ]


def _flip(flights: Flights) -> list[Check]:
    plus, minus = flights.of(FLIP_PLUS), flights.of(FLIP_MINUS)
    return [
        Check("flip: T3(0) from C3(pi)", -12.83, float(plus.torque[0, 2]), 0.005 * 12.83, "N m"),
        Check(
            "flip: T3(0) from C3(-0.99 pi)", 12.71, float(minus.torque[0, 2]), 0.005 * 12.71, "N m"
        ),
        Check("flip: error at the end, C3(pi)", 0.0, float(error_deg(plus)[-1]), 1.0, "deg"),
        Check("flip: error at the end, C3(-0.99 pi)", 0.0, float(error_deg(minus)[-1]), 1.0, "deg"),
    ]


def _over_nmpc(flights: Flights) -> list[Check]:
    """Check the governor over the NMPC of Gupta et al. 2015, and that it is needed."""
    governed, alone, parked = (flights.of(name) for name in (OVER_NMPC, ALONE, PARKED))
    margin = _zone_margin(flights.by_name[OVER_NMPC])
    return [
        Check("over NMPC: depth in the zone", 0.0, max(0.0, -float(margin.min())), 0.0, "deg"),
        Check("over NMPC: error at 300 s", 0.0, float(error_deg(governed)[-1]), 0.1, "deg"),
        Check("over NMPC: |T| beyond 0.01", 0.0, _largest_torque(governed) - 0.01, 1e-8, "N m"),
        Check("NMPC alone: depth in the zone", 14.4, -_deepest(flights, ALONE), 0.1, "deg"),
        Check("NMPC alone: error at 300 s", 0.0, float(error_deg(alone)[-1]), 0.1, "deg"),
        Check("NMPC alone, no escape: parks at", 57.97, float(error_deg(parked)[-1]), 0.01, "deg"),
    ]


def _zone_margin(flown: Flown) -> Array:
    """Return (n + 1,) angles left to the border of the flight's one zone [deg]."""
    (zone,) = flown.scenario.controller.zones
    return series.zone_margin_deg(flown.trajectory, zone)


def _deepest(flights: Flights, name: str) -> float:
    return float(_zone_margin(flights.by_name[name]).min())


def _side_by_side(flights: Flights) -> Table:
    header = ("a zone across the way", "least angle to it", "error at the end", "< 0.1 deg from",
              "largest |T|")  # fmt: skip
    rows = [
        (
            name,
            f"{_deepest(flights, name):.2f} deg",
            f"{error_deg(flights.of(name))[-1]:.2g} deg",
            f"{_settled(flights.of(name), 0.1):.1f} s".replace("nan s", "never"),
            f"{_largest_torque(flights.of(name)):.6f} N m",
        )
        for name in (OVER_NMPC, ALONE, PARKED)
    ]
    notes = ["config/governed_nmpc.yaml: the spacecraft of Gupta et al. 2015, not in the paper."]
    return Table("Beyond the paper: the governor over an NMPC", header, rows, notes)


def _statements(flights: Flights) -> Table:
    governed, nmpc = flights.of(GOVERNED), flights.of(NMPC)
    plus, minus = flights.of(FLIP_PLUS), flights.of(FLIP_MINUS)
    torque = np.linalg.norm(governed.torque, axis=1)
    clear = math.degrees(math.acos(INCLUSION) - math.acos(inclusion(governed).min()))
    apart = float(np.corrcoef(plus.torque[:, 2], minus.torque[:, 2])[0, 1])
    signs = f"T3(0) {plus.torque[0, 2]:.2f} and {minus.torque[0, 2]:.2f} N m"
    settled = [f"{_settled(flight, 1.0):.1f} s" for flight in (nmpc, governed)]
    rows = [
        ("governor: constraints enforced", f"largest |T| {torque.max():.6f} N m of {LIMIT}"),
        ("governor: control limit alone active", f"zone never nearer than {clear:.2f} deg"),
        ("governor: modifies the reference until the target is admissible",
         f"alpha < 1 until {first_time_admitted(governed):.1f} s, then 1"),
        ("NMPC: constraint (34) kept", f"largest |T| {_largest_torque(nmpc):.6f} N m"),
        ("NMPC: target achieved", f"{error_deg(nmpc)[-1]:.2g} deg at the end"),
        ("NMPC: similar to the governor's", f"under 1 deg from {' and '.join(settled)}"),
        ("flip: almost opposite in sign", f"{signs}, correlation {apart:.3f}"),
    ]  # fmt: skip
    notes = [
        "NMPC: N = 5 with terminal_set: without_kappa; as printed it is infeasible from this start",
        "(`gnc simulate` with nmpc_controller.terminal_set=true says so; docs/terminal_set.md).",
    ]
    return Table("The paper's statements", ("paper", "ours"), rows, notes)


def _times(flights: Flights) -> Table:
    header = ("wall time of a step", "median", "longest", "total")
    rows = []
    for name in (GOVERNED, UNGOVERNED, NMPC, FLIP_PLUS, OVER_NMPC):
        flown = flights.by_name[name]
        for what, row in (("decision", flown.decision_times), ("command", flown.step_times)):
            t = times(row)
            cells = [seconds(t[key]) for key in ("median", "max", "total")]
            rows.append([f"{name}: {what}", *cells])
    notes = ["The paper prints no times.", "This machine: " + machine_line()]
    return Table("What it costs", header, rows, notes)


def _values(flights: Flights) -> dict[str, Any]:
    rows = {
        name: {
            "decisions": times(flown.decision_times),
            "commands": times(flown.step_times),
            "metrics": summarize(flown.trajectory, flown.scenario),
        }
        for name, flown in flights.by_name.items()
    }
    return {"machine": machine(), "flights": rows}
