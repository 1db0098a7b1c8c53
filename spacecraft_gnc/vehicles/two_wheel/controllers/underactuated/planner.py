"""Plans for two wheels, step by step: from wherever the spacecraft is to rest at any attitude.

The plan of a step is the first that is found of

1. the plan that ends at rest at the reference (5);
2. ``terminal: soft``: one that ends at rest, with the attitude error at its end as a term of the
   cost; ``terminal: shaped``: the same where it shortens the path to the reference by turns that
   two wheels can make (`shaping`), else one that ends at rest at a waypoint, the farthest one found
   on that path;
3. the rest of the plan before;
4. braking: the wheels come to rest as fast as they can.

With an exact model and no drift, 1 stays possible once it was, and so does a plan to where the
last one ended: the rest of it, and a step at rest. The path never gets longer, and from rest at its
start some later point of it is within reach: every reference is reached (docs/full_range.md).
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import require_kind, require_word
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Terminal
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.shaping import Path, path_between
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.ocp.solution import WarmStart, WheelSolution
from spacecraft_gnc.vehicles.two_wheel.ocp.starts import within

SOLVERS: Final = ("sqp", "ipopt")
TERMINALS: Final = ("shaped", "soft", "hard")
_SEARCHES: Final = 4
"""Waypoints that are tried in one step."""
_FASTER: Final = 1.5
"""First waypoint tried, in units of the way that was found in the step before."""
_PROGRESS: Final = 0.5
"""Part of a step by which a plan with a soft end has to shorten the path, else a waypoint is looked
for."""
_NEAR: Final = 3e-3
"""Angle [rad] off its reference up to which a plan with a soft end says that a hard one exists."""


class Plan(NamedTuple):
    """What to do in a step, and why."""

    acceleration: Array
    """(2,) [rad/s^2]."""
    source: Source
    terminal: Terminal
    solution: WheelSolution
    """Of this step; it has failed where ``source`` is a fallback."""
    solver: str


class _State(NamedTuple):
    """What a plan starts from, as in `TwoWheelPlanner.plan`."""

    attitude: Matrix3
    wheel_speed: Array
    drift: Array | None


class TwoWheelPlanner:
    """Plan for two wheels, from the plan of the step before.

    Parameters
    ----------
    ocp : WheelOcp
    solver : {"sqp", "ipopt"}
    terminal : {"shaped", "soft", "hard"}
        What is planned where the reference is out of reach; hard: nothing.
    **options
        Of the solver: restarts, seed, and of sqp: chord.

    Raises
    ------
    ParameterError, MissingDependency
        If an argument is refused, or CasADi is not installed.
    """

    def __init__(
        self, ocp: WheelOcp, solver: str = "sqp", terminal: str = "shaped", **options: Any
    ) -> None:
        self.ocp = require_kind("ocp", ocp, WheelOcp)
        require_word("solver", solver, SOLVERS)
        require_word("terminal", terminal, TERMINALS)
        self.terminal, self._name = terminal, solver
        self.solver = _solver(ocp, solver, options)
        self.reset()

    def reset(self) -> None:
        """Forget the last plan and the way to the reference."""
        self._step = 0
        self._plan: WheelSolution | None = None  # made at `_step`, flown since
        self._path: Path | None = None  # from the waypoint that the plan ends at
        self._end: Matrix3 = np.full((3, 3), np.nan)  # of the path
        self._way = self.ocp.horizon * self.ocp.time_step

    def memory(self) -> tuple[Any, ...]:
        """Return the last plan and the way to the reference."""
        plan = None if self._plan is None else self._plan.plain()
        return self._step, plan, self._path, self._end, self._way

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the planner did whose `memory` it is."""
        self._step, plan, path, self._end, self._way = memory
        self._plan = None if plan is None else WheelSolution.of_plain(plan, self.ocp)
        self._path = None if path is None else Path(*path)

    @property
    def path_left(self) -> float:
        """Time of the path from the end of the plan to the reference [s]; NaN: there is none."""
        return math.nan if self._path is None else self._path.time

    def plan(
        self,
        step: int,
        attitude: Matrix3,
        wheel_speed: Array,
        reference: Matrix3,
        drift: Array | None = None,
    ) -> Plan:
        """Return the plan of a control step.

        Parameters
        ----------
        step : int
            Number of the control step; where some were missed, the last plan was flown on.
        attitude : (3, 3) array
            Body to inertial.
        wheel_speed : (2,) array
            [rad/s].
        reference : (3, 3) array
            Attitude to reach, body to inertial.
        drift : (N+1, 3) array, optional
            Rate that other wheels give the bus at the nodes of the horizon, body frame [rad/s].

        Raises
        ------
        ShapeError, ParameterError
            If an argument is refused.
        """
        state = _State(attitude, wheel_speed, drift)
        warm, done = self._left(step)
        solution, terminal = self._solve(state, reference, warm)
        if solution.converged:
            self._step, self._plan = step, solution
            acceleration, source = solution.accelerations[0], Source.OPTIMAL
        elif self._plan is not None:
            acceleration, source = self._plan.accelerations[done], Source.SHIFTED_PLAN
        else:
            speeds = _braking(self.ocp, wheel_speed)
            acceleration, source = (speeds[1] - speeds[0]) / self.ocp.time_step, Source.FEEDBACK
        return Plan(acceleration, source, terminal, solution, self._name)

    def _left(self, step: int) -> tuple[WarmStart | None, int]:
        """Return what is left of the last plan, and how many steps of it are over."""
        done = step - self._step
        if self._plan is None or not 0 < done < self.ocp.horizon:
            self._plan = self._path = None
            return None, 0
        warm = self._plan.warm_start
        for _ in range(done - 1):
            warm = WarmStart(_shifted(warm.speeds), warm.terminal, _shifted(warm.bounds))
        return warm, done

    def _solve(
        self, state: _State, reference: Matrix3, warm: WarmStart | None
    ) -> tuple[WheelSolution, Terminal]:
        """Return the best plan that is found; where there is none, what failed last."""
        arrives = self._path is not None and np.array_equal(self._path.start, reference)
        if self.terminal == "hard" or arrives:
            solution = self._to(state, reference, warm)
            if solution.converged or self.terminal == "hard":
                return solution, Terminal.REFERENCE
        solution = self._nearest(state, reference, warm, search=self.terminal == "soft")
        if solution.converged and not solution.soft:
            self._path = Path(reference, np.empty((0, 3)), np.empty(0))
            return solution, Terminal.REFERENCE
        if self.terminal == "soft" or self._advances(state, reference, solution):
            return solution, Terminal.SOFT
        return self._farthest(state, reference, warm), Terminal.WAYPOINT

    def _advances(self, state: _State, reference: Matrix3, solution: WheelSolution) -> bool:
        """Tell whether a plan with a soft end shortens the path that is left; then take its end."""
        before = self._ahead(state, reference)
        if not solution.converged:
            return False
        after = path_between(self.ocp, solution.attitudes[-1], reference)
        if before.time - after.time < _PROGRESS * self.ocp.time_step:
            return False
        self._path = after
        return True

    def _to(
        self, state: _State, end: Matrix3, warm: WarmStart | None, **options: bool
    ) -> WheelSolution:
        """Return the plan that ends at rest at an attitude."""
        attitude, wheel_speed, drift = state
        found: WheelSolution = self.solver.solve(
            attitude, wheel_speed, end, drift=drift, warm_start=warm, **options
        )
        return found

    def _nearest(
        self, state: _State, end: Matrix3, warm: WarmStart | None, *, search: bool = False
    ) -> WheelSolution:
        """Return the plan that ends at an attitude, or one with a soft end where it is too far.

        A plan with a soft end always exists, and tells whether there is one with a hard end.
        """
        near = self._to(state, end, warm, soft=True, search=search)
        if not near.converged or near.terminal_violation > _NEAR:
            return near
        solution = self._to(state, end, _start_of(near), search=False)
        return solution if solution.converged else near

    def _farthest(self, state: _State, reference: Matrix3, warm: WarmStart | None) -> WheelSolution:
        """Return the plan to the farthest waypoint found; what failed where there is none."""
        path = self._ahead(state, reference)
        best, low, high = None, 0.0, path.time
        time = min(self._way, high)
        for _ in range(_SEARCHES):
            found = self._nearest(state, path.after(time).start, warm)
            if found.converged and not found.soft:
                best, low, warm = found, time, _start_of(found)
            else:
                high = time
            if low == high:
                break
            time = min(2.0 * time, high) if high == path.time else 0.5 * (low + high)
        self._way = max(_FASTER * low, self.ocp.time_step)
        self._path = path.after(low)
        return self._to(state, path.start, warm) if best is None else best

    def _ahead(self, state: _State, reference: Matrix3) -> Path:
        """Return the fastest path known from the waypoint before to the reference."""
        start = _stopped(self.ocp, state) if self._path is None else self._path.start
        again = path_between(self.ocp, start, reference)
        if self._path is None or not np.array_equal(self._end, reference):
            self._path, self._end = again, reference
        return min(self._path, again, key=lambda path: path.time)


def _start_of(solution: WheelSolution) -> WarmStart:
    """Return a start for another solve in the same step."""
    bounds = np.column_stack([solution.speed_multipliers[1:], solution.acceleration_multipliers])
    return WarmStart(solution.speeds, np.append(solution.terminal_multipliers, np.zeros(2)), bounds)


def _shifted(rows: Array) -> Array:
    """Return rows one step on, with zeros at the end."""
    return np.vstack([rows[1:], np.zeros_like(rows[:1])])


def _braking(ocp: WheelOcp, wheel_speed: Array) -> Array:
    """Return wheel speeds (N+1, 2) that come to rest as soon as they can."""
    return within(ocp, np.zeros((ocp.horizon + 1, 2)), wheel_speed)


def _stopped(ocp: WheelOcp, state: _State) -> Matrix3:
    """Return the attitude at which the spacecraft comes to rest when it brakes."""
    attitude, wheel_speed, drift = state
    rates = _braking(ocp, wheel_speed) @ (ocp.frame @ ocp.rates).T
    rates = rates if drift is None else rates + drift
    for before, after in pairwise(rates):
        turn = 0.5 * (before + after) + ocp.time_step / 12.0 * np.cross(before, after)
        attitude = attitude @ lie.exp(ocp.time_step * turn)
    return attitude


def _solver(ocp: WheelOcp, name: str, options: dict[str, Any]) -> Any:
    """Return a solver; CasADi is loaded for ipopt only."""
    if name == "sqp":
        from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver

        return SqpSolver(ocp, **options)
    from spacecraft_gnc.vehicles.two_wheel.ocp.ipopt import IpoptSolver

    options.pop("chord", None)
    return IpoptSolver(ocp, **options)
