"""Interfaces of a governor: the loop predictor and the router.

Attitudes map body to inertial components; all units are SI.
"""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

from spacecraft_gnc.types import Matrix3, Reference, State, Vector3

UNITS: Final = {
    "torque limit": "N m",
    "momentum limit": "N m s",
    "momentum condition (4)": "N m s",
    "invariant set": "J",
}
"""Unit of a constraint's margin; [rad] for the others."""


class Prediction(NamedTuple):
    """What becomes of the constraints if one reference is held from now on."""

    admissible: bool
    """Whether all are kept."""
    margin: float
    """Of the constraint that comes nearest to its bound, in its own unit (rad, N m, N m s, J);
    negative when it is violated."""
    constraint: str
    """Its name: "torque limit", "momentum limit", "momentum condition (4)", "invariant set",
    "convergence", "solver", or a zone's name."""
    violation_step: int
    """First predicted step that violates, 0 = now; -1 where none does."""


class Commanded(Protocol):
    """What a predictor reads of a command."""

    @property
    def control(self) -> Vector3:
        """Body torque (3,) [N m]."""

    @property
    def is_fallback(self) -> bool:
        """Whether the torque stands in for one that the method did not find."""


class Controller(Protocol):
    """What a predictor flies: a controller of attitude (`loop.protocols.Controller`)."""

    name: str
    period: float
    """Control period [s]."""
    slow: bool
    """Whether a command may take longer than some milliseconds."""

    def warm_up(self) -> None:
        """Compile or load everything that `command` needs."""

    def reset(self) -> None:
        """Forget the past: the next command starts cold."""

    def command(self, state: State, reference: Reference) -> Commanded:
        """Return the command of the control step that starts at ``state``."""


class Predictor(Protocol):
    """Flies the loop ahead under a constant reference."""

    horizon: int
    """Most steps of a prediction."""
    slow: bool
    """Whether a prediction may take longer than some milliseconds."""

    def warm_up(self) -> None:
        """Compile or load everything that `predict` needs."""

    def reset(self) -> None:
        """Forget the past."""

    def predict(self, state: State, reference: Matrix3, reserve: float = 0.0) -> Prediction:
        """Predict the loop from ``state`` under a constant ``reference`` (3, 3).

        Every constraint must hold with at least ``reserve``, relative to its limit (for zones:
        [rad]): a new reference needs a little, so that no rounding can make it infeasible once it
        is held.
        """


class Planner(Protocol):
    """Finds intermediate references where the shortest geodesic is barred."""

    def warm_up(self) -> None:
        """Prepare everything that `plan` needs."""

    def is_clear(self, start: Matrix3, end: Matrix3) -> bool:
        """Tell whether the whole geodesic between two references (3, 3) is admissible at rest."""

    def plan(self, start: Matrix3, end: Matrix3) -> tuple[Matrix3, ...] | None:
        """Return intermediate references (3, 3), ``end`` not included.

        Empty where the geodesic is clear; None where no way is found.
        """
