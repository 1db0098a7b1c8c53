"""Report of a rigid body's method beside its torque: solve and standstill."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from spacecraft_gnc.governors.planned.report import PlanReport
from spacecraft_gnc.loop.protocols import Command, GovernorDecision
from spacecraft_gnc.status import Status

if TYPE_CHECKING:  # the solvers' kernels take long to import
    from spacecraft_gnc.ocp.solution import Solution


class Standstill(NamedTuple):
    """A loop that came to rest away from its target."""

    radius: float
    """Spectral radius of the closed loop linearized there; above 1 it is unstable [-]."""
    escaping: bool
    """Whether the command leaves it by a small torque added to the optimal one."""
    active_constraint: str
    """Constraint that it leans on: a zone's name, ``"torque limit"``, or empty."""


class SolveReport(NamedTuple):
    """The solve behind a command."""

    solution: Solution | None
    """None where the solver refused the state or the reference."""
    standstill: Standstill | None = None
    """The standstill that the loop is at; None: at none, or none was looked for."""
    plan: PlanReport | None = None
    """The step along a plan; None where none is flown."""

    @property
    def status(self) -> Status | None:
        """How the step ended: the solve's status, or what the standstill says; None: no solve."""
        if self.solution is None:
            return None
        if self.standstill is None:
            return self.solution.status
        return Status.ESCAPING if self.standstill.escaping else Status.STALLED


def solution_of(command: Command) -> Solution | None:
    """Return the solve behind a command; None where none was made."""
    return None if command.report is None else command.report.solution


def plan_of(decided: Command | GovernorDecision) -> PlanReport | None:
    """Return the step along a plan behind a command or a decision; None where none is flown."""
    plan = decided.report if isinstance(decided, GovernorDecision) else _plan(decided.report)
    return plan if isinstance(plan, PlanReport) else None


def _plan(report: object) -> object:
    return getattr(report, "plan", None)
