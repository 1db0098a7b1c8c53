"""What the nodes of a rigid spacecraft publish at each step."""

from __future__ import annotations

import math
from typing import Any, Final

from spacecraft_gnc.loop.protocols import Command, GovernorDecision, Reference, State
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.signals.attitude import (
    ATTITUDE_ERROR,
    GOVERNOR_STATUS,
    POSE,
    REFERENCE,
    error_of,
    pose_of,
)
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant
from spacecraft_gnc.vehicles.rigid_body.signals import (
    INVARIANTS,
    SOLVER_STATUS,
    STATE,
    TORQUE,
    Motion,
    Torque,
)

Outputs = list[tuple[Signal, Any]]
"""Signals with their values, in the order in which they are published."""
_NO_SOLVE: Final = 255  # SolverStatus.NO_SOLVE
_NO_COSTATE: Final = [math.nan] * 6


def plant_outputs(plant: RigidBodyPlant, applied: Torque, pose_every: int) -> Outputs:
    """Return what the plant tells at the start of a step; the state first.

    Parameters
    ----------
    plant
        At that step.
    applied
        What acted over the step that ended now.
    pose_every
        Steps between two poses; 0: none.
    """
    state, invariants = plant.state, plant.invariants()
    outputs: Outputs = [
        (STATE, Motion(state, plant.angular_velocity())),
        (INVARIANTS, (*invariants, applied.torque, int(applied.source))),
    ]
    if pose_every and state.step % pose_every == 0:
        outputs.append((POSE, pose_of(state.attitude)))
    return outputs


def governor_outputs(decision: GovernorDecision) -> Outputs:
    """Return what the governor tells of a decision; the reference first."""
    return [(REFERENCE, decision.reference), (GOVERNOR_STATUS, decision)]


class ControllerOutputs:
    """What the controller tells of a command; the command first.

    Parameters
    ----------
    method
        The controller's name.
    horizon
        Steps of the horizon, for messages without a solve.
    """

    def __init__(self, method: str, horizon: int) -> None:
        self._method = method
        widths = (9 * horizon + 9, 3 * horizon + 3, 3 * horizon)
        self._no_plan = [[math.nan] * width for width in widths]

    def __call__(
        self, state: State, reference: Reference, command: Command, wall: tuple[float, float]
    ) -> Outputs:
        """Return the outputs; ``wall``: time of the solve and slack to the deadline [s]."""
        return [
            (TORQUE, command),
            (SOLVER_STATUS, self._status(command, wall)),
            (ATTITUDE_ERROR, error_of(state.attitude, reference)),
        ]

    def _status(self, command: Command, wall: tuple[float, float]) -> tuple[Any, ...]:
        """Return the fields of SolverStatus."""
        solution, status, standstill = command.solution, command.status, command.standstill
        if solution is None or status is None:
            nothing = (math.nan, math.nan, _NO_COSTATE, math.nan, (), math.nan, math.nan, "")
            return (self._method, "", _NO_SOLVE, 0, *nothing, *self._no_plan, *wall)
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
