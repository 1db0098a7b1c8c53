"""When the plant steps: in lockstep with the controllers, or on wall time.

Both paces decide from numbers handed in (steps, commands, wall time), touch neither ROS nor a
clock, and are therefore tested without either. A step waits for the command of each agent, or of
each of its craft where it has several.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from spacecraft_gnc.loop.protocols import Source

_RESEND_PERIOD = 0.25  # [s] wall: rclpy follows /clock best effort, so a tick can be lost


class Applied(NamedTuple):
    """What acts on one agent, or one of its craft, over a step."""

    control: Any
    source: Any
    """A `Source`; where this is of several craft together, a tuple with that of each."""


class Vehicles(Protocol):
    """What a pace drives."""

    step: int
    """Control step whose states were published last."""
    finished: bool
    """Every step was flown, or none more can be."""

    def begin(self) -> None:
        """Publish the initial states."""

    def idle(self, space: str) -> Any:
        """Return the control of an agent, or of a craft, without a command."""

    def advance(self, applied: Mapping[str, Applied]) -> None:
        """Apply controls over one control period and publish the new states."""

    def repeat(self) -> None:
        """Publish the same bytes of the current states and clock again."""

    def event(self, text: str) -> None:
        """Tell people about something unwanted."""


@dataclass(slots=True)
class Tally:
    """What the wall clock saw."""

    latency: float = math.nan
    """States to the last of their commands, last step [s]."""
    slack: float = math.nan
    """Deadline minus arrival of the last command [s]; NaN without a deadline."""
    missed: int = 0
    """Steps of which a command came too late or never."""
    held: int = 0
    """Steps over which an earlier or idle control was applied instead."""


class Lockstep:
    """Step on when the commands of the current step are here, and only then.

    Parameters
    ----------
    vehicles : Vehicles
    agents : collection of str
        Whose commands a step waits for.
    command_timeout : float
        Wall time after which a missing command is replaced by the idle control [s].
    window : int
        Steps that the plant may be ahead of the recorder; 0: there is none to wait for.
    """

    def __init__(
        self, vehicles: Vehicles, agents: Collection[str], command_timeout: float, window: int
    ) -> None:
        self._vehicles = vehicles
        self._agents = tuple(agents)
        self._command_timeout = command_timeout
        self._window = window
        self._recorded = 0
        self._commands: dict[str, Applied] = {}
        self._published = self._sent = 0.0
        self.tally = Tally()

    def begin(self, now: float) -> None:
        """Publish step 0 at wall time ``now`` [s]."""
        self._published = self._sent = now
        self._vehicles.begin()

    def command(self, agent: str, step: int, applied: Applied, now: float) -> str | None:
        """Take an agent's command; return why it is refused, or None."""
        current = self._vehicles.step
        if step != current or agent in self._commands:
            return f"command of step {step} while step {current} is due; required that step"
        self._commands[agent] = applied
        if len(self._commands) < len(self._agents):
            return None
        self.tally.latency = now - self._published
        if self._window and current - self._recorded >= self._window:
            self._published = now  # from here on the recorder is the one waited for
        else:
            self._advance(now)
        return None

    def recorded(self, step: int, now: float) -> None:
        """Take note that the recorder has come to ``step``."""
        self._recorded = max(self._recorded, step)
        if self._is_complete and self._vehicles.step - step < self._window:
            self._advance(now)

    def tick(self, now: float) -> None:
        """Look at the wall clock: repeat after a stall, fall back after the time-out."""
        if self._vehicles.finished:
            return
        waited = now - self._published
        if waited >= self._command_timeout:
            self._give_up(waited, now)
        elif now - self._sent >= _RESEND_PERIOD:
            self._sent = now
            self._vehicles.repeat()

    @property
    def _is_complete(self) -> bool:
        return len(self._commands) == len(self._agents)

    def _give_up(self, waited: float, now: float) -> None:
        if self._is_complete:
            self._vehicles.event(f"the recorder is silent for {waited:.1f} s; no longer waiting")
            self._window = 0
            self._advance(now)
            return
        self.tally.missed += 1
        self.tally.held += 1
        silent = [agent for agent in self._agents if agent not in self._commands]
        of = f" of {', '.join(silent)}" if any(silent) else ""
        self._vehicles.event(
            f"no command{of} for step {self._vehicles.step} within {waited:.1f} s; "
            "idle control applied"
        )
        for agent in silent:
            self._commands[agent] = Applied(self._vehicles.idle(agent), Source.ZERO)
        self._advance(now)

    def _advance(self, now: float) -> None:
        commands, self._commands = self._commands, {}
        self._published = self._sent = now
        self._vehicles.advance(commands)


class FreeRun:
    """Step on a fixed schedule of wall time, with the commands that are there by then.

    Parameters
    ----------
    vehicles : Vehicles
    agents : collection of str
        Who commands.
    wall_period : float
        Control period divided by the real-time factor [s].
    max_held_steps : int
        Consecutive steps over which the last command is held; the idle control after that.
    """

    def __init__(
        self, vehicles: Vehicles, agents: Collection[str], wall_period: float, max_held_steps: int
    ) -> None:
        self._vehicles = vehicles
        self._wall_period = wall_period
        self._max_held_steps = max_held_steps
        self._start = self._published = 0.0
        self._arrived: dict[str, Applied] = {}
        self._last = {agent: Applied(vehicles.idle(agent), Source.ZERO) for agent in agents}
        self._misses = dict.fromkeys(self._last, 0)
        self.tally = Tally()

    def begin(self, now: float) -> None:
        """Publish step 0 at wall time ``now`` [s], which starts the schedule."""
        self._start = self._published = now
        self._vehicles.begin()

    @property
    def deadline(self) -> float:
        """Wall time at which the current step ends [s]."""
        return self._start + (self._vehicles.step + 1) * self._wall_period

    def command(self, agent: str, step: int, applied: Applied, now: float) -> str | None:
        """Take a command; return why it is refused, or None. A late one is counted already."""
        if step > self._vehicles.step:
            return f"command of step {step} before step {self._vehicles.step} has ended"
        if step < self._vehicles.step:
            return None
        self.tally.latency = now - self._published
        self.tally.slack = self.deadline - now
        self._arrived[agent] = applied
        return None

    def recorded(self, step: int, now: float) -> None:
        """No-op: wall time does not wait for the recorder."""

    def tick(self, now: float) -> None:
        """Step as often as the schedule asks."""
        while now >= self.deadline and not self._vehicles.finished:
            applied = {agent: self._due(agent) for agent in self._last}
            if len(self._arrived) < len(applied):
                self.tally.missed += 1
                self.tally.held += 1
                self.tally.latency = self.tally.slack = math.nan
            self._arrived.clear()
            self._published = now
            self._vehicles.advance(applied)

    def _due(self, agent: str) -> Applied:
        arrived = self._arrived.get(agent)
        if arrived is not None:
            self._last[agent] = arrived
            self._misses[agent] = 0
            return arrived
        self._misses[agent] += 1
        if self._misses[agent] > self._max_held_steps:
            return Applied(self._vehicles.idle(agent), Source.ZERO)
        return self._last[agent]
