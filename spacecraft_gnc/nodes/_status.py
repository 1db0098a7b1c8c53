"""The status messages: layouts of several shapes, for their words and sequences have any length."""

from __future__ import annotations

import math

from spacecraft_gnc_msgs.msg import GovernorStatus, SolverStatus
from std_msgs.msg import Header

from spacecraft_gnc.loop.protocols import Command, GovernorDecision
from spacecraft_gnc.ros.cdr import Layout
from spacecraft_gnc.ros.convert import Stamp
from spacecraft_gnc.ros.topics import BODY_FRAME, INERTIAL_FRAME

_INERTIAL = Header(frame_id=INERTIAL_FRAME)
_BODY = Header(frame_id=BODY_FRAME)
_NO_SOLVE = [SolverStatus.NO_SOLVE, 0, *([math.nan] * 2), *([math.nan] * 6), *([math.nan] * 3)]


class GovernorStatusEncoder:
    """Serializes GovernorStatus; one layout for each name of a constraint."""

    def __init__(self) -> None:
        self._layouts: dict[str, Layout] = {}

    def encode(self, stamp: Stamp, step: int, decision: GovernorDecision) -> bytes:
        """Serialize the decision of one step."""
        name = decision.active_constraint
        layout = self._layouts.get(name)
        if layout is None:
            prototype = GovernorStatus(header=_INERTIAL, active_constraint=name)
            layout = self._layouts[name] = Layout(prototype)
        return layout.pack(
            [
                *stamp,
                step,
                decision.alpha,
                decision.admissible,
                decision.margin,
                decision.evaluations,
                decision.violation_step,
                decision.horizon,
                decision.waypoints,
            ]
        )


class SolverStatusEncoder:
    """Serializes SolverStatus; one layout for each shape of a horizon and each pair of words.

    Parameters
    ----------
    method
        The controller's name.
    horizon
        Steps of the horizon, for messages without a solve.
    """

    def __init__(self, method: str, horizon: int) -> None:
        self._method = method
        self._horizon = horizon
        self._layouts: dict[tuple[int, int, str, str], Layout] = {}

    def encode(self, stamp: Stamp, step: int, command: Command, wall: tuple[float, float]) -> bytes:
        """Serialize the solve behind a command, with its wall time and slack."""
        solution, status, standstill = command.solution, command.status, command.standstill
        if solution is None or status is None:
            plan = [math.nan] * (15 * self._horizon + 12)
            layout = self._layout(self._horizon, 0, "", "")
            return layout.pack([*stamp, step, *_NO_SOLVE, *plan, *wall])
        zone_margins = solution.zone_margins.tolist()
        constraint = standstill.active_constraint if standstill else ""
        shape = (len(solution.torques), len(zone_margins))
        return self._layout(*shape, solution.formulation, constraint).pack(
            [
                *stamp,
                step,
                int(status),
                solution.iterations,
                solution.residual,
                solution.cost,
                *solution.costates[0].tolist(),
                solution.torque_margin,
                *zone_margins,
                solution.min_curvature,
                standstill.radius if standstill else math.nan,
                *solution.attitudes.ravel().tolist(),
                *solution.momenta.ravel().tolist(),
                *solution.torques.ravel().tolist(),
                *wall,
            ]
        )

    def _layout(self, horizon: int, n_zones: int, formulation: str, constraint: str) -> Layout:
        key = (horizon, n_zones, formulation, constraint)
        layout = self._layouts.get(key)
        if layout is None:
            prototype = SolverStatus(
                header=_BODY,
                method=self._method,
                formulation=formulation,
                zone_margins=[0.0] * n_zones,
                active_constraint=constraint,
                predicted_attitudes=[0.0] * (9 * (horizon + 1)),
                predicted_momenta=[0.0] * (3 * (horizon + 1)),
                predicted_torques=[0.0] * (3 * horizon),
            )
            layout = self._layouts[key] = Layout(prototype)
        return layout
