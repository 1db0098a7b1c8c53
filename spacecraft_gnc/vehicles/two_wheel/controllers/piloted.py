"""A pilot of the wheels, alone, behind the `Controller` protocol."""

from __future__ import annotations

from typing import Any, Generic, Protocol, TypeVar

from spacecraft_gnc.loop.protocols import Command, Reference
from spacecraft_gnc.types import Matrix3
from spacecraft_gnc.vehicles.two_wheel.dynamics import Gyrostat
from spacecraft_gnc.vehicles.two_wheel.state import WheelState


class Pilot(Protocol):
    """Flies by some of the wheels."""

    gyrostat: Gyrostat
    """As believed; its ``time_step`` is the control period."""

    def warm_up(self) -> None:
        """Compile or load the kernels."""

    def reset(self) -> None:
        """Forget the past."""

    def memory(self) -> tuple[Any, ...] | None:
        """Return what `recall` takes up, as that of a `Controller`."""

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the pilot did whose `memory` it is."""

    def command(self, state: WheelState, reference: Matrix3, /) -> Command:
        """Return the accelerations (m,) [rad/s^2] of a control step, toward (3, 3)."""


P = TypeVar("P", bound=Pilot)


class PilotedController(Generic[P]):
    """A method that is one pilot; a subclass says its ``name``, ``slow`` and how it is built.

    Parameters
    ----------
    pilot : Pilot
    """

    def __init__(self, pilot: P) -> None:
        self.pilot = pilot
        self.period = pilot.gyrostat.time_step

    def warm_up(self) -> None:
        """Compile or load the kernels."""
        self.pilot.warm_up()

    def reset(self) -> None:
        """Forget the past."""
        self.pilot.reset()

    def memory(self) -> tuple[Any, ...] | None:
        """Return the pilot's."""
        return self.pilot.memory()

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the controller did whose `memory` it is."""
        self.pilot.recall(memory)

    def command(self, state: WheelState, reference: Reference) -> Command:
        """Wheel accelerations (m,) [rad/s^2] for the control step that starts at ``state``."""
        return self.pilot.command(state, reference.attitude)
