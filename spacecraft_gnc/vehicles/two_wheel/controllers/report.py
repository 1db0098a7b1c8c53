"""Report of a method of a spacecraft with wheels beside its command: solve and diagnosis."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.loop.protocols import Command
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Matrix3, Vector3


class Terminal(IntEnum):
    """What a plan has to reach at its end (equal to WheelSolverStatus.msg)."""

    REFERENCE = 0
    """Rest at the reference."""
    WAYPOINT = 1
    """Rest at a waypoint on the way to the reference."""
    SOFT = 2
    """Rest; the angle to the reference is a term of the cost."""
    FREE = 3
    """Nothing."""


class Mode(IntEnum):
    """How the spacecraft is flown (equal to WheelDiagnosis.msg)."""

    NOMINAL = 0
    """With all wheels."""
    REALLOCATED = 1
    """With fewer wheels, that still give torque about every axis."""
    UNDERACTUATED = 2
    """With wheels that give torque about two axes."""
    HOLDING = 3
    """Rest at the target is impossible: the best that can be held."""


class Rest(IntEnum):
    """Where the spacecraft can come to rest (equal to WheelDiagnosis.msg)."""

    AT_TARGET = 0
    ELSEWHERE = 1
    NOWHERE = 2


class Solve(NamedTuple):
    """One solve: what it was asked, and what it found."""

    method: str
    model: str
    """Of the prediction; ``rigid_body``: a plan of torques."""
    solver: str
    status: Status
    terminal: Terminal
    iterations: int
    restarts: int
    residual: float
    """Largest violation of the first-order conditions."""
    cost: float
    terminal_violation: float
    """Angle that the end of the plan is off ``terminal_attitude`` [rad]."""
    min_curvature: float
    """Smallest eigenvalue of the Hessian reduced to the free directions; NaN: not known."""
    terminal_attitude: Matrix3
    """(3, 3) that the plan is to end at, body to inertial."""
    planned: NDArray[np.bool_]
    """(m,) wheels that the plan uses; w of them."""
    attitudes: Array
    """(N + 1, 3, 3) over the horizon, body to inertial."""
    solve_time: float
    """Wall time [s]."""
    drift: Array | None = None
    """(N + 1, 3) rate that the other wheels give the bus, body frame [rad/s]; None: none."""
    speeds: Array | None = None
    """(N + 1, w) [rad/s]; None: a plan of torques."""
    accelerations: Array | None = None
    """(N, w) [rad/s^2]; None: a plan of torques."""
    torques: Array | None = None
    """(N, 3) on the bus, body frame [N m]; None: a plan of wheels."""
    terminal_multipliers: Array | None = None
    """(3,) of the terminal attitude condition; None: there is none."""


class Diagnosis(NamedTuple):
    """What is believed of the wheels, and what can therefore be held."""

    healthy: NDArray[np.bool_]
    """(m,) whether each wheel counts as answering."""
    residual: Array
    """(m,) change of speed over the last step less the one commanded [rad/s]; NaN: not known."""
    threshold: Array
    """(m,) largest residual of a healthy wheel [rad/s]; NaN: not known."""
    response: Array
    """(m,) share of the commanded change of speed that came [-]; NaN: not known."""
    mode: Mode
    rest: Rest
    remaining_rate: Vector3
    """(3,) rotation that cannot be stopped, body frame [rad/s]."""
    held_attitude: Matrix3
    """(3, 3) attitude that is held, body to inertial."""
    pointing_loss: float
    """Angle by which the held pointing is off the target [rad]."""


class WheelReport(NamedTuple):
    """What a method says beside its command."""

    solve: Solve | None = None
    """None where no solve was made."""
    diagnosis: Diagnosis | None = None
    """None where the method watches no wheel."""

    @property
    def status(self) -> Status | None:
        """How the solve ended; None: there was none."""
        return None if self.solve is None else self.solve.status

    @property
    def iterations(self) -> int:
        """Of the solve."""
        return 0 if self.solve is None else self.solve.iterations

    @property
    def residual(self) -> float:
        """Of the solve; NaN without one."""
        return math.nan if self.solve is None else self.solve.residual

    @property
    def solve_time(self) -> float:
        """Wall time of the solve [s]; NaN without one."""
        return math.nan if self.solve is None else self.solve.solve_time


def solve_of(command: Command) -> Solve | None:
    """Return the solve behind a command; None where none was made."""
    return command.report.solve if isinstance(command.report, WheelReport) else None


def diagnosis_of(command: Command) -> Diagnosis | None:
    """Return the diagnosis behind a command; None where the method watches no wheel."""
    return command.report.diagnosis if isinstance(command.report, WheelReport) else None
