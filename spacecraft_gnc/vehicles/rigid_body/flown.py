"""Protocol of a recorded flight of a rigid body, as its figures and report take it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from spacecraft_gnc.drawing.vehicle import FlownRun

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario
    from spacecraft_gnc.vehicles.rigid_body.telemetry import Telemetry


class Flown(FlownRun, Protocol):
    """One run."""

    @property
    def trajectory(self) -> Flight:
        """What was flown."""

    @property
    def telemetry(self) -> Telemetry:
        """What was recorded beside it."""

    @property
    def scenario(self) -> Scenario | None:
        """What flew; None: not known."""
