"""When the plant steps: in lockstep with the controller, or on wall time.

Both paces decide from numbers handed in (steps, torques, wall time), touch neither ROS nor a clock,
and are therefore tested without either.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.types import Vector3

_RESEND_PERIOD = 0.25  # [s] wall: rclpy follows /clock best effort, so a tick can be lost


class Vehicle(Protocol):
    """What a pace drives."""

    step: int
    """Control step whose state was published last."""
    finished: bool
    """Every step was flown, or none more can be."""

    def begin(self) -> None:
        """Publish the initial state."""

    def advance(self, torque: Vector3, source: Source) -> None:
        """Apply a torque over one control period and publish the new state."""

    def repeat(self) -> None:
        """Publish the same bytes of the current state and clock again."""

    def event(self, text: str) -> None:
        """Tell people about something unwanted."""


@dataclass(slots=True)
class Tally:
    """What the wall clock saw."""

    latency: float = math.nan
    """State to torque, last step [s]."""
    slack: float = math.nan
    """Deadline minus arrival of the last torque [s]; NaN without a deadline."""
    missed: int = 0
    """Steps whose torque came too late or never."""
    held: int = 0
    """Steps over which an earlier or zero torque was applied instead."""


class Lockstep:
    """Step on when the torque of the current step is here, and only then.

    Parameters
    ----------
    vehicle : Vehicle
    command_timeout : float
        Wall time after which a missing torque is replaced by zero [s].
    window : int
        Steps that the plant may be ahead of the recorder; 0: there is none to wait for.
    """

    def __init__(self, vehicle: Vehicle, command_timeout: float, window: int) -> None:
        self._vehicle = vehicle
        self._command_timeout = command_timeout
        self._window = window
        self._recorded = 0
        self._pending: tuple[Vector3, Source] | None = None
        self._published = self._sent = 0.0
        self.tally = Tally()

    def begin(self, now: float) -> None:
        """Publish step 0 at wall time ``now`` [s]."""
        self._published = self._sent = now
        self._vehicle.begin()

    def torque(self, step: int, torque: Vector3, source: Source, now: float) -> str | None:
        """Take a torque; return why it is refused, or None."""
        vehicle = self._vehicle
        if step != vehicle.step or self._pending is not None:
            return f"torque of step {step} while step {vehicle.step} is due; required that step"
        self.tally.latency = now - self._published
        if self._window and vehicle.step - self._recorded >= self._window:
            self._pending = (torque, source)
            self._published = now  # from here on the recorder is the one waited for
        else:
            self._advance(torque, source, now)
        return None

    def recorded(self, step: int, now: float) -> None:
        """Take note that the recorder has come to ``step``."""
        self._recorded = step
        if self._pending is not None and self._vehicle.step - step < self._window:
            self._release(now)

    def tick(self, now: float) -> None:
        """Look at the wall clock: repeat after a stall, fall back after the time-out."""
        if self._vehicle.finished:
            return
        waited = now - self._published
        if waited >= self._command_timeout:
            self._give_up(waited, now)
        elif now - self._sent >= _RESEND_PERIOD:
            self._sent = now
            self._vehicle.repeat()

    def _give_up(self, waited: float, now: float) -> None:
        if self._pending is not None:
            self._vehicle.event(f"the recorder is silent for {waited:.1f} s; no longer waiting")
            self._window = 0
            self._release(now)
            return
        self.tally.missed += 1
        self.tally.held += 1
        self._vehicle.event(
            f"no torque for step {self._vehicle.step} within {waited:.1f} s; zero torque applied"
        )
        self._advance(np.zeros(3), Source.ZERO, now)

    def _release(self, now: float) -> None:
        if self._pending is not None:
            torque, source = self._pending
            self._pending = None
            self._advance(torque, source, now)

    def _advance(self, torque: Vector3, source: Source, now: float) -> None:
        self._published = self._sent = now
        self._vehicle.advance(torque, source)


class FreeRun:
    """Step on a fixed schedule of wall time, with the torque that is there by then.

    Parameters
    ----------
    vehicle : Vehicle
    wall_period : float
        Control period divided by the real-time factor [s].
    max_held_steps : int
        Consecutive steps over which the last torque is held; zero torque after that.
    """

    def __init__(self, vehicle: Vehicle, wall_period: float, max_held_steps: int) -> None:
        self._vehicle = vehicle
        self._wall_period = wall_period
        self._max_held_steps = max_held_steps
        self._start = self._published = 0.0
        self._arrived: tuple[Vector3, Source] | None = None
        self._last: tuple[Vector3, Source] = (np.zeros(3), Source.ZERO)
        self._misses = 0
        self.tally = Tally()

    def begin(self, now: float) -> None:
        """Publish step 0 at wall time ``now`` [s], which starts the schedule."""
        self._start = self._published = now
        self._vehicle.begin()

    @property
    def deadline(self) -> float:
        """Wall time at which the current step ends [s]."""
        return self._start + (self._vehicle.step + 1) * self._wall_period

    def torque(self, step: int, torque: Vector3, source: Source, now: float) -> str | None:
        """Take a torque; return why it is refused, or None. A late one is counted already."""
        if step > self._vehicle.step:
            return f"torque of step {step} before step {self._vehicle.step} has ended"
        if step < self._vehicle.step:
            return None
        self.tally.latency = now - self._published
        self.tally.slack = self.deadline - now
        self._arrived = (torque, source)
        return None

    def recorded(self, step: int, now: float) -> None:
        """Take no note of the recorder: wall time waits for nobody."""

    def tick(self, now: float) -> None:
        """Step as often as the schedule asks."""
        while now >= self.deadline and not self._vehicle.finished:
            torque, source = self._due_torque()
            self._published = now
            self._vehicle.advance(torque, source)

    def _due_torque(self) -> tuple[Vector3, Source]:
        if self._arrived is not None:
            self._last, self._arrived = self._arrived, None
            self._misses = 0
            return self._last
        self._misses += 1
        self.tally.missed += 1
        self.tally.held += 1
        self.tally.latency = math.nan
        self.tally.slack = math.nan
        if self._misses > self._max_held_steps:
            return np.zeros(3), Source.ZERO
        return self._last
