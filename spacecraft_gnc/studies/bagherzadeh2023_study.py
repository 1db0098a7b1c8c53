"""Study of neighboring extremals: changed initial conditions, four ways to answer them.

Table III, which lists the second initial conditions, is missing from the text we have. In its place
stand three: the first one rotated by 5 and 10 deg about body x and by 10 deg about body [1, 1, 1].
"""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp import NominalRun, ShootingSolver, Solution, fly_nominal
from spacecraft_gnc.ocp.linearization import deviation, linearize
from spacecraft_gnc.scenario import Scenario, load
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.studies.flights import (
    Flown,
    Progress,
    apart_deg,
    fly,
    separation_deg,
    set_vector,
)
from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of

NOMINAL: Final = np.array([0.25, 0.5, 0.5])
STARTS: Final = {
    "5 deg, x": (5.0, np.array([1.0, 0.0, 0.0])),
    "10 deg, x": (10.0, np.array([1.0, 0.0, 0.0])),
    "10 deg, [1,1,1]": (10.0, np.array([1.0, 1.0, 1.0]) / math.sqrt(3.0)),
}
"""Rotation from the first initial condition to the second: angle [deg], body axis."""
TIMED: Final = "10 deg, [1,1,1]"
"""The start of Table IV and of the pictures."""
EXACT, NE, NE_EXACT_10, ONLINE = "exact", "NE", "NE + exact every 10", "NE on line"
_FLOWN: Final = {
    EXACT: ("bagherzadeh2023_exact", ()),
    NE: ("bagherzadeh2023_ne", ()),
    NE_EXACT_10: ("bagherzadeh2023_ne_exact10", ()),
    ONLINE: ("gupta2015_case1", ("nmpc_controller.method=neighboring_extremal",)),
}


class Path(NamedTuple):
    """States and torques that no controller of the package flies."""

    attitudes: Array
    """(n + 1, 3, 3)"""
    momenta: Array
    """(n + 1, 3) [N m s]"""
    torques: Array
    """(n, 3) [N m]"""


class Study(NamedTuple):
    """One second initial condition."""

    flights: dict[str, Flown]
    raw: Path
    """NE fed with the true state, its torque not cut to the limit."""
    predicted: Path
    """The run plus a deviation that is itself propagated linearly; no dynamics, nothing cut."""
    open_loop: Path
    """The torques of ``predicted``, flown by the body: the drift that the paper plots."""

    def error(self, method: str) -> Array:
        """Return (n + 1,) angles of a flight from the exact one [deg]."""
        return apart_deg(self.flights[EXACT].trajectory, self.flights[method].trajectory)

    def error_of(self, path: Path) -> Array:
        """Return (n + 1,) angles of a path from the exact flight [deg]."""
        exact = series.attitudes(self.flights[EXACT].trajectory)
        return separation_deg(exact, path.attitudes)

    @property
    def hit_rate(self) -> float:
        """Share of the steps that an on-line correction answered."""
        return float(np.mean(self.flights[ONLINE].trajectory.iterations == 0))


class Nominal(NamedTuple):
    """The stored run from the first initial condition, with its closed loop linearized."""

    run: NominalRun
    closed_loop: Array
    """(n, 6, 6) derivative of (eta, Pi)_{k+1} to (eta, Pi)_k under the gains."""
    solver: ShootingSolver


def start_of(angle_deg: float, axis: Array) -> Matrix3:
    """Return the attitude (3, 3) at the second initial condition."""
    return lie.exp(NOMINAL) @ lie.exp(math.radians(angle_deg) * axis)


def study_all(progress: Progress) -> dict[str, Study]:
    """Fly every start in every way."""
    nominal = _nominal(load(shipped(_FLOWN[NE][0])))
    return {
        name: _study(nominal, start_of(angle, axis), progress)
        for name, (angle, axis) in STARTS.items()
    }


def correction_times(studies: dict[str, Study], repeats: int = 20) -> tuple[float, float]:
    """Return the median times [s] of `NominalRun.torque` and of an on-line correction."""
    nominal = _nominal(load(shipped(_FLOWN[NE][0])))
    flown = studies[TIMED].flights[NE].trajectory
    rows = np.empty((repeats, flown.n_steps))
    for row in rows:
        for k, (attitude, momentum) in enumerate(zip(flown.attitude, flown.momentum, strict=True)):
            begun = perf_counter()
            nominal.run.torque(k, attitude, momentum)
            row[k] = perf_counter() - begun
    online = studies[TIMED].flights[ONLINE].trajectory
    corrected = online.solve_time[online.iterations == 0]
    return float(np.median(rows)), float(np.median(corrected))


def _nominal(scenario: Scenario) -> Nominal:
    solver = ShootingSolver(problem_of(scenario))
    n = scenario.n_steps
    run = fly_nominal(solver, lie.exp(NOMINAL), np.zeros(3), n)
    closed_loop = np.empty((n, 6, 6))
    warm_start: Array | None = None
    for k in range(n):
        solution: Solution = solver.solve(run.attitudes[k], run.momenta[k], None, warm_start)
        closed_loop[k] = linearize(solution).closed_loop
        warm_start = solution.warm_start
    return Nominal(run, closed_loop, solver)


def _study(nominal: Nominal, start: Matrix3, progress: Progress) -> Study:
    override = set_vector("plant.initial_rotation_vector", lie.log(start))
    flights = {
        method: fly(name, [*overrides, override], progress=progress)
        for method, (name, overrides) in _FLOWN.items()
    }
    predicted = _predict(nominal, start)
    raw = _flown(nominal, start, nominal.run.torque)
    open_loop = _flown(nominal, start, lambda k, _attitude, _momentum: predicted.torques[k])
    return Study(flights, raw, predicted, open_loop)


def _flown(
    nominal: Nominal, start: Matrix3, torque: Callable[[int, Matrix3, Vector3], Vector3]
) -> Path:
    """Fly a torque, a function of step and true state, as it is."""
    n = len(nominal.run)
    path = Path(np.empty((n + 1, 3, 3)), np.zeros((n + 1, 3)), np.empty((n, 3)))
    path.attitudes[0] = start
    body = nominal.solver.ocp.body
    for k in range(n):
        state = (path.attitudes[k], path.momenta[k])
        path.torques[k] = torque(k, *state)
        path.attitudes[k + 1], path.momenta[k + 1] = body.step(*state, path.torques[k])
    return path


def _predict(nominal: Nominal, start: Matrix3) -> Path:
    """Propagate the deviation by the linearized closed loop; nothing measured comes in."""
    run, n = nominal.run, len(nominal.run)
    last = nominal.solver.ocp.body.step(run.attitudes[-1], run.momenta[-1], run.torques[-1])
    nominal_attitudes = np.concatenate([run.attitudes, last[0][None]])
    nominal_momenta = np.concatenate([run.momenta, last[1][None]])
    path = Path(np.empty((n + 1, 3, 3)), np.empty((n + 1, 3)), np.empty((n, 3)))
    off = deviation(start, np.zeros(3), run.attitudes[0], run.momenta[0])
    for k in range(n + 1):
        path.attitudes[k] = nominal_attitudes[k] @ lie.exp(off[:3])
        path.momenta[k] = nominal_momenta[k] + off[3:]
        if k < n:
            path.torques[k] = run.torques[k] + run.gains[k] @ off
            off = nominal.closed_loop[k] @ off
    return path
