"""Protocol of a vehicle's own part of the live page."""

from __future__ import annotations

from typing import Any, Protocol


class VehicleLive(Protocol):
    """What the live page draws of a vehicle."""

    def constants(self, scenario: Any) -> dict[str, Any]:
        """Return what stays the same all along: fields of `analysis.live.picture.Setup`.

        ``strip`` is (title, unit, names of the values): what is drawn over time in place of
        momentum and torque.
        """

    def row(self, flight: Any, step: int) -> dict[str, Any]:
        """Return the values of a recorded step: ``momentum`` and ``torque``, or ``strip``."""

    def step(self, state: Any, control: Any) -> dict[str, Any]:
        """Return, likewise, those of a step that flies; ``control``: None where none came yet."""
