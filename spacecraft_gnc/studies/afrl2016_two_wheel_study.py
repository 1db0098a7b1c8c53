"""What is solved, flown and counted of the two wheels of Kolmanovsky et al. 2016."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.studies import afrl2016_laws as laws
from spacecraft_gnc.studies.afrl2016_region import Region, region_of
from spacecraft_gnc.studies.afrl2016_solves import Comparison, compare, problems
from spacecraft_gnc.studies.campaigns import flown_campaign
from spacecraft_gnc.studies.flights import Flown, fly, set_vector
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.vehicles.two_wheel.flight import WheelFlight

SCENARIO: Final = "afrl_two_wheel"
NEAR: Final = "afrl_two_wheel_1rad"
STARTS: Final = {
    "(0.5, 0.3, -0.4) rad": ((0.5, 0.3, -0.4), 560.0),
    "(0.2, 0.1, -0.1) rad": ((0.2, 0.1, -0.1), 430.0),
    "(0, 0, 0.25) rad": ((0.0, 0.0, 0.25), 510.0),
}
"""Roll, pitch, yaw, and the time in which it has to settle [s]."""
REPORT: Final = "(2), Q3 = 10"
_MODEL: Final = "nmpc_controller.prediction_model={}"
FLOWN: Final = {
    REPORT: (_MODEL.format("simplified"), "nmpc_controller.attitude_weights=[1.0, 1.0, 10.0]"),
    "(2)": (_MODEL.format("simplified"),),
    "exact, Euler angles": (_MODEL.format("euler_321"),),
    "exact, SO(3)": (_MODEL.format("so3"),),
}
"""Prediction model, and what is laid over the scenario, whose Q3 is 30."""
RADII: Final = (0.25, 0.5)  # [rad]
YAWS: Final = {30: 0.33405, 40: 0.62545, 50: 1.00926, 60: 1.47835}
"""Largest pure yaw by horizon [rad]."""
POINTS: Final = 72  # of a circle of Fig. 1: a multiple of COUNTED
CELLS: Final = 14  # of Fig. 2, from the middle to the edge
COUNTED: Final = 24  # points of a circle whose feasibility is known
HALF_WIDTH: Final = 0.5  # of Fig. 2 [rad]


@dataclass(frozen=True, slots=True)
class Case:
    """A flight from one of the starts."""

    flown: Flown
    metrics: dict[str, Any]

    @property
    def flight(self) -> WheelFlight:
        """What was flown."""
        return cast("WheelFlight", self.flown.trajectory)

    @property
    def settled_at(self) -> float:
        """Time from which on it is at rest at the target for good [s]; NaN: never."""
        time = self.metrics["settle_time"]
        return math.nan if time is None else float(time)


@dataclass(frozen=True, slots=True)
class Study:
    """All that was flown and solved."""

    circles: tuple[laws.Circle, ...]
    plane: laws.Plane
    jump: tuple[float, float]
    yaws: dict[int, float]
    cases: dict[tuple[str, str], Case]
    comparison: Comparison | None
    region: Region | None
    near: Region | None

    def of(self, model: str) -> dict[str, Case]:
        """Return the flights with a prediction model, by start."""
        return {start: self.cases[start, model] for start in STARTS}


def study_all(options: Options) -> Study:
    """Solve, fly and count."""
    solver, progress = laws.solver_of(), options.progress
    cases = {
        (start, model): _case(angles, model, options)
        for start, (angles, _) in STARTS.items()
        for model in FLOWN
    }
    comparison = None
    if options.baselines:
        main = cases[next(iter(STARTS)), REPORT].flown
        comparison = compare(solver.ocp, list(problems(main)), progress)
    regions = [_region(name, options) for name in (SCENARIO, NEAR)]
    return Study(
        tuple(laws.circle(solver, radius, POINTS, progress) for radius in RADII),
        laws.plane(solver, HALF_WIDTH, CELLS, progress),
        laws.jump(solver, RADII[0]),
        {
            horizon: laws.largest_yaw(horizon, 0.98 * yaw, 1.02 * yaw)
            for horizon, yaw in YAWS.items()
        },
        cases,
        comparison,
        *regions,
    )


def _case(angles: tuple[float, ...], model: str, options: Options) -> Case:
    overrides = (
        set_vector("plant.initial_euler_321", np.array(angles)),
        *FLOWN[model],
    )
    flown = fly(SCENARIO, overrides, repeats=1, progress=options.progress)
    return Case(flown, summarize(flown.trajectory, flown.scenario))


def _region(name: str, options: Options) -> Region | None:
    if options.folder is None or options.runs == 0:
        return None
    folder = options.folder / name
    return region_of(flown_campaign(SCENARIO, name, folder, options.runs, options.progress))
