"""What a vehicle does for ``gnc replay`` without a graph: every recorded step solved again."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class VehicleReplay(Protocol):
    """Recorded steps beside the answers of another controller."""

    @property
    def control(self) -> str:
        """What a controller commands, in a word."""

    def resolve(
        self,
        flight: Any,
        recorded: Any,
        revised: Any,
        *,
        steps: tuple[int, int] | None = None,
        cold: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> Any:
        """Solve recorded steps again; the result has ``steps`` and ``first_difference``."""

    def compare(self, resolved: Any, recorded: Any, revised: Any) -> dict[str, Any]:
        """Return the comparison in numbers, ready for JSON."""

    def sides(self, old: dict[str, Any], new: dict[str, Any]) -> list[tuple[str, str, str]]:
        """Return the rows of a table: what it is, as flown, as replayed."""

    def differences(self, numbers: dict[str, Any], period: float) -> list[tuple[str, str]]:
        """Return the rows that hold for both together."""

    def figure(self, resolved: Any, names: tuple[str, str], title: str = "") -> Figure:
        """Draw both, and their difference."""
