"""Node ``recorder``: every message of the graph into a rosbag2 bag, bytes unchanged."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticStatus

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.nodes._bag_times import NOT_YET, BagTimes
from spacecraft_gnc.nodes._foreign import ForeignTopics
from spacecraft_gnc.nodes._losses import SequenceWatch, Unwatched
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._parameter_dump import ParameterDump
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.recording.stamps import step_of, time_in
from spacecraft_gnc.recording.writer import FLUSH_PERIOD, BagWriter
from spacecraft_gnc.ros.bag_topics import announce, middleware, scenario_text
from spacecraft_gnc.ros.graph_of import foreign_topics, signals_of, vehicle_signals
from spacecraft_gnc.ros.qos import plain_qos
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.provenance import (
    LOCK_ATTACHMENT,
    PARAMETERS_ATTACHMENT,
    RUN_RECORD,
    lock_file,
    run_record,
)
from spacecraft_gnc.scenario.recorded import DEFAULTS_ATTACHMENT, SCENARIO_ATTACHMENT
from spacecraft_gnc.signals import Refused, Signal
from spacecraft_gnc.signals.graph import (
    CLOCK,
    PLANT,
    READY,
    RECORDED,
    RECORDER,
    RECORDER_STRIDE,
)
from spacecraft_gnc.signals.guard import Guard
from spacecraft_gnc.signals.members import Seams, is_recorded_of
from spacecraft_gnc.signals.message import NS_PER_S
from spacecraft_gnc.signals.qos import RECORD

_SHOUT_PERIOD = 1.0  # [s] wall between two reports of lost messages

Record = Callable[[bytes, Mapping[str, Any]], None]
"""Writes one message; its info is that of rclpy."""


class RecorderNode(GncNode):
    """Writes raw messages; their times are simulated, so that two runs make equal bags."""

    ROLE: ClassVar[str] = RECORDER
    # Nobody waits for it, and waking up for each of a step's ten messages takes the processor from
    # those who do. Far shorter than what the plant may be ahead.
    GATHERS: ClassVar[float] = 0.005

    def build(self, scenario: Scenario) -> None:
        """Open the bag."""
        self._written = 0
        self._times = BagTimes(self.window, is_sealed=bool(self.key))
        self._early: dict[str, tuple[Record, bytes, Mapping[str, Any]]] = {}
        self._watches: dict[str, SequenceWatch] = {}
        self._admit: dict[str, Guard] = {}
        self._shouted = -_SHOUT_PERIOD
        parameters = scenario.recorder
        folder = parameters.storage_folder or time.strftime("bags/%Y-%m-%d-%H-%M-%S")
        self._bag = BagWriter(
            Path(folder),
            compression=parameters.compression,
            chunk_size=parameters.chunk_size,
        )
        self.on_close(self._finish_bag)
        self._bag.attach(SCENARIO_ATTACHMENT, "application/yaml", scenario_text(self.fleet))
        taken = self.fleet.stated_defaults().encode()
        self._bag.attach(DEFAULTS_ATTACHMENT, "application/yaml", taken)
        if lock := lock_file():
            self._bag.attach(LOCK_ATTACHMENT, "text/plain", lock)
        self._bag.metadata(RUN_RECORD, run_record(self.fleet, middleware()))
        others = [name for name in self.members.names if name != RECORDER]
        self._dump = ParameterDump(self, others, self._on_parameters)
        self._has_parameters = False

    def open(self) -> None:
        """Subscribe to everything that is to be recorded."""
        wanted = self.scenario.recorder.topics
        agent, one = next(iter(self.fleet.agents.items()))
        self._leading = agent, Seams.among(vehicle_signals(one.vehicle)).state
        for space, signal in signals_of(self.fleet):
            if is_recorded_of(signal, space, wanted):
                self._record(space, signal)
        if not is_recorded_of(self._leading[1], agent, wanted):
            states = self.listen(
                self._leading[1], lambda data: self._watch_time(states, data), agent
            )
        self._foreign = ForeignTopics(self, foreign_topics(self.fleet), self._on_foreign)
        self.listen(READY, _acknowledge)
        self._publish_recorded = self.advertise(RECORDED).publish
        self.every(FLUSH_PERIOD, self._flush)

    def start(self) -> None:
        """Record what is latched and came early."""
        for name, (record, data, info) in self._early.items():
            try:
                record(data, info)
            except Refused as refusal:
                self.refuse(name.strip("/"), str(refusal), refusal.kind)
        self._early.clear()
        self._foreign.look()

    def progress(self) -> int:
        """Messages written."""
        return getattr(self, "_written", 0)

    def missing(self) -> tuple[str, ...]:
        """Topics that still lack a counterpart, then nodes that have not told their parameters."""
        topics = super().missing()
        if topics or self._dump.done:
            return topics
        self._dump.ask()  # everybody is there and has declared them
        return (PARAMETERS_ATTACHMENT,)

    def _on_parameters(self) -> None:
        try:
            self._attach_parameters()
        except RecordingError as error:  # nothing may escape into the executor
            self.fail(error)
        self._check_ready()

    def _attach_parameters(self) -> None:
        if not self._has_parameters:
            self._has_parameters = True
            text = self._dump.text().encode()
            self._bag.attach(PARAMETERS_ATTACHMENT, "application/yaml", text)

    def _finish_bag(self) -> None:
        """Close the bag, and shout if it is not complete."""
        if not self._written:
            self._bag.abort()  # nothing that looks like a recording is left behind
            return
        if self.failure is None:  # else the bag may be closed already, and stays unfinished
            self._attach_parameters()
        self._bag.close()
        self.get_logger().info(f"{self._written} messages in {self._bag.folder}")
        lost = {name: count.lost for name, count in self._bag.counts.items() if count.lost}
        if lost:
            self.get_logger().error(f"MESSAGES LOST, the bag has gaps (messages by topic): {lost}")
        if self._foreign.waiting:
            names = ", ".join(self._foreign.waiting)
            self.get_logger().error(f"nobody published on {names}: nothing of it is in the bag")

    def _record(self, space: str, signal: Signal) -> None:
        """Announce a signal of an agent or a craft, and write what comes."""
        place = self.place.of_space(space)
        name = place.topic(signal)
        free_run = self.scenario.plant.mode == "free_run"
        # In free_run a late answer is no loss.
        gapless = signal.every_step and (not free_run or PLANT in signal.publishers)
        announce(self._bag, name, signal.type, [signal.qos], gapless=gapless)
        write = self._writer_of_graph(space, signal, name)
        is_one = self.members.publishers(signal, place.space(signal)) == 1
        is_of_graph = bool(signal.publishers)  # else it is the user's door
        watch = SequenceWatch(alone=bool(self.key) and is_one) if is_of_graph else Unwatched()
        record = self._counted(name, write, watch)
        qos = signal.qos if signal.is_latched else RECORD
        self._admit[name] = self.listen(signal, record, space, qos=qos, watch=watch)

    # The hot path: once for every message.

    def _counted(self, name: str, write: Record, watch: SequenceWatch) -> Record:
        """Return a callback that counts what is lost on the way."""
        self._watches[name] = watch
        see = watch.see

        def record(data: bytes, info: Mapping[str, Any]) -> None:
            if see(info):
                self._on_loss(name)
            try:
                write(data, info)
            except RecordingError as error:
                self.fail(error)

        return record

    def _writer_of_graph(self, space: str, signal: Signal, name: str) -> Record:
        """Return what writes a topic of the graph, whose times are simulated."""
        write, is_latched = self._bag.write, signal.is_latched
        leads = (space, signal) == self._leading
        last, latest = b"", NOT_YET
        times, guards = self._times, self._admit

        def record(data: bytes, info: Mapping[str, Any]) -> None:
            nonlocal last, latest
            if data == last:
                return  # a repeat after a stall
            if not self.active:
                if is_latched:
                    self._early[name] = (record, data, info)
                return
            stamp = times.of(guards[name], data, latest)
            last, latest = data, stamp
            write(name, stamp, stamp, data)
            self._written += 1
            if leads:
                self._keep_time(data)

        return record

    def _on_foreign(self, name: str, kind: Any, qos: Any, publishers: list[Any]) -> None:
        offered = [plain_qos(info.qos_profile) for info in publishers]
        type_name = publishers[0].topic_type
        announce(self._bag, name, type_name, offered, gapless=False)
        watch = SequenceWatch()
        record = self._counted(name, self._writer_of_foreign(name), watch)
        self.subscribe(name, kind, qos, record, watch)
        self.get_logger().info(f"records {name} too")

    def _writer_of_foreign(self, name: str) -> Record:
        """Return what writes another topic: at the time of reception, on the time line of the bag.

        That is simulated time wherever there is any, for a bag has one time line.
        """
        write, now = self._bag.write, self.get_clock().now
        wanted = self.scenario.recorder.topics
        agent, state = self._leading
        simulated = is_recorded_of(state, agent, wanted) or bool(self.count_publishers(CLOCK.name))

        def record(data: bytes, info: Mapping[str, Any]) -> None:
            if not self.active:
                return
            if simulated:
                stamp = now().nanoseconds
                write(name, stamp, stamp, data)
            else:
                write(name, info["received_timestamp"], info["source_timestamp"], data)
            self._written += 1

        return record

    def _watch_time(self, states: Guard, data: bytes) -> None:
        """Take the time from a state that is not recorded."""
        if self.active:
            states.decode(data)
            self._keep_time(data)

    def _keep_time(self, state: bytes) -> None:
        """Take the time from a state of the leading agent, and tell the plant how far we are."""
        stamp, step = time_in(state), step_of(state)
        if self._times.now < 0 or (step is not None and step % RECORDER_STRIDE == 0):
            self._publish_recorded(RECORDED.encode((0, 0), 0, [str(step)]))
        self._times.now = stamp
        self.keep_time(divmod(stamp, NS_PER_S), step or 0)

    # Beside it.

    def _on_loss(self, name: str) -> None:
        """Count lost messages in the bag; shout, but not for each of thousands."""
        self._bag.report_loss(name, self._watches[name].lost)
        now = time.monotonic()
        if now - self._shouted >= _SHOUT_PERIOD:
            self._shouted = now
            self._shout()

    def _shout(self) -> None:
        lost = {name: watch.lost for name, watch in self._watches.items() if watch.lost}
        total = sum(lost.values())
        text = f"MESSAGES LOST on the way to the recorder: {total} so far, by topic: {lost}"
        self.get_logger().error(text)
        self.diagnose(DiagnosticStatus.ERROR, text, {"lost_messages": total})

    def _flush(self) -> None:
        try:
            self._bag.flush()
        except RecordingError as error:
            self.fail(error)


def _acknowledge(_: bytes) -> None:
    """Take a node's readiness; DDS tells the node that it was heard."""


def main() -> int:
    """Run the node until it is told to end."""
    return run(RecorderNode)


if __name__ == "__main__":
    raise SystemExit(main())
