"""Flight by two of the wheels: plans of `TwoWheelPlanner` as commands of all m."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import Command, Source
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Solve, WheelReport
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated import (
    UnderactuatedParameters,
    weights_of,
)
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.planner import (
    Plan,
    TwoWheelPlanner,
)
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.ocp.problem import WheelOcp
from spacecraft_gnc.vehicles.two_wheel.state import WheelState
from spacecraft_gnc.vehicles.two_wheel.wheels import read_only_mask


class TwoWheelPilot:
    """Fly by two wheels, without total momentum.

    Parameters
    ----------
    gyrostat : Gyrostat
        As believed, with its limits; its ``time_step`` is the control period.
    parameters : UnderactuatedParameters
    healthy : (m,) bools, optional
        The two wheels. None: all, which have to be two.

    Raises
    ------
    ShapeError, ParameterError, MissingDependency
        If they are not two, turn the bus about one axis only, or CasADi is missing for ipopt.
    """

    def __init__(
        self,
        gyrostat: Gyrostat,
        parameters: UnderactuatedParameters,
        healthy: NDArray[np.bool_] | None = None,
    ) -> None:
        every = np.ones(gyrostat.n_wheels, dtype=bool) if healthy is None else healthy
        self.gyrostat, self.healthy = gyrostat, read_only_mask(every)
        self.planner = planner_of(gyrostat, parameters, self.healthy)
        self.horizon = self.planner.ocp.horizon

    def warm_up(self) -> None:
        """Compile or load the kernels, for plans with a hard and with a soft end."""
        state = self.gyrostat.state_from_rate(
            np.eye(3), np.zeros(3), np.zeros(self.gyrostat.n_wheels)
        )
        self.command(state, lie.exp(np.array([0.1, 0.0, 0.0])))
        self.reset()

    def reset(self) -> None:
        """Forget the last plan."""
        self.planner.reset()

    def memory(self) -> tuple[Any, ...]:
        """Return that of the planner."""
        return self.planner.memory()

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the pilot did whose `memory` it is."""
        self.planner.recall(memory)

    def command(self, state: WheelState, reference: Matrix3, drift: Array | None = None) -> Command:
        """Return the accelerations (m,) of the control step that starts at ``state``.

        Parameters
        ----------
        state : WheelState
        reference : (3, 3) array
            Attitude to reach, body to inertial.
        drift : (N+1, 3) array, optional
            Rate that the other wheels give the bus over the horizon, body frame [rad/s].

        Notes
        -----
        A state or a reference that is none gives no acceleration.
        """
        acceleration = np.zeros(self.gyrostat.n_wheels)
        try:
            plan = self.planner.plan(
                state.step, state.attitude, state.wheel_speed[self.healthy], reference, drift
            )
        except GncError:
            self.reset()
            return Command(acceleration, Source.ZERO, WheelReport())
        acceleration[self.healthy] = plan.acceleration
        return Command(acceleration, plan.source, WheelReport(_told(plan, self.healthy, drift)))


def planner_of(
    gyrostat: Gyrostat, parameters: UnderactuatedParameters, healthy: NDArray[np.bool_]
) -> TwoWheelPlanner:
    """Return the planner of two wheels."""
    p = parameters
    options: dict[str, Any] = {"restarts": p.restarts, "seed": p.seed, "chord": p.chord}
    return TwoWheelPlanner(problem_of(gyrostat, p, healthy), p.solver, p.terminal, **options)


def problem_of(
    gyrostat: Gyrostat, parameters: UnderactuatedParameters, healthy: NDArray[np.bool_]
) -> WheelOcp:
    """Return the problem of two wheels."""
    p = parameters
    return WheelOcp(
        gyrostat.inertia,
        gyrostat.wheels[:, healthy],
        gyrostat.time_step,
        p.horizon,
        weights_of(p.prediction_model, p.attitude_weights),
        p.speed_weight,
        p.acceleration_weight,
        gyrostat.max_speed,
        gyrostat.max_acceleration,
        p.prediction_model,
        p.terminal_weight,
    )


def _told(plan: Plan, planned: NDArray[np.bool_], drift: Array | None) -> Solve:
    """Return a plan as it is published."""
    found = plan.solution
    return Solve(
        method="underactuated",
        model=found.ocp.model,
        solver=plan.solver,
        status=found.status,
        terminal=plan.terminal,
        iterations=found.iterations,
        restarts=found.restarts,
        residual=found.residual,
        cost=found.cost,
        terminal_violation=found.terminal_violation,
        min_curvature=found.min_curvature,
        terminal_attitude=found.reference,
        planned=planned,
        attitudes=found.attitudes,
        solve_time=found.solve_time,
        drift=drift,
        speeds=found.speeds,
        accelerations=found.accelerations,
        terminal_multipliers=None if found.soft else found.terminal_multipliers,
    )
