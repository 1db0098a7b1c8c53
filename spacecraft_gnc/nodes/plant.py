"""Node ``plant``: flies the simulated vehicle and owns simulated time."""

from __future__ import annotations

import time
from typing import ClassVar

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import UInt64

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.launcher import domain
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._pace import FreeRun, Lockstep
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.ros import convert
from spacecraft_gnc.ros.cdr import Layout
from spacecraft_gnc.ros.topics import (
    CLOCK,
    INVARIANTS,
    PLANT,
    POSE,
    READY,
    RECORDED,
    RECORDER,
    RECORDER_WINDOW,
    STATE,
    TORQUE,
    WALL_STATUS_PERIOD,
    WALL_TIMING,
)
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.types import Vector3

_TICK = 0.05  # [s] wall time between two looks at the clock in lockstep
_WAITING_PERIOD = 5.0  # [s] wall time between two complaints before step 0
_RECORDED = Layout(UInt64())


class PlantNode(GncNode):
    """Publishes states and ``/clock``, applies torques. The pace decides when (`_pace`)."""

    ROLE: ClassVar[str] = PLANT

    def build(self, scenario: Scenario) -> None:
        """Build the vehicle and the pace."""
        about = {"plant": self.get_fully_qualified_name()}
        lock = domain.claim(domain.CLOCK, self.context.get_domain_id(), about)
        self.on_close(lock.release)
        for text in scenario.warnings:
            self.get_logger().warning(text)
        self._plant = scenario.build_plant()
        self._plant.warm_up()
        self.n_steps = self._plant.n_steps
        self._period_ns = convert.period_ns(self._plant.period)
        self._pose_every = scenario.plant.pose_every
        self._awaited = set(scenario.plant.peers) & set(READY.publishers)
        self._free_run = scenario.plant.mode == "free_run"

    def open(self) -> None:
        """Create the endpoints."""
        self._publish_state = self.advertise(STATE).publish
        self._publish_invariants = self.advertise(INVARIANTS).publish
        self._publish_pose = self.advertise(POSE).publish
        self._publish_clock = self.advertise(CLOCK).publish
        self._publish_timing = self.advertise(WALL_TIMING).publish
        self.listen(TORQUE, self._on_torque)
        self.listen(READY, self._on_ready)
        self.listen(RECORDED, self._on_recorded)
        wall_period = self._plant.period / self.scenario.plant.real_time_factor
        self._tick_timer = self.every(wall_period if self._free_run else _TICK, self._on_tick)
        self._tick_timer.cancel()
        self.every(_WAITING_PERIOD, self._tell_what_is_missing)

    def start(self) -> None:
        """Return to the initial state; step 0 goes out once everybody is ready."""
        self._plant.reset()
        self.step = 0
        self._applied: tuple[Vector3, Source] = (np.zeros(3), Source.ZERO)
        self._last_torque = b""
        self._last_timing = 0.0
        self._begun = 0.0
        p = self.scenario.plant
        window = RECORDER_WINDOW if RECORDER in p.peers else 0
        self._pace = (
            FreeRun(self, self._plant.period / p.real_time_factor, p.max_held_steps)
            if self._free_run
            else Lockstep(self, p.command_timeout, window)
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
        self._awaited.discard(convert.decode_string(data))
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

    def _on_torque(self, data: bytes) -> None:
        if not self.active or data == self._last_torque:
            return  # a repeated answer to a repeated state
        try:
            command = convert.decode_torque(data)
            refusal = self._pace.torque(*command, time.perf_counter())
        except convert.Refused as error:
            refusal = str(error)
        if refusal is None:
            self._last_torque = data
        else:
            self.refuse(TORQUE, refusal)

    def _on_recorded(self, data: bytes) -> None:
        if self.active:
            self._pace.recorded(_RECORDED.read(data)[0], time.perf_counter())

    def _on_tick(self) -> None:
        if not self.active:
            return
        now = time.perf_counter()
        self._pace.tick(now)
        if now - self._last_timing >= WALL_STATUS_PERIOD:
            self._report_timing(now)

    # What the pace asks for.

    def begin(self) -> None:
        """Publish the initial state."""
        self._publish()

    def advance(self, torque: Vector3, source: Source) -> None:
        """Apply a torque over one control period and publish the new state."""
        try:
            self.step = self._plant.step(torque).step
        except GncError as error:
            self.fail(error)
            return
        self._applied = (torque, source)
        self._publish()
        if self._free_run:
            self._report_timing(time.perf_counter())
        if self.step >= self.n_steps:
            self._finish()

    def repeat(self) -> None:
        """Publish the same bytes of the current state and clock again."""
        self._publish_state(self._state_bytes)
        self._publish_clock(self._clock_bytes)

    def _finish(self) -> None:
        self._report_timing(time.perf_counter())
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

    def _publish(self) -> None:
        plant, step = self._plant, self.step
        stamp = convert.stamp_of(step, self._period_ns)
        self._state_bytes = convert.encode_state(stamp, plant.state, plant.angular_velocity())
        self._clock_bytes = convert.encode_clock(stamp)
        self._publish_state(self._state_bytes)
        self._publish_invariants(
            convert.encode_invariants(stamp, step, plant.invariants(), self._applied)
        )
        if self._pose_every and step % self._pose_every == 0:
            self._publish_pose(convert.encode_pose(stamp, plant.state))
        if step < self.n_steps:  # no tick at the last state: there is no control step to make
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
        stamp = convert.stamp_of(self.step, self._period_ns)
        self._publish_timing(convert.encode_wall_timing(stamp, self.step, timing))


def main() -> int:
    """Run the node until its scenario has been flown or it is told to end."""
    return run(PlantNode)


if __name__ == "__main__":
    raise SystemExit(main())
