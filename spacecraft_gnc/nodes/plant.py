"""Node ``plant``: flies the simulated vehicles and owns simulated time."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticStatus

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.launcher import domain
from spacecraft_gnc.nodes._agent import Agent
from spacecraft_gnc.nodes._governor_watch import Trouble
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._pace import Applied, FreeRun, Lockstep
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes._saturation_watch import SaturationWatch
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.signals import Refused
from spacecraft_gnc.signals.graph import (
    CLOCK,
    PLANT,
    READY,
    RECORDED,
    RECORDER,
    RECORDER_WINDOW,
    WALL_STATUS_PERIOD,
    WALL_TIMING,
)
from spacecraft_gnc.signals.members import role_of
from spacecraft_gnc.signals.message import period_ns, stamp_of

_TICK = 0.05  # [s] wall time between two looks at the clock in lockstep
_DIGITS = 20  # of a step, fewer
_WAITING_PERIOD = 5.0  # [s] wall time between two complaints before step 0


class PlantNode(GncNode):
    """Publishes states and ``/clock``, applies commands. The pace decides when (`_pace`)."""

    ROLE: ClassVar[str] = PLANT

    def build(self, scenario: Scenario) -> None:
        """Build the vehicles and the pace."""
        about = {"plant": self.get_fully_qualified_name()}
        lock = domain.claim(domain.CLOCK, self.context.get_domain_id(), about)
        self.on_close(lock.release)
        for text in self.fleet.warnings:
            self.get_logger().warning(text)
        self._agents = {
            name: Agent(name, one, self.fleet.craft_of(name))
            for name, one in self.fleet.agents.items()
        }
        self._commanded = {
            space: agent for agent in self._agents.values() for space in agent.commanded
        }
        first = next(iter(self._agents.values())).core
        self.n_steps, self._period = first.n_steps, first.period
        self._period_ns = period_ns(self._period)
        cores = {name: agent.core for name, agent in self._agents.items()}
        self._saturation = SaturationWatch(cores, self._period)
        self._awaited = {
            f"{self.place.root}/{name}"
            for name in self.members.names
            if role_of(name) in READY.publishers
        }
        self._free_run = scenario.plant.mode == "free_run"

    def open(self) -> None:
        """Create the endpoints."""
        for agent in self._agents.values():
            agent.open(self)
        self._admit = {
            space: self.listen(agent.seams.control, partial(self._on_command, space), space)
            for space, agent in self._commanded.items()
        }
        self._publish_clock = self.advertise(CLOCK).publish
        self._publish_timing = self.advertise(WALL_TIMING).publish
        self.listen(READY, self._on_ready)
        self.listen(RECORDED, self._on_recorded)
        wall_period = self._period / self.scenario.plant.real_time_factor
        self._tick_timer = self.every(wall_period if self._free_run else _TICK, self._on_tick)
        self._tick_timer.cancel()
        self.every(_WAITING_PERIOD, self._tell_what_is_missing)

    def start(self) -> None:
        """Return to the initial states; step 0 goes out once everybody is ready."""
        for agent in self._agents.values():
            agent.reset()
        self._saturation.reset()
        self.step = 0
        self._last_timing = 0.0
        self._begun = 0.0
        p = self.scenario.plant
        window = RECORDER_WINDOW if RECORDER in self.members.names else 0
        self._pace = (
            FreeRun(self, self._commanded, self._period / p.real_time_factor, p.max_held_steps)
            if self._free_run
            else Lockstep(self, self._commanded, p.command_timeout, window)
        )
        self._begin_if_ready()

    def stop(self) -> None:
        """Stop the wall clock."""
        self._tick_timer.cancel()

    def on_everyone_ready(self) -> None:
        """Own endpoints are matched."""
        self._begin_if_ready()

    # What arrives.

    def _on_ready(self, data: bytes) -> None:
        self._awaited.discard(READY.read(data)["data"])
        self._begin_if_ready()

    def _begin_if_ready(self) -> None:
        if not self.active or self._begun or self._awaited or self.missing():
            return
        self._begun = time.perf_counter()
        self._tick_timer.reset()
        self._pace.begin(self._begun)

    def _tell_what_is_missing(self) -> None:
        if self.active and not self._begun:
            self.get_logger().warning(
                f"step 0 waits for nodes: {sorted(self._awaited) or 'none'}, "
                f"for matches of topics: {list(self.missing()) or 'none'}"
            )

    def _on_command(self, space: str, data: bytes) -> None:
        agent = self._commanded[space]
        if not self.active or data == agent.last_commands[space]:
            return  # a repeated answer to a repeated state
        if self.finished:
            raise Refused(f"a command after the last of {self.n_steps} steps", "step")
        message = self._admit[space].decode(data)
        applied = Applied(*agent.seams.control.value(message))
        refusal = self._pace.command(space, message.step, applied, time.perf_counter())
        if refusal is not None:
            raise Refused(refusal, "step")
        agent.last_commands[space] = data

    def _on_recorded(self, data: bytes) -> None:
        if self.active:
            self._pace.recorded(self._step_in(RECORDED.read(data)["data"]), time.perf_counter())

    def _step_in(self, text: str) -> int:
        """Return the step that a recorder tells."""
        step = int(text) if text.isdecimal() and len(text) < _DIGITS else -1
        if not 0 <= step <= self.step:
            raise Refused(f"{text[:_DIGITS]!r}; required a step of 0 to {self.step}", "step")
        return step

    def _on_tick(self) -> None:
        if not self.active:
            return
        now = time.perf_counter()
        self._pace.tick(now)
        if now - self._last_timing >= WALL_STATUS_PERIOD:
            self._report_timing(now)

    # What the pace asks for.

    def begin(self) -> None:
        """Publish the initial states."""
        self._publish()

    def idle(self, space: str) -> Any:
        """Return the control of an agent, or of a craft, without a command."""
        return self._commanded[space].idle(space)

    def advance(self, applied: Mapping[str, Applied]) -> None:
        """Apply controls over one control period and publish the new states."""
        try:
            for agent in self._agents.values():
                agent.step(applied)
        except GncError as error:
            self.fail(error)
            return
        self.step += 1
        self._publish()
        self._tell(self._saturation.look(self.step))
        if self._free_run:
            self._report_timing(time.perf_counter())
        if self.step >= self.n_steps:
            self._finish()

    def repeat(self) -> None:
        """Publish the same bytes of the current states and clock again."""
        for agent in self._agents.values():
            agent.repeat()
        self._publish_clock(self._clock_bytes)

    def _finish(self) -> None:
        self._report_timing(time.perf_counter())
        self._tell(self._saturation.conclude(self.n_steps))
        tally = self._pace.tally
        self.get_logger().info(
            f"flew {self.n_steps} steps: {tally.missed} deadlines missed, {self.refused} messages "
            "rejected"
        )
        self._tick_timer.cancel()
        self.finished = True

    def event(self, text: str) -> None:
        """Log and diagnose something unwanted."""
        self.get_logger().warning(text)
        tally = self._pace.tally
        counts = {"step": self.step, "missed": tally.missed, "held": tally.held}
        self.diagnose(DiagnosticStatus.WARN, text, counts)

    def _tell(self, trouble: Trouble | None) -> None:
        if trouble is not None:
            self.get_logger().warning(trouble.text)
            stamp = stamp_of(self.step, self._period_ns)
            self.diagnose(DiagnosticStatus.WARN, trouble.text, trouble.values, stamp)

    def _publish(self) -> None:
        stamp = stamp_of(self.step, self._period_ns)
        self.keep_time(stamp, self.step)
        self._clock_bytes = CLOCK.encode(stamp, self.step, [stamp])
        for agent in self._agents.values():
            agent.tell(stamp, self.step)
        if self.step < self.n_steps:  # no tick at the last state: there is no step to make
            self._publish_clock(self._clock_bytes)

    def _report_timing(self, now: float) -> None:
        self._last_timing = now
        tally = self._pace.tally
        timing = (
            now - self._begun,
            tally.latency,
            tally.slack,
            tally.missed,
            tally.held,
            self.refused,
        )
        stamp = stamp_of(self.step, self._period_ns)
        self._publish_timing(WALL_TIMING.encode(stamp, self.step, timing))


def main() -> int:
    """Run the node until its scenario has been flown or it is told to end."""
    return run(PlantNode)


if __name__ == "__main__":
    raise SystemExit(main())
