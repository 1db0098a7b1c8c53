"""Record of a flight of a spacecraft with wheels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.loop.flight import Flight, Step, column, final
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Mode, Rest
from spacecraft_gnc.vehicles.two_wheel.euler import to_euler_321


def _reported(name: str) -> Callable[[Step], Any]:
    """Return what reads an attribute of the method's report; None where there is none."""
    return lambda step: getattr(step.command.report, name, None)


def _of(part: str, name: str) -> Callable[[Step], Any]:
    """Return what reads an attribute of the report's solve or diagnosis; None without one."""
    return lambda step: getattr(getattr(step.command.report, part, None), name, None)


def _diagnosed(step: Step) -> Any:
    """Return the wheels that count as answering: all, where the method watches none."""
    told = _of("diagnosis", "healthy")(step)
    return np.ones(len(step.state.wheel_speed), dtype=bool) if told is None else told


def _held(name: str, otherwise: Any) -> Callable[[Step], Any]:
    """Return what reads an attribute of the diagnosis; ``otherwise`` where there is none."""
    read = _of("diagnosis", name)

    def value(step: Step) -> Any:
        told = read(step)
        return otherwise if told is None else told

    return value


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class WheelFlight(Flight):
    """Arrays of a flight: row k belongs to control step k, ``final_*`` to the end of the last step.

    Attributes
    ----------
    attitude : (n, 3, 3) array
        Rotation, body to inertial.
    angular_velocity : (n, 3) array
        Rate of the bus, body frame [rad/s].
    euler_321 : (n, 3) array
        Roll, pitch, yaw [rad].
    wheel_speed : (n, m) array
        Relative to the bus [rad/s].
    wheel_acceleration : (n, m) array
        Commanded, relative to the bus [rad/s^2].
    total_momentum : (n, 3) array
        Of bus and wheels, inertial frame [N m s].
    healthy : (n, m) array of bool
        Whether each wheel answers its command.
    diagnosed : (n, m) array of bool
        Whether each wheel counts as answering on board, once the command of the step is found.
    mode : (n,) array of int
        How it is flown (`controllers.report.Mode`); -1: not known.
    rest : (n,) array of int
        Where it can come to rest (`controllers.report.Rest`); -1: not known.
    remaining_rate : (n, 3) array
        Rotation that cannot be stopped, body frame [rad/s]; zero where rest is possible.
    pointing_loss : (n,) array
        Angle by which the pointing that can be held is off the target [rad].
    terminal_violation, cost : (n,) arrays
        Of the method's solve; NaN without one.
    terminal : (n,) array of int
        What the plan has to reach (`controllers.report.Terminal`); -1 without a solve.
    reference, target : (n, 3, 3) arrays
        Attitude tracked, and attitude that the governor is asked for, body to inertial.
    status, source, iterations : (n,) arrays of int
        Of the command: `Command.status` and iterations of the method's report, -1 and 0 without
        one; `loop.Source`.
    residual, solve_time : (n,) arrays
        Of the method's report; NaN without one.
    final_attitude, final_angular_velocity, final_wheel_speed : arrays
        State at the end of the flight.
    """

    attitude: Array = column("state.attitude", (3, 3), carried_by="wheel_state/attitude")
    angular_velocity: Array = column(
        "state.angular_velocity", (3,), carried_by="wheel_state/angular_velocity"
    )
    euler_321: Array = column(lambda step: to_euler_321(step.state.attitude), (3,))
    wheel_speed: Array = column("state.wheel_speed", (-1,), carried_by="wheel_state/wheel_speed")
    wheel_acceleration: Array = column(
        "command.control", (-1,), carried_by="wheel_command/acceleration"
    )
    total_momentum: Array = column(
        "state.total_momentum", (3,), carried_by="wheel_state/total_momentum"
    )
    healthy: NDArray[Any] = column(
        "state.healthy", (-1,), carried_by="wheel_state/healthy", missing=True
    )
    diagnosed: NDArray[Any] = column(
        _diagnosed, (-1,), carried_by="wheel_diagnosis/healthy", missing=True, formerly=True
    )
    mode: NDArray[Any] = column(
        _held("mode", Mode.NOMINAL), carried_by="wheel_diagnosis/mode", missing=-1, formerly=-1
    )
    rest: NDArray[Any] = column(
        _held("rest", Rest.AT_TARGET), carried_by="wheel_diagnosis/rest", missing=-1, formerly=-1
    )
    remaining_rate: Array = column(
        _held("remaining_rate", (0.0, 0.0, 0.0)),
        (3,),
        carried_by="wheel_diagnosis/remaining_rate",
        formerly=np.nan,
    )
    pointing_loss: Array = column(
        _held("pointing_loss", 0.0), carried_by="wheel_diagnosis/pointing_loss", formerly=np.nan
    )
    reference: Array = column(
        "decision.reference.attitude", (3, 3), carried_by="attitude_reference/attitude"
    )
    target: Array = column("target", (3, 3), carried_by="target_attitude/attitude")
    status: NDArray[Any] = column(
        "command.status", carried_by="wheel_solver_status/status", missing=-1
    )
    source: NDArray[Any] = column("command.source", carried_by="wheel_command/source", missing=-1)
    iterations: NDArray[Any] = column(
        _reported("iterations"), carried_by="wheel_solver_status/iterations", missing=0
    )
    residual: Array = column(_reported("residual"), carried_by="wheel_solver_status/residual")
    solve_time: Array = column(
        _reported("solve_time"), carried_by="wheel_solver_status/wall_solve_time"
    )
    cost: Array = column(
        _of("solve", "cost"), carried_by="wheel_solver_status/cost", formerly=np.nan
    )
    terminal_violation: Array = column(
        _of("solve", "terminal_violation"),
        carried_by="wheel_solver_status/terminal_violation",
        formerly=np.nan,
    )
    terminal: NDArray[Any] = column(
        _of("solve", "terminal"), carried_by="wheel_solver_status/terminal", missing=-1, formerly=-1
    )
    final_attitude: Array = final("state.attitude", (3, 3), carried_by="wheel_state/attitude")
    final_angular_velocity: Array = final(
        "state.angular_velocity", (3,), carried_by="wheel_state/angular_velocity"
    )
    final_wheel_speed: Array = final(
        "state.wheel_speed", (-1,), carried_by="wheel_state/wheel_speed"
    )

    def __repr__(self) -> str:
        """Return the flight in one line."""
        m = self.wheel_speed.shape[1]
        return (
            f"Flight({self.n_steps} steps of {self.period:g} s, "
            f"{self.n_steps * self.period:g} s in all, {m} wheels)"
        )
