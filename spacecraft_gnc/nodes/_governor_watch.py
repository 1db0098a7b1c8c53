"""Monitor of the governor: reports once that a target cannot be reached."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from spacecraft_gnc import lie
from spacecraft_gnc.governors.prediction import UNITS
from spacecraft_gnc.loop.protocols import GovernorDecision, State
from spacecraft_gnc.types import Matrix3, Vector3

PATIENCE: Final = 50
"""Control steps at rest after which a reference that stays is stuck, and without trouble after
which the same trouble is told again."""


class Trouble(NamedTuple):
    """What is wrong, for people and for programs."""

    text: str
    values: dict[str, float | str]


class GovernorWatch:
    """Judges one decision after another; simulated time alone counts, so flights repeat.

    Parameters
    ----------
    tolerance
        Angle under which an attitude has arrived [rad].
    rate_tolerance
        Body rate under which the body is at rest [rad/s].
    """

    def __init__(self, tolerance: float, rate_tolerance: float) -> None:
        self._tolerance = tolerance
        self._rate_tolerance = rate_tolerance
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._rest: tuple[int, Matrix3] | None = None
        self._told = ""
        self._last_trouble = -PATIENCE

    def look(
        self, state: State, rate: Vector3, decision: GovernorDecision, target: Matrix3
    ) -> Trouble | None:
        """Return what is wrong, where it was not told already.

        Parameters
        ----------
        state : State
            That the decision was made for.
        rate : (3,) array
            Its body rate [rad/s].
        decision : GovernorDecision
        target : (3, 3) array
            Attitude that is finally wanted, body to inertial.
        """
        kind = self._kind(state, rate, decision, target)
        if not kind:
            if state.step - self._last_trouble >= PATIENCE:
                self._told = ""
            return None
        self._last_trouble = state.step
        if kind == self._told:
            return None
        self._told = kind
        return _trouble(kind, state, decision, target)

    def _kind(
        self, state: State, rate: Vector3, decision: GovernorDecision, target: Matrix3
    ) -> str:
        if not decision.admissible:
            return "inadmissible"
        return "stuck" if self._is_stuck(state, rate, decision, target) else ""

    def _is_stuck(
        self, state: State, rate: Vector3, decision: GovernorDecision, target: Matrix3
    ) -> bool:
        """Tell whether loop and reference have rested for long, away from the target."""
        reference = decision.reference.attitude
        if reference is target or not self._rests(state, rate, reference):
            self._rest = None
            return False
        if lie.angle_between(reference, target) <= self._tolerance:
            self._rest = None
            return False
        if self._rest is None or lie.angle_between(self._rest[1], reference) > self._tolerance:
            self._rest = state.step, reference
        return state.step - self._rest[0] >= PATIENCE

    def _rests(self, state: State, rate: Vector3, reference: Matrix3) -> bool:
        if math.sqrt(float(rate @ rate)) >= self._rate_tolerance:
            return False
        return lie.angle_between(state.attitude, reference) < self._tolerance


def _trouble(kind: str, state: State, decision: GovernorDecision, target: Matrix3) -> Trouble:
    error = math.degrees(lie.angle_between(decision.reference.attitude, target))
    constraint = decision.active_constraint or "none"
    what = {
        "inadmissible": "no reference keeps every constraint, not even the last one",
        "stuck": f"stuck {error:.4g} deg from the target",
    }
    margin = f"{decision.margin:.4g}"
    if kind == "inadmissible":  # else it may be that of another constraint
        margin += f" {UNITS.get(constraint, 'rad')}"
    text = f"{what[kind]}: {constraint}, margin {margin} (step {state.step})"
    values: dict[str, float | str] = {
        "trouble": kind,
        "step": state.step,
        "constraint": constraint,
        "margin": decision.margin,
        "target_error_deg": error,
    }
    return Trouble(text, values)
