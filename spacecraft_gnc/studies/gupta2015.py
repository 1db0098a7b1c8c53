"""Cases I and II of Gupta et al. 2015, with the baselines that the paper measures itself against.

Times are of whole commands (solve, failure ladder, certificate), the baselines' in the same
process and right after ours: the speed-up is of one machine, the paper's total is of another.
The expected figures were found by independent solvers (docs/solver.md); the paper has times and
pictures only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.loop import Flight
from spacecraft_gnc.ocp import ShootingOptions, ShootingSolver
from spacecraft_gnc.ocp.linearization import linearize
from spacecraft_gnc.studies.flights import (
    REPEATS,
    Flown,
    Progress,
    apart_deg,
    fly,
)
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.report import NONE, Check, Report, Table, seconds, times
from spacecraft_gnc.studies.speed import machine, machine_line
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of
from spacecraft_gnc.vehicles.rigid_body.series import attitudes

NAME: Final = "gupta2015"
TITLE: Final = (
    "Gupta, Kalabic, Di Cairano, Bloch, Kolmanovsky (ACC 2015): fast NMPC on SO(3), section IV"
)
SCENARIOS: Final = {
    "I": "gupta2015_case1",
    "II": "gupta2015_case2",
    "II off plane": "gupta2015_case2_offplane",
}
FAST: Final = "backward sweep"
METHODS: Final = {
    FAST: (),
    "single shooting": ("nmpc_controller.formulation=single_shooting",),
    "SLSQP": ("nmpc_controller.method=slsqp",),
    "fsolve": ("nmpc_controller.method=fsolve",),
}
BASELINES: Final = ("SLSQP", "fsolve")
PARKED: Final = "II parked"
NO_ESCAPE: Final = ("nmpc_controller.standstill_error_deg=0.0",)
# Table I and the text below it: total of the fast solver, its longest solve, total of the baseline.
PAPER_TIMES: Final = {"I": (38.22, 0.44, 271.01), "II": (134.66, 4.19, 767.97)}
# (30) with the printed figures: H_1 = beta_1 - v_1 . R^T w_1, v_1 the body x axis.
ZONE_AXIS: Final = np.array([0.9276, 0.3736, 0.0])
BETA: Final = -0.9962
FIRST_COST: Final = 0.01587107410188242
FIRST_TORQUE: Final = (-2.738291492e-3, -6.797529547e-3, -6.804072727e-3)  # [N m]


@dataclass(slots=True)
class Flights:
    """Every flight of the paper, by case and method."""

    by_case: dict[tuple[str, str], Flown] = field(default_factory=dict)

    def of(self, case: str, method: str = FAST) -> Flight:
        """Return a flight."""
        return self.by_case[case, method].trajectory

    def summary(self, case: str, method: str = FAST) -> dict[str, Any]:
        """Return the metrics of a flight."""
        flown = self.by_case[case, method]
        return summarize(flown.trajectory, flown.scenario)


def run(options: Options) -> Report:
    """Fly the cases; return the report."""
    flights = _fly_all(options.baselines, options.progress)
    checks = [*_first_problem(), *_case_1(flights), *_case_2(flights), *_equilibria(flights)]
    if options.baselines:
        for case in SCENARIOS:
            apart = float(apart_deg(flights.of(case), flights.of(case, "fsolve")).max())
            checks.append(Check(f"{case}: fsolve's flight from ours", 0.0, apart, 1e-5, "deg"))

    tables = [_times_table(flights), *_speed_up_tables(flights)]
    return Report(NAME, TITLE, tables, checks, _values(flights), (flights,))


def zone_constraint(trajectory: Flight) -> Array:
    """Return (n + 1,) H_1 of (30) with the printed figures; above 0 inside the zone."""
    return np.asarray(BETA + attitudes(trajectory)[:, :, 0] @ ZONE_AXIS)


def _fly_all(baselines: bool, progress: Progress) -> Flights:
    flights = Flights()
    for case, scenario in SCENARIOS.items():
        for method, overrides in METHODS.items():
            if method not in BASELINES:
                flown = fly(scenario, overrides, progress=progress)
            elif baselines:
                flown = fly(scenario, overrides, repeats=1, progress=progress)
            else:
                continue
            flights.by_case[case, method] = flown
    flights.by_case[PARKED, FAST] = fly(SCENARIOS["II"], NO_ESCAPE, repeats=1, progress=progress)
    return flights


def _first_problem() -> list[Check]:
    """Solve the first horizon of Case I as the paper does: full Newton steps from zero."""
    scenario = fly(SCENARIOS["I"], ["plant.duration=0.4"], repeats=1).scenario
    options = ShootingOptions(formulation="single_shooting", step_rule="full")
    solver = ShootingSolver(problem_of(scenario), options=options)
    solution = solver.solve(lie.exp(scenario.plant.initial_rotation_vector), np.zeros(3))
    torque = [
        Check(f"I: first torque, {axis}", expected, float(ours), 1e-12, "N m")
        for axis, expected, ours in zip("xyz", FIRST_TORQUE, solution.torques[0], strict=True)
    ]
    return [
        Check("I: optimal cost of the first horizon", FIRST_COST, solution.cost, 1e-15),
        *torque,
        Check("I: Newton steps for it", 3, solution.iterations, 0),
    ]


def _case_1(flights: Flights) -> list[Check]:
    m = flights.summary("I")
    return [
        Check("I: error at 150 s", 0.21364, _number(m["final_error_deg"]), 1e-5, "deg"),
        Check("I: |Pi| at 150 s", 4.14e-4, _number(m["final_momentum"]), 1e-6, "N m s"),
        Check("I: under 5 deg for good from", 55.2, _number(m["settle_time_5deg"]), 1e-9, "s"),
        Check("I: under 1 deg for good from", 105.2, _number(m["settle_time_1deg"]), 1e-9, "s"),
        Check("I: steps on the torque limit", 32, m["saturated_steps"], 0),
        Check("I: largest |u| beyond 0.01", 2.7e-9, m["max_torque"] - 0.01, 1e-10, "N m"),
        Check("I: sum of stage costs", 0.0550925764, m["cost"], 1e-10),
        Check("I: steps that failed", 0, m["unconverged_steps"], 0),
    ]


def _case_2(flights: Flights) -> list[Check]:
    m, parked = flights.summary("II off plane"), flights.summary(PARKED)
    printed, zone = flights.summary("II"), zone_constraint(flights.of("II off plane"))
    return [
        Check("II parked: error at 300 s", 26.883, parked["final_error_deg"], 1e-3, "deg"),
        Check("II parked: |Pi| at 300 s", 0.0, parked["final_momentum"], 1e-12, "N m s"),
        Check("II with escape: error at 300 s", 0.0, printed["final_error_deg"], 1e-3, "deg"),
        Check("II with escape: steps that escape", 1, printed["escaping_steps"], 0),
        Check("II off plane: error at 300 s", 5e-4, m["final_error_deg"], 5e-5, "deg"),
        Check("II off plane: under 5 deg from", 48.0, _number(m["settle_time_5deg"]), 1e-9, "s"),
        Check("II off plane: under 1 deg from", 95.2, _number(m["settle_time_1deg"]), 1e-9, "s"),
        Check("II off plane: largest H1", 1.52e-4, float(zone.max()), 1e-6),
        Check("II off plane: depth in the zone", 0.10, -m["min_zone_margin_deg"], 5e-3, "deg"),
        Check("II off plane: sum of stage costs", 0.0414353474, m["cost"], 1e-10),
        Check("II off plane: steps that failed", 0, m["unconverged_steps"], 0),
    ]


def _equilibria(flights: Flights) -> list[Check]:
    """Return the spectral radius of one closed-loop step where the loop can rest."""
    flown = flights.by_case[PARKED, FAST]
    solver = ShootingSolver(problem_of(flown.scenario))
    half_turn = lie.exp(np.array([math.pi, 0.0, 0.0]))
    places = {
        "parked": (flown.trajectory.final_attitude, 1.2214),
        "target": (np.eye(3), 0.9884),
        "half a turn about x": (half_turn, 1.068),
    }
    checks = []
    for place, (attitude, expected) in places.items():
        loop = linearize(solver.solve(attitude, np.zeros(3))).closed_loop
        radius = float(np.abs(np.linalg.eigvals(loop)).max())
        digits = len(str(expected)) - 2
        checks.append(Check(f"II: spectral radius, {place}", expected, radius, 0.5 * 10.0**-digits))
    return checks


def _times_table(flights: Flights) -> Table:
    header = ("case, solver", "total: paper", "ours", "longest: paper", "ours", "median: ours",
              "iterations", "fallbacks")  # fmt: skip
    rows = []
    for (case, method), flown in flights.by_case.items():
        t, m = times(flown.step_times), summarize(flown.trajectory, flown.scenario)
        total, longest = _paper_times(case, method)
        iterations = f"{m['iterations_median']:g}, {m['iterations_max']}"
        ours = [seconds(t[key]) for key in ("total", "max", "median")]
        name, fallbacks = f"{case}, {method}", str(m["fallback_steps"])
        rows.append([name, total, ours[0], longest, ours[1], ours[2], iterations, fallbacks])
    notes = [
        "Iterations: median, most. Fallbacks: steps whose solve failed and flew another torque.",
        "Paper: MATLAB, 3.6 GHz Xeon; its fast solver is single shooting. It calls both fmincon",
        "(section I; SLSQP here) and fsolve (section III) its baseline: which one, it leaves open.",
        f"Ours: each step's median over {REPEATS} flights; the baselines: one flight.",
        "This machine: " + machine_line(),
    ]
    return Table("Table I: time of all steps of a flight", header, rows, notes)


def _paper_times(case: str, method: str) -> tuple[str, str]:
    """Return the paper's total and longest time for a row of our table."""
    if case not in PAPER_TIMES:
        return NONE, NONE
    fast, longest, baseline = PAPER_TIMES[case]
    if method in (FAST, "single shooting"):
        return f"{fast} s", f"{longest} s"
    return f"{baseline} s", NONE


def _speed_up_tables(flights: Flights) -> list[Table]:
    rows = []
    for case in SCENARIOS:
        for method in BASELINES:
            if (case, method) not in flights.by_case:
                continue
            ratio = flights.by_case[case, method].total / flights.by_case[case, FAST].total
            ours, theirs = flights.of(case), flights.of(case, method)
            torque = np.linalg.norm(ours.torque - theirs.torque, axis=1)
            rows.append(
                [f"{case}, {method}", _paper_speed_up(case), f"{ratio:.0f}",
                 f"{apart_deg(ours, theirs).max():.2g} deg", f"{torque.max():.2g} N m",
                 f"{np.median(torque):.1g} N m"]
            )  # fmt: skip
    header = ("case, baseline", "speed-up, paper", "ours", "attitudes apart, most",
              "torques apart, most", "median")  # fmt: skip
    notes = [
        "SLSQP keeps both limits exactly, ours and fsolve by penalty. In Case II as printed each",
        "rests before the zone and leaves by the standstill escape, not at the same step.",
    ]
    return [Table("Speed-up over the baselines, same run", header, rows, notes)] if rows else []


def _paper_speed_up(case: str) -> str:
    if case not in PAPER_TIMES:
        return NONE
    fast, _, baseline = PAPER_TIMES[case]
    return f"{baseline / fast:.1f}"


def _values(flights: Flights) -> dict[str, Any]:
    rows = {
        f"{case}, {method}": {
            "times": times(flown.step_times),
            "metrics": summarize(flown.trajectory, flown.scenario),
        }
        for (case, method), flown in flights.by_case.items()
    }
    return {"machine": machine(), "flights": rows}


def _number(value: float | None) -> float:
    return math.nan if value is None else value
