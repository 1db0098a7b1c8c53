"""NMPC of the bus by torques, allocated to the wheels that answer.

The plan is that of a rigid body, J omega' = T - omega x J omega. The wheels make the torque

    B u = -(T + omega x A Js nu + A Js u_d),

B = A Js of the wheels that answer: the gyroscopic torque of all wheels is canceled, and so is what
the others do by themselves (u_d). With H = 0 this is J omega' = -A Js u. Of all accelerations that
make the torque, the pseudo-inverse gives the least ones.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import Command, Source
from spacecraft_gnc.ocp import ShootingSolver, Solution
from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.two_wheel.controllers.feedback.law import WheelFeedback
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Solve, Terminal, WheelReport
from spacecraft_gnc.vehicles.two_wheel.controllers.shooting.problem import torque_problem
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

MODEL: Final = "rigid_body"


class ShootingPilot:
    """Fly by the wheels that answer, which span three dimensions.

    Parameters
    ----------
    gyrostat : Gyrostat
        As believed, with its limits; its ``time_step`` is the control period.
    bandwidth, damping_ratio : float
        Of `WheelFeedback`, which flies where a solve fails; the bandwidth also gives the weights.
    horizon : int
        Steps.
    healthy : (m,) bools, optional
        Wheels that take commands. None: all.

    Raises
    ------
    ShapeError, ParameterError
        If the axes of these wheels do not span three dimensions.
    """

    def __init__(
        self,
        gyrostat: Gyrostat,
        bandwidth: float,
        damping_ratio: float,
        horizon: int,
        healthy: NDArray[np.bool_] | None = None,
    ) -> None:
        self.gyrostat = gyrostat
        self.feedback = WheelFeedback(gyrostat, bandwidth, damping_ratio, healthy)
        self.healthy = np.asarray(self.feedback.healthy)
        allocation = self.feedback.allocation[self.healthy]
        self.solver = ShootingSolver(torque_problem(gyrostat, allocation, bandwidth, horizon))
        self.reset()

    def warm_up(self) -> None:
        """Compile or load the kernels."""
        still = np.zeros(self.gyrostat.n_wheels)
        state = self.gyrostat.state_from_rate(np.eye(3), np.zeros(3), still)
        self.command(state, np.eye(3))
        self.feedback.acceleration(state, np.eye(3))
        self.reset()

    def reset(self) -> None:
        """Forget the warm start."""
        self._warm_start: Array | None = None

    def memory(self) -> tuple[Any, ...]:
        """Return the warm start."""
        return (self._warm_start,)

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the pilot did whose `memory` it is."""
        (self._warm_start,) = memory

    def command(self, state: WheelState, reference: Matrix3, own: Array | None = None) -> Command:
        """Return the accelerations (m,) of the control step that starts at ``state``.

        Parameters
        ----------
        state : WheelState
        reference : (3, 3) array
            Attitude to reach, body to inertial.
        own : (m,) array, optional
            Accelerations that the other wheels will have by themselves [rad/s^2]; None: none.
        """
        solution = self._solve(state, reference)
        if solution is not None and solution.converged:
            wanted = self._allocate(solution.torques[0], state, own)
            source = Source.OPTIMAL
        else:
            wanted, source = self.feedback.acceleration(state, reference), Source.FEEDBACK
        acceleration = self._within(wanted, state.wheel_speed)
        if not np.isfinite(acceleration).all():
            acceleration, source = np.zeros(self.gyrostat.n_wheels), Source.ZERO
        solve = None if solution is None else _told(solution, reference, self.healthy)
        return Command(acceleration, source, WheelReport(solve))

    def _solve(self, state: WheelState, reference: Matrix3) -> Solution | None:
        """Solve from the last solve's multipliers, and from zero where that fails.

        In the frame of the reference, in which its attitude is the identity: the weights are those
        of the body at the reference, wherever that is.
        """
        momentum = self.gyrostat.inertia @ state.angular_velocity
        problem = reference.T @ state.attitude, momentum
        warm, self._warm_start = self._warm_start, None
        try:
            solution = self.solver.solve(*problem, warm_start=warm)
            if warm is not None and not solution.converged:
                solution = self.solver.solve(*problem)
        except GncError:  # a state or reference that is no state: the feedback law deals with it
            return None
        self._warm_start = solution.warm_start
        return solution

    def _allocate(self, torque: Vector3, state: WheelState, own: Array | None) -> Array:
        held = self.gyrostat.wheel_momentum(state.wheel_speed)
        needed = torque + np.cross(state.angular_velocity, held)
        if own is not None:
            needed = needed + self.gyrostat.wheels @ own
        return np.asarray(self.feedback.allocation @ needed)

    def _within(self, wanted: Array, speed: Array) -> Array:
        """Scale accelerations to their limit, which keeps the direction; cut at that of speed."""
        most = self.gyrostat.max_acceleration or math.inf
        size = float(np.abs(wanted).max())
        scaled = wanted * (most / size) if size > most else wanted
        top = np.maximum(self.gyrostat.max_speed or math.inf, np.abs(speed))
        period = self.gyrostat.time_step
        return np.clip(scaled, (-top - speed) / period, (top - speed) / period)


def _told(solution: Solution, reference: Matrix3, healthy: NDArray[np.bool_]) -> Solve:
    """Return a solution as it is published."""
    attitudes = reference @ solution.attitudes
    return Solve(
        method="shooting",
        model=MODEL,
        solver="shooting",
        status=solution.status,
        terminal=Terminal.FREE,
        iterations=solution.iterations,
        restarts=0,
        residual=solution.residual,
        cost=solution.cost,
        terminal_violation=lie.angle_between(attitudes[-1], reference),
        min_curvature=solution.min_curvature,
        terminal_attitude=reference,
        planned=healthy,
        attitudes=attitudes,
        solve_time=solution.solve_time,
        torques=solution.torques,
    )
