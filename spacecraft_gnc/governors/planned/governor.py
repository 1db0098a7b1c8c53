"""Governor whose reference is the motion of a plan."""

from __future__ import annotations

import math
from typing import Any

from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.governors.planned.keeper import PlanKeeper
from spacecraft_gnc.types import GovernorDecision, Matrix3, State, as_rotation


class PlannedGovernor:
    """Publish the motion of an optimal transfer to the target as a moving reference.

    A new target is planned for in flight, and so is a state that is too far off the plan.

    Parameters
    ----------
    keeper : PlanKeeper
        Its first plan leads to the first target.
    """

    name = "planned"
    slow = False

    def __init__(self, keeper: PlanKeeper) -> None:
        self.keeper = require_kind("keeper", keeper, PlanKeeper)
        self._target = keeper.goal

    @property
    def target(self) -> Matrix3:
        """Target attitude (3, 3), body to inertial."""
        return self._target

    @property
    def waits(self) -> bool:
        """Whether a step waits for the plan that is due at it (`PlanKeeper`)."""
        return self.keeper.waits

    @waits.setter
    def waits(self, waits: bool) -> None:
        self.keeper.waits = waits

    def set_target(self, attitude: Matrix3) -> None:
        """Plan to another target (3, 3), body to inertial, from the step that is decided next.

        Raises
        ------
        GncError
            If it is no rotation; the last target then stays.
        """
        self._target = as_rotation("target", attitude)

    def warm_up(self) -> None:
        """Nothing to load: the first plan was made."""

    def reset(self) -> None:
        """Return to the first plan and its target."""
        self._target = self.keeper.goal
        self.keeper.reset()

    def memory(self) -> tuple[Any, ...]:
        """Return the target, and what the keeper keeps."""
        return self._target, self.keeper.memory()

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the governor did whose `memory` it is."""
        self._target, kept = memory
        self.keeper.recall(kept)

    def decide(self, state: State) -> GovernorDecision:
        """Return what of the plan belongs to the step that starts at ``state``."""
        step = self.keeper.look(state, self._target)
        self.keeper.seek(state)
        return GovernorDecision(step.reference, 1.0, True, math.inf, "", 0, report=step)
