"""Governor ``none``: the target is the reference."""

from __future__ import annotations

from typing import Any

from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.decision import DockingDecision, passed
from spacecraft_gnc.vehicles.docking.state import RelativeReference, RelativeState


class PassThroughGovernor:
    """Publish the target as the reference, at once.

    Parameters
    ----------
    target : (6,) array
        Port offset [m] and rotation vector [rad].
    """

    name = "none"
    slow = False

    def __init__(self, target: Array) -> None:
        self._first = RelativeReference.of(target)
        self.reset()

    @property
    def target(self) -> RelativeReference:
        """Reference that is finally wanted."""
        return self._target

    def set_target(self, target: RelativeReference) -> None:
        """Take a new target.

        Raises
        ------
        ParameterError
            If a number is not finite.
        """
        as_finite("target", target.vector, (6,), "6 finite numbers")
        self._target, self._decision = target, passed(target.vector)

    def warm_up(self) -> None:
        """Nothing to load."""

    def reset(self) -> None:
        """Return to the scenario's target."""
        self.set_target(self._first)

    def memory(self) -> tuple[Any, ...]:
        """Return the target."""
        return (self._target,)

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on toward the target of a `memory`."""
        self.set_target(RelativeReference(*memory[0]))

    def decide(self, state: RelativeState) -> DockingDecision:
        """Return the target, whatever the state."""
        del state
        return self._decision
