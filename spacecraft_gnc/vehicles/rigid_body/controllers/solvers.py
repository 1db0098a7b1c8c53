"""NMPC controllers behind the `Controller` protocol, around the solvers of `ocp`.

Every controller here flies the same way: one solve from the last one's multipliers, the failure
ladder behind it, and the certificate of the loop at a standstill.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, Protocol

import numpy as np

from spacecraft_gnc.arguments import require_members
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import Command, Reference, Source, State
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    AutomaticContinuation,
    Continuation,
    EffortContinuation,
    FsolveSolver,
    HorizonContinuation,
    NeighboringExtremal,
    NeighboringOptions,
    PenaltyContinuation,
    ShootingOptions,
    ShootingSolver,
    SlsqpSolver,
    Solution,
    StateContinuation,
    Weights,
    cheapest,
    linearize,
)
from spacecraft_gnc.ocp.reference import Tracked
from spacecraft_gnc.types import Array, ArrayLike
from spacecraft_gnc.vehicles.rigid_body.controllers.ladder import FallbackLadder
from spacecraft_gnc.vehicles.rigid_body.controllers.report import SolveReport
from spacecraft_gnc.vehicles.rigid_body.controllers.standstill import StandstillMonitor
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario, known_inertia
from spacecraft_gnc.vehicles.rigid_body.zones import zones_of


class Solver(Protocol):
    """What `SolverController` flies: any solver of `ocp`."""

    @property
    def ocp(self) -> AttitudeOcp:
        """Problem solved."""

    def solve(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
        warm_start: Array | None = None,
    ) -> Solution:
        """Solve from a state."""

    def warm_up(self) -> None:
        """Compile or load the kernels."""


class SolverController:
    """NMPC: one solve a step, the failure ladder behind it.

    Parameters
    ----------
    solver : Solver
    monitor : StandstillMonitor, optional
        Looks for standstills away from the target.
    continuation : Continuation, optional
        Tried where a solve fails warm and cold, or takes more Newton steps than its ``patience``;
        the cheaper solution is flown.

    Notes
    -----
    The multipliers of one solve, shifted by one step, start the next. A failed solve leaves no
    warm start behind; where a warm start fails, the same step is tried once more from zero. What
    is tried depends on the count of Newton steps alone, never on the time that they took.
    """

    name = "solver"
    slow = False

    def __init__(
        self,
        solver: Solver,
        monitor: StandstillMonitor | None = None,
        continuation: Continuation | None = None,
    ) -> None:
        self.solver = require_members(
            "solver", solver, ("ocp", "solve", "warm_up"), "solver of ocp"
        )
        self.period = solver.ocp.time_step
        self._monitor = monitor
        self._continuation = continuation
        self._ladder = FallbackLadder(solver.ocp)
        self._warm_start: Array | None = None

    @property
    def warm_start(self) -> Array | None:
        """(N, 6) multipliers from which the next solve starts; None: from zero."""
        return self._warm_start

    @property
    def patience(self) -> float:
        """Newton steps of a converged solve beyond which a continuation is tried."""
        return math.inf if self._continuation is None else float(self._continuation.patience)

    @property
    def rest(self) -> tuple[float, float, float, float] | None:
        """`StandstillMonitor.rest`; without a monitor one that no loop comes to.

        None for a monitor of a derived class, which may look for anything.
        """
        if self._monitor is None:
            return (math.inf, 0.0, 0.0, 0.0)
        return self._monitor.rest if type(self._monitor) is StandstillMonitor else None

    def warm_up(self) -> None:
        """Compile or load the kernels, those of the ladder and the standstill included."""
        self.solver.warm_up()
        linearize(self.solver.solve(np.eye(3), np.zeros(3)))
        self.reset()

    def reset(self) -> None:
        """Forget warm start and plan."""
        self._warm_start = None
        self._ladder.reset()

    def command(self, state: State, reference: Reference) -> Command:
        """Solve from ``state`` and return the torque of the highest rung of the ladder."""
        return self.conclude(state, reference, self.solve(state, reference, self._warm_start))

    def memory(self) -> tuple[Any, ...] | None:
        """Return warm start, last plan and what the solver keeps; None: a chord in a continuation.

        None as well where a solver of another package does not tell what it keeps.
        """
        tell = getattr(self.solver, "memory", None)
        if tell is None or (self._continuation is not None and keeps_chord(self.solver)):
            return None
        return self._warm_start, self._ladder.memory(), tell()

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the controller did whose `memory` it is."""
        self._warm_start, plan, kept = memory
        self._ladder.recall(plan)
        self.solver.recall(kept)  # type: ignore[attr-defined]

    def conclude(self, state: State, reference: Reference, solution: Solution | None) -> Command:
        """Return the command of a step with that solution, and keep what the next step needs."""
        self._warm_start = None if solution is None else solution.warm_start
        command = self._ladder.command(state, reference, solution)
        if self._monitor is None or solution is None or command.source is not Source.OPTIMAL:
            return command
        finding = self._monitor.examine(solution)
        if finding is None:
            return command
        return Command(finding.torque, command.source, SolveReport(solution, finding.standstill))

    def solve(
        self, state: State, reference: Reference, warm_start: Array | None
    ) -> Solution | None:
        """Try everything that this controller tries in one step, from given multipliers (N, 6).

        Returns the first solve that converged, else the last one that failed; None where the solver
        refuses the state or the reference. The warm start of the next step stays what it was.
        """
        problem = (state.attitude, state.momentum, reference)
        try:
            solution = self.solver.solve(*problem, warm_start)
            if warm_start is not None and not solution.converged:
                solution = self.solver.solve(*problem)
            way = self._continuation
            if way is not None and (not solution.converged or solution.iterations > way.patience):
                solution = self._compared(solution, way.solve(*problem))
        except GncError:  # a state or reference that is no state: the ladder deals with it
            return None
        return solution

    def _compared(self, direct: Solution, other: Solution) -> Solution:
        """Return the better of two solutions of one step."""
        return cheapest((direct, other))


class ShootingController(SolverController):
    """``method: shooting``: Newton's method on the first-order conditions."""

    name = "shooting"

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> ShootingController:
        """Build the controller of a scenario's section ``nmpc_controller``."""
        ocp, options = problem_of(scenario), options_of(scenario)
        solver = ShootingSolver(ocp, scenario.controller.variant, options)
        return cls(solver, monitor_of(scenario, ocp), continuation_of(scenario, ocp))


class OnlineNeighboringController(SolverController):
    """``method: neighboring_extremal``: corrections of the last optimum, solves where needed."""

    name = "neighboring_extremal"

    def __init__(
        self,
        solver: NeighboringExtremal,
        monitor: StandstillMonitor | None = None,
        continuation: Continuation | None = None,
    ) -> None:
        super().__init__(solver, monitor, continuation)
        self._sequence = solver

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> OnlineNeighboringController:
        """Build the controller of a scenario's section ``nmpc_controller``."""
        c, ocp = scenario.controller, problem_of(scenario)
        sequence = NeighboringExtremal(
            ocp, NeighboringOptions(c.ne_tolerance, c.ne_max_age), options_of(scenario)
        )
        return cls(sequence, monitor_of(scenario, ocp), continuation_of(scenario, ocp))

    def _compared(self, direct: Solution, other: Solution) -> Solution:
        """Return the better of two solutions; only the sequence's own can be corrected."""
        best = super()._compared(direct, other)
        if best.torques is not direct.torques:
            self._sequence.forget()
        return best

    def reset(self) -> None:
        """Forget warm start, plan and the last optimum."""
        super().reset()
        self._sequence.reset()


class SlsqpController(SolverController):
    """``method: slsqp``: scipy's sequential quadratic programming, the papers' baseline."""

    name = "slsqp"
    slow = True

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> SlsqpController:
        """Build the controller of a scenario's section ``nmpc_controller``."""
        ocp = problem_of(scenario)
        return cls(SlsqpSolver(ocp), monitor_of(scenario, ocp))


class FsolveController(SolverController):
    """``method: fsolve``: MINPACK on the shooting equations, the papers' other baseline."""

    name = "fsolve"
    slow = True

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> FsolveController:
        """Build the controller of a scenario's section ``nmpc_controller``."""
        ocp = problem_of(scenario)
        return cls(FsolveSolver(ocp), monitor_of(scenario, ocp))


CONTINUATIONS: Final[dict[str, Callable[[AttitudeOcp, ShootingOptions], Continuation]]] = {
    "auto": AutomaticContinuation,
    "penalty": PenaltyContinuation,
    "state": StateContinuation,
    "horizon": HorizonContinuation,
    "effort": EffortContinuation,
}
"""Words of a scenario, beside none."""


def keeps_chord(solver: object) -> bool:
    """Tell whether a solver keeps its Jacobian from one solve to the next."""
    options = getattr(getattr(solver, "solver", solver), "options", None)
    return isinstance(options, ShootingOptions) and options.step_rule == "chord"


def options_of(scenario: Scenario) -> ShootingOptions:
    """Return the options of Newton's method of a scenario's section ``nmpc_controller``."""
    c = scenario.controller
    return ShootingOptions(
        c.residual_tolerance, c.max_iterations, c.formulation, c.step_rule, c.damping
    )


def monitor_of(scenario: Scenario, ocp: AttitudeOcp) -> StandstillMonitor:
    """Return the standstill monitor of a scenario's section ``nmpc_controller``."""
    c = scenario.controller
    names = [zone.name for zone in c.zones]
    return StandstillMonitor(ocp, math.radians(c.standstill_error_deg), names)


def continuation_of(scenario: Scenario, ocp: AttitudeOcp) -> Continuation | None:
    """Return the continuation that a scenario asks for; None where it asks for none."""
    c, options = scenario.controller, options_of(scenario)
    if c.continuation not in CONTINUATIONS:
        return None
    way = CONTINUATIONS[c.continuation](ocp, options)
    if c.variant != "exact" or c.step_rule != "backtracking":
        way.patience = math.inf  # many Newton steps are no sign of a long way
    return way


def problem_of(scenario: Scenario) -> AttitudeOcp:
    """Return the optimal control problem of a scenario's section ``nmpc_controller``."""
    c = scenario.controller
    w = c.weights
    return AttitudeOcp(
        inertia=known_inertia(scenario, "nmpc_controller", c.inertia),
        time_step=c.time_step,
        horizon=c.horizon,
        weights=Weights(
            w.stage_attitude,
            w.stage_momentum,
            w.stage_torque,
            w.terminal_attitude,
            w.terminal_momentum,
        ),
        max_torque=c.max_torque,
        torque_penalty=c.torque_penalty,
        zones=zones_of(scenario),
        actuators=c.actuators if c.actuators.size else None,
        plant_step=scenario.plant.time_step,
    )
