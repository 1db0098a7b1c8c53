"""The seams of the closed loop: what a plant, a controller and a governor have to offer.

Nodes, `ClosedLoop` and users' own packages meet here. Units are SI; attitudes map body to inertial
components; torque and angular momentum are in the body frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from spacecraft_gnc.signals.signal import Signal
from spacecraft_gnc.types import GovernorDecision, Invariants, Matrix3, Reference, State, Vector3

if TYPE_CHECKING:  # a governor or a recorder needs no solver, whose kernels take long to import
    from spacecraft_gnc.ocp.solution import Solution, Status

__all__ = [
    "Command",
    "Controller",
    "Governor",
    "GovernorDecision",
    "Invariants",
    "Plant",
    "Reference",
    "Source",
    "Standstill",
    "State",
]


class Source(IntEnum):
    """Where a torque command comes from (equal to TorqueCommand.msg).

    Either a rung of the fallback ladder, best first, or the method itself.
    """

    OPTIMAL = 0
    NEIGHBORING_EXTREMAL = 1
    SHIFTED_PLAN = 2
    FEEDBACK = 3
    ZERO = 4
    METHOD = 5
    """The method's own command, where it solves no optimal control problem."""

    @property
    def is_fallback(self) -> bool:
        """Whether the torque stands in for one that the method did not find."""
        return self in (Source.SHIFTED_PLAN, Source.FEEDBACK, Source.ZERO)


class Standstill(NamedTuple):
    """A loop that came to rest away from its target."""

    radius: float
    """Spectral radius of the closed loop linearised there; above 1 it is unstable [-]."""
    escaping: bool
    """Whether the command leaves it by a small torque added to the optimal one."""
    active_constraint: str
    """Constraint that it leans on: a zone's name, ``"torque limit"``, or empty."""


class Command(NamedTuple):
    """Torque for one control step, and where it comes from."""

    torque: Vector3
    """(3,) body torque [N m]."""
    source: Source = Source.METHOD
    solution: Solution | None = None
    """The solve behind the command; None where none was made."""
    standstill: Standstill | None = None
    """The standstill that the loop is at; None: at none, or none was looked for."""

    @property
    def is_fallback(self) -> bool:
        """As `Source.is_fallback`; another package's method may give the number alone."""
        return Source(self.source).is_fallback

    @property
    def status(self) -> Status | None:
        """How the step ended: the solve's status, or what the standstill says; None: no solve."""
        if self.solution is None:
            return None
        solved = self.solution.status
        if self.standstill is None:
            return solved
        statuses = type(solved)  # `ocp.Status`: to import it here would load the kernels
        return statuses.ESCAPING if self.standstill.escaping else statuses.STALLED


class Plant(Protocol):
    """A simulated vehicle, advanced one control step at a time."""

    period: float
    """Control period [s]."""
    n_steps: int
    """Control steps of the scenario."""

    @property
    def state(self) -> State:
        """State at the start of the current control step."""

    def step(self, torque: Vector3) -> State:
        """Hold ``torque`` (3,) [N m] for one control period and return the new state."""

    @property
    def idle_control(self) -> Vector3:
        """Control where no command came."""

    def outputs(self, applied: tuple[Vector3, Source]) -> Sequence[tuple[Signal, Any]]:
        """Return what a node publishes at the start of the current step, the state first.

        ``applied``: control and its source over the step that ended now.
        """

    def invariants(self) -> Invariants:
        """Invariants of the current state."""

    def angular_velocity(self) -> Vector3:
        """Body rate (3,) of the current state [rad/s]."""

    def warm_up(self) -> None:
        """Compile or load everything that `step` needs."""

    def reset(self) -> None:
        """Return to the initial state."""


class Controller(Protocol):
    """A torque law: state and reference in, command out; it never raises in flight."""

    period: float
    """Control period [s]."""
    name: str
    """Method name, as in the scenario's ``method:``."""
    slow: bool
    """Whether a command may take longer than some milliseconds: a node then computes it in a
    thread of its own, and never two at a time. A class may also declare its ``traits``
    (`loop.traits.MethodTraits`)."""

    def warm_up(self) -> None:
        """Compile or load everything that `command` needs."""

    def reset(self) -> None:
        """Forget the past: the next command starts cold."""

    def command(self, state: State, reference: Reference) -> Command:
        """Torque for the control step that starts at ``state``."""


class Governor(Protocol):
    """Shapes the reference so that the loop behind it keeps its constraints."""

    name: str
    """Law, as in the scenario's ``governor:``."""
    slow: bool
    """Whether a decision may take longer than some milliseconds: a node then makes it in a thread
    of its own, and never two at a time."""

    @property
    def target(self) -> Matrix3:
        """Attitude (3, 3) that is finally wanted, body to inertial."""

    def set_target(self, attitude: Matrix3) -> None:
        """Ask for a new target attitude (3, 3), body to inertial.

        Raises
        ------
        GncError
            If it is inadmissible, with the reason and the margin; the last target then stays.
        """

    def warm_up(self) -> None:
        """Compile or load everything that `decide` needs."""

    def reset(self) -> None:
        """Forget the past."""

    def decide(self, state: State) -> GovernorDecision:
        """Return the reference for the control step that starts at ``state``."""
