"""Pass-through governor: the reference is the target."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from spacecraft_gnc.types import (
    ArrayLike,
    GovernorDecision,
    Matrix3,
    Reference,
    State,
    as_rotation,
    read_only,
)


class PassThroughGovernor:
    """Publish the target attitude as the reference, at once.

    Parameters
    ----------
    target : (3, 3) array
        Target attitude, body to inertial.
    """

    name = "none"
    slow = False

    def __init__(self, target: ArrayLike) -> None:
        self._initial = as_rotation("target", target)
        self._target = self._initial
        self._decision = self._decide()

    @property
    def target(self) -> Matrix3:
        """Target attitude (3, 3), body to inertial."""
        return self._target

    def set_target(self, attitude: Matrix3) -> None:
        """Take a new target attitude (3, 3), body to inertial."""
        self._target = as_rotation("target", attitude)
        self._decision = self._decide()

    def warm_up(self) -> None:
        """Nothing to compile."""

    def reset(self) -> None:
        """Return to the target of the scenario."""
        self.set_target(self._initial)

    def memory(self) -> tuple[Any, ...]:
        """Return the target."""
        return (self._target,)

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on toward the target of a `memory`."""
        self.set_target(*memory)

    def decide(self, state: State) -> GovernorDecision:
        """Return the target, whatever the state."""
        del state
        return self._decision

    def _decide(self) -> GovernorDecision:
        zero = read_only(np.zeros(3))
        reference = Reference(self._target, zero, zero)
        return GovernorDecision(reference, 1.0, True, math.inf, "", 0)
