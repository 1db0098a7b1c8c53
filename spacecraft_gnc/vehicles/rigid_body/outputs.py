"""Messages that controller and governor of a rigid body publish at each step."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final, Protocol

from spacecraft_gnc import lie
from spacecraft_gnc.governors.planned.report import PlanReport
from spacecraft_gnc.loop.protocols import Command, GovernorDecision, Reference, State
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import (
    ACCEPTED_TARGET,
    ATTITUDE_ERROR,
    GOVERNOR_STATUS,
    REFERENCE,
    at_rest,
    error_of,
)
from spacecraft_gnc.status import NO_SOLVE
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.rigid_body.controllers.report import plan_of, solution_of
from spacecraft_gnc.vehicles.rigid_body.markers import zone_markers
from spacecraft_gnc.vehicles.rigid_body.signals import (
    ATTITUDE_PLAN,
    PLAN_STATUS,
    SOLVER_STATUS,
    TORQUE,
    ZONE_MARKERS,
)

Told = list[tuple[Signal, Any]]
"""Signals with their values, in the order in which they are published."""
_NO_COSTATE: Final = [math.nan] * 6


class HasController(Protocol):
    """What of a scenario is needed."""

    @property
    def controller(self) -> Any:
        """Parameters of the controller."""


class Outputs:
    """What the nodes of one spacecraft tell.

    Parameters
    ----------
    scenario
        What flies.
    """

    def __init__(self, scenario: HasController) -> None:
        parameters = scenario.controller
        self._method = parameters.method
        self._zones = parameters.zones
        horizon = parameters.horizon
        widths = (9 * horizon + 9, 3 * horizon + 3, 3 * horizon)
        self._no_plan = [[math.nan] * width for width in widths]

    def setup(self) -> Told:
        """Return what the controller tells once, when it starts."""
        return [(ZONE_MARKERS, (zone_markers(self._zones),))]

    def controller(
        self, state: State, reference: Reference, command: Command, wall: tuple[float, float]
    ) -> Iterator[tuple[Signal, Any]]:
        """Yield what the controller tells of a command.

        The command comes first, and nothing else is computed before it is taken: the plant waits.

        Parameters
        ----------
        state, reference, command
            Of the step.
        wall
            Wall time of the solve, and what was left until the deadline [s].
        """
        yield TORQUE, command
        yield SOLVER_STATUS, self._status(command, wall)
        yield ATTITUDE_ERROR, error_of(state.attitude, reference)
        yield from _told_of(plan_of(command))

    def progress(self, state: State, reference: Reference, command: Command) -> dict[str, Any]:
        """Return what a progress display shows of a step."""
        solution = solution_of(command)
        return {
            "attitude_error": lie.angle_between(state.attitude, reference.attitude),
            "wall_solve_time": solution.solve_time if solution else math.nan,
        }

    def governor(self, decision: GovernorDecision) -> Told:
        """Return what the governor tells of a decision; the reference first."""
        told = [(REFERENCE, decision.reference), (GOVERNOR_STATUS, decision)]
        return [*told, *_told_of(plan_of(decision))]

    def accepted(self, target: Matrix3) -> Told:
        """Return what the governor tells of a target (3, 3) that it took in flight."""
        return [(ACCEPTED_TARGET, at_rest(target))]

    def _status(self, command: Command, wall: tuple[float, float]) -> tuple[Any, ...]:
        """Return the fields of SolverStatus."""
        solution, status = solution_of(command), command.status
        standstill = None if command.report is None else command.report.standstill
        if solution is None or status is None:
            nothing = (math.nan, math.nan, _NO_COSTATE, math.nan, (), math.nan, math.nan, "")
            return (self._method, "", NO_SOLVE, 0, *nothing, *self._no_plan, *wall)
        return (
            self._method,
            solution.formulation,
            int(status),
            solution.iterations,
            solution.residual,
            solution.cost,
            solution.costates[0],
            solution.torque_margin,
            solution.zone_margins,
            solution.min_curvature,
            standstill.radius if standstill else math.nan,
            standstill.active_constraint if standstill else "",
            solution.attitudes,
            solution.momenta,
            solution.torques,
            *wall,
        )


def _told_of(plan: PlanReport | None) -> Told:
    """Return what is told of a step along a plan: the plans taken at it, and the step."""
    if plan is None:
        return []
    return [*((ATTITUDE_PLAN, planned) for planned in plan.told), (PLAN_STATUS, plan)]
