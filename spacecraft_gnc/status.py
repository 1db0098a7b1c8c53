"""How a solve ended and where a command comes from, in a module that loads no kernel."""

from __future__ import annotations

from enum import IntEnum
from typing import Final

NO_SOLVE: Final = 255
"""SolverStatus.NO_SOLVE: no solve was made."""


class Status(IntEnum):
    """How a solve ended; the values are those of SolverStatus.msg."""

    CONVERGED = 0
    MAX_ITERATIONS = 1
    LINE_SEARCH_FAILED = 2
    UNSOLVABLE_STEP = 3
    NOT_FINITE = 4
    SINGULAR = 5
    STALLED = 6
    ESCAPING = 7
    SADDLE = 8
    INFEASIBLE = 9

    @property
    def text(self) -> str:
        """The name in words, such as ``max iterations``."""
        return self.name.lower().replace("_", " ")

    @property
    def advice(self) -> str:
        """One sentence for a person: what happened and what to try."""
        return _ADVICE[self]


_ADVICE = {
    Status.CONVERGED: "The first-order conditions hold within the tolerance, at a minimum.",
    Status.MAX_ITERATIONS: "The iteration limit was reached: raise it, or start from a warm start.",
    Status.LINE_SEARCH_FAILED: "No step made progress: loosen the tolerance or the penalties.",
    Status.UNSOLVABLE_STEP: "The body turns too far in one step (Kalabic (3)): shorten it.",
    Status.NOT_FINITE: "A number overflowed: check the weights and the state.",
    Status.SINGULAR: "The Jacobian is singular: start from another guess.",
    Status.STALLED: "The loop came to rest away from its target, at a local minimum of the cost.",
    Status.ESCAPING: "The loop leaves an unstable standstill by a small torque added to its own.",
    Status.SADDLE: "The solve ended at a saddle of the cost, not at a minimum: use another start.",
    Status.INFEASIBLE: "No torque within the limit reaches the terminal set: lengthen the horizon.",
}


class Source(IntEnum):
    """Where a command comes from (equal to TorqueCommand.msg).

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
