"""What is told of a plan in flight: once when it is taken, and at each step that it is flown."""

from __future__ import annotations

from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

from spacecraft_gnc.types import Matrix3, Reference, Vector3

if TYPE_CHECKING:  # the planner's kernels take long to import
    from spacecraft_gnc.ocp.transfer import TransferSolution


class Cause(IntEnum):
    """Why a plan was made."""

    START = 0
    """The flight begins."""
    TARGET = 1
    """The target changed."""
    DEVIATION = 2
    """The body left what the plan before was made for."""


class Phase(IntEnum):
    """What becomes of a plan at a step."""

    FLYING = 0
    """It is tracked."""
    ARRIVED = 1
    """It has ended: its goal is held."""
    REPLANNING = 2
    """It is tracked while another one is sought."""
    NOT_FOUND = 3
    """It is tracked, or its goal held; no other one was found."""


class Planned(NamedTuple):
    """A plan that was taken."""

    number: int
    """0 for the first one of a flight."""
    first_step: int
    """Control step at which it starts."""
    cause: Cause
    solution: TransferSolution


class PlanReport(NamedTuple):
    """A step along a plan."""

    number: int
    """Of the plan."""
    plan_step: int
    """Steps since its start."""
    phase: Phase
    attitude_error: float
    """Angle between the state's attitude and the planned one [rad]."""
    momentum_error: Vector3
    """(3,) the state's momentum less the planned one [N m s], body frame."""
    attitude: Matrix3
    """(3, 3) planned, body to inertial."""
    momentum: Vector3
    """(3,) planned [N m s]."""
    torque: Vector3
    """(3,) planned for this step [N m]."""
    reference: Reference
    """Moving reference that keeps a body on the plan over this step."""
    nominal_torque: Vector3
    """(3,) what the tracking asks for, before the bounds are kept [N m]; NaN: nothing tracks."""
    told: tuple[Planned, ...] = ()
    """Plans taken at this step."""
