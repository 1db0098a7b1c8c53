"""Messages that controller and governor of a spacecraft with wheels publish at each step."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.loop.protocols import Command, GovernorDecision, Reference
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
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.controllers.report import (
    Diagnosis,
    Mode,
    Rest,
    Solve,
    Terminal,
    diagnosis_of,
    solve_of,
)
from spacecraft_gnc.vehicles.two_wheel.signals import COMMAND, DIAGNOSIS, SOLVER_STATUS
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

Told = list[tuple[Signal, Any]]
"""Signals with their values, in the order in which they are published."""
_UNKNOWN: Final = [math.nan] * 9


class Outputs:
    """What the nodes of one spacecraft tell.

    Parameters
    ----------
    scenario
        What flies.
    """

    def __init__(self, scenario: Any) -> None:
        self._method = scenario.controller.method

    def setup(self) -> Told:
        """Return what the controller tells once, when it starts: nothing."""
        return []

    def controller(
        self, state: WheelState, reference: Reference, command: Command, wall: tuple[float, float]
    ) -> Told:
        """Return what the controller tells of a command, which comes first."""
        diagnosis = diagnosis_of(command) or _unwatched(state, reference)
        return [
            (COMMAND, command),
            (SOLVER_STATUS, (*self._solve(solve_of(command)), *wall)),
            (DIAGNOSIS, diagnosis),
            (ATTITUDE_ERROR, error_of(state.attitude, reference)),
        ]

    def progress(self, state: WheelState, reference: Reference, command: Command) -> dict[str, Any]:
        """Return what a progress display shows of a step."""
        solve = solve_of(command)
        return {
            "attitude_error": lie.angle_between(state.attitude, reference.attitude),
            "wall_solve_time": solve.solve_time if solve else math.nan,
        }

    def governor(self, decision: GovernorDecision) -> Told:
        """Return what the governor tells of a decision; the reference first."""
        return [(REFERENCE, decision.reference), (GOVERNOR_STATUS, decision)]

    def accepted(self, target: Matrix3) -> Told:
        """Return what the governor tells of a target (3, 3) that it took in flight."""
        return [(ACCEPTED_TARGET, at_rest(target))]

    def _solve(self, solve: Solve | None) -> tuple[Any, ...]:
        """Return the fields of WheelSolverStatus but the wall times."""
        if solve is None:
            nothing = (math.nan, math.nan, math.nan, math.nan, _UNKNOWN)
            return (self._method, "", "", NO_SOLVE, Terminal.FREE, 0, 0, *nothing, *[()] * 7)
        return (
            solve.method,
            solve.model,
            solve.solver,
            int(solve.status),
            int(solve.terminal),
            solve.iterations,
            solve.restarts,
            solve.residual,
            solve.cost,
            solve.terminal_violation,
            solve.min_curvature,
            solve.terminal_attitude,
            solve.planned,
            _listed(solve.drift),
            _listed(solve.attitudes),
            _listed(solve.speeds),
            _listed(solve.accelerations),
            _listed(solve.torques),
            _listed(solve.terminal_multipliers),
        )


def _listed(values: Array | None) -> Any:
    return () if values is None else values


def _unwatched(state: WheelState, reference: Reference) -> Diagnosis:
    """Return the diagnosis of a method that watches no wheel: all count as answering."""
    m = len(state.wheel_speed)
    unknown = np.full(m, math.nan)
    return Diagnosis(
        np.ones(m, dtype=bool), unknown, unknown, unknown, Mode.NOMINAL, Rest.AT_TARGET,
        np.zeros(3), reference.attitude, 0.0,
    )  # fmt: skip
