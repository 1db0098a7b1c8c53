"""Monitor of the plant's actuators: reports that they gave less than they were asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from spacecraft_gnc.nodes._governor_watch import Trouble
from spacecraft_gnc.plant.actuators import Actuators

_QUIET: Final = 1.0  # [s] simulated time between two reports


class SaturationWatch:
    """Looks at the actuators of every vehicle; simulated time alone counts, so flights repeat.

    The first step on which they gave less is told of, then each doubling of such steps, a second
    of simulated time apart or more.

    Parameters
    ----------
    plants
        Core of each vehicle by its name in the graph; one without limits has no ``actuators``.
    period
        Control period [s].
    """

    def __init__(self, plants: Mapping[str, Any], period: float) -> None:
        self._actuators: dict[str, Actuators] = {
            name: plant.actuators for name, plant in plants.items() if hasattr(plant, "actuators")
        }
        self._period = period
        self.reset()

    def reset(self) -> None:
        """Forget what was told."""
        self._told = 0
        self._since = -_QUIET

    def look(self, step: int) -> Trouble | None:
        """Return what is to be told after a step."""
        count = self._count()
        if count < max(2 * self._told, 1) or step * self._period - self._since < _QUIET:
            return None
        self._told, self._since = count, step * self._period
        return self._trouble(count, f"so far {_steps(count)}")

    def conclude(self, n_steps: int) -> Trouble | None:
        """Return what is to be told at the end of the flight."""
        count = self._count()
        return self._trouble(count, f"{count} of {_steps(n_steps)} in all") if count else None

    def _count(self) -> int:
        return sum(each.shortfalls for each in self._actuators.values())

    def _trouble(self, count: int, how_often: str) -> Trouble:
        last = {name: each.last for name, each in self._actuators.items() if each.last is not None}
        name, latest = max(last.items(), key=lambda item: item[1].step)
        whose = f"/{name}: actuators" if name else "actuators"
        return Trouble(
            f"{whose} saturated at {latest} ({how_often})",
            {"step": latest.step, "saturated_steps": count},
        )


def _steps(count: int) -> str:
    return "1 step" if count == 1 else f"{count} steps"
