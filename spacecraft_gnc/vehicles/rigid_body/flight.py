"""Record of a rigid body's flight."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.loop.flight import Flight, Moment, Step, column, final
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.controllers.report import plan_of

if TYPE_CHECKING:  # the solvers' kernels take long to import
    from spacecraft_gnc.governors.planned.report import PlanReport
    from spacecraft_gnc.ocp.solution import Solution


def _solution(step: Step) -> Solution | None:
    report = step.command.report  # as `solution_of`, one call shorter
    return None if report is None else report.solution


def _plan(step: Step) -> PlanReport | None:
    return plan_of(step.command) or plan_of(step.decision)


def _external_torque(plant: Any) -> Any:
    """Return what disturbed the body over a step; None where the plant does not tell."""
    return getattr(plant, "external_torque", None)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class RigidBodyFlight(Flight):
    """Arrays of a flight: row k belongs to control step k, ``final_*`` to the end of the last step.

    Attributes
    ----------
    attitude : (n, 3, 3) array
        Rotation, body to inertial.
    momentum : (n, 3) array
        Angular momentum, body frame [N m s].
    torque : (n, 3) array
        Body torque held over the step [N m]: what the actuators gave of the command.
    external_torque : (n, 3) array
        Sum of the disturbances held over the step beside it, body frame [N m]; NaN where it was not
        recorded. The message of the next step carries it.
    reference : (n, 3, 3) array
        Attitude tracked, body to inertial.
    reference_rate, reference_torque : (n, 3) arrays
        Its feedforward: angular velocity [rad/s] and torque [N m], both in its own frame.
    target : (n, 3, 3) array
        Attitude that the governor is asked for, body to inertial; NaN where it is not known.
    iterations, status, source : (n,) arrays of int
        Of the solve behind the torque: iterations, 0 without a solve; `Command.status` as a number
        of `ocp.Status`, -1 without a solve; `loop.Source`.
    residual, cost, solve_time : (n,) arrays
        Residual of the optimality conditions, optimal cost of the horizon, wall time [s]; NaN
        without a solve.
    alpha, governor_margin : (n,) arrays
        Of the governor's decision: share of the way to the target, smallest margin of its
        prediction (infinite where nothing is predicted); NaN where it was not recorded.
    plan, plan_phase : (n,) arrays of int
        Number of the plan that is flown and `governors.planned.report.Phase`; -1: none.
    plan_error : (n,) array
        Angle between the attitude and the planned one [rad]; NaN without a plan.
    plan_torque, plan_momentum : (n, 3) arrays
        What the plan has for the step, body frame [N m], [N m s]; NaN without a plan.
    final_attitude, final_momentum, final_reference : (3, 3), (3,), (3, 3) arrays
        State at the end of the flight, and the last reference.
    """

    attitude: Array = column("state.attitude", (3, 3), carried_by="attitude_state/attitude")
    momentum: Array = column("state.momentum", (3,), carried_by="attitude_state/angular_momentum")
    torque: Array = column("applied", (3,), carried_by="torque_command/torque")
    external_torque: Array = column(
        _external_torque,
        (3,),
        carried_by="plant_invariants/external_torque",
        moment=Moment.OUTCOME,
        formerly=0.0,
    )
    reference: Array = column(
        "decision.reference.attitude", (3, 3), carried_by="attitude_reference/attitude"
    )
    reference_rate: Array = column(
        "decision.reference.angular_velocity",
        (3,),
        carried_by="attitude_reference/angular_velocity",
        formerly=0.0,
    )
    reference_torque: Array = column(
        "decision.reference.torque", (3,), carried_by="attitude_reference/torque", formerly=0.0
    )
    target: Array = column("target", (3, 3), carried_by="target_attitude/attitude")
    iterations: NDArray[np.int64] = column(
        "iterations", of=_solution, carried_by="solver_status/iterations", missing=0
    )
    residual: Array = column("residual", of=_solution, carried_by="solver_status/residual")
    cost: Array = column("cost", of=_solution, carried_by="solver_status/cost")
    solve_time: Array = column(
        "solve_time", of=_solution, carried_by="solver_status/wall_solve_time"
    )
    status: NDArray[np.int64] = column(
        "command.status", carried_by="solver_status/status", missing=-1
    )
    source: NDArray[np.int64] = column(
        "command.source", carried_by="torque_command/source", missing=-1
    )
    alpha: Array = column("decision.alpha", carried_by="governor_status/alpha")
    governor_margin: Array = column("decision.margin", carried_by="governor_status/margin")
    plan: NDArray[np.int64] = column(
        "number", of=_plan, carried_by="plan_status/number", missing=-1, formerly=-1
    )
    plan_phase: NDArray[np.int64] = column(
        "phase", of=_plan, carried_by="plan_status/phase", missing=-1, formerly=-1
    )
    plan_error: Array = column(
        "attitude_error", of=_plan, carried_by="plan_status/attitude_error", formerly=math.nan
    )
    plan_torque: Array = column(
        "torque", (3,), of=_plan, carried_by="plan_status/torque", formerly=math.nan
    )
    plan_momentum: Array = column(
        "momentum", (3,), of=_plan, carried_by="plan_status/momentum", formerly=math.nan
    )
    final_attitude: Array = final("state.attitude", (3, 3), carried_by="attitude_state/attitude")
    final_momentum: Array = final(
        "state.momentum", (3,), carried_by="attitude_state/angular_momentum"
    )
    final_reference: Array = final(
        "reference.attitude", (3, 3), carried_by="attitude_reference/attitude"
    )

    def __repr__(self) -> str:
        """Return the flight in one line."""
        if not self.n_steps:
            return "Flight(0 steps)"
        first = math.degrees(lie.angle_between(self.reference[0], self.attitude[0]))
        last = math.degrees(lie.angle_between(self.final_reference, self.final_attitude))
        largest = float(np.linalg.norm(self.torque, axis=1).max())
        solves, solved = np.count_nonzero(self.status >= 0), np.count_nonzero(self.status == 0)
        return (
            f"Flight({self.n_steps} steps of {self.period:g} s, {self.n_steps * self.period:g} "
            f"s in all, {first:.4g} to {last:.4g} deg from the reference, largest torque "
            f"{largest:.4g} N m, {solved} of {solves} solves converged)"
        )
