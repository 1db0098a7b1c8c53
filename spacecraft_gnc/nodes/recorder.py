"""Node ``recorder``: every message of the graph into a rosbag2 bag, bytes unchanged."""

from __future__ import annotations

import struct
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import ClassVar

from std_msgs.msg import UInt64

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.nodes._bag_topics import announce, message_time, scenario_text
from spacecraft_gnc.nodes._cdr import Layout
from spacecraft_gnc.nodes._node import GncNode
from spacecraft_gnc.nodes._runner import run
from spacecraft_gnc.nodes._topics import (
    PLANT,
    RECORD,
    RECORDED,
    RECORDER,
    RECORDER_STRIDE,
    STATE,
    TOPICS,
    WALL_TIMING,
    Topic,
)
from spacecraft_gnc.recording._topic import step_of
from spacecraft_gnc.recording.run_info import SCENARIO_ATTACHMENT
from spacecraft_gnc.recording.writer import FLUSH_PERIOD, BagWriter
from spacecraft_gnc.scenario import Scenario

_STEP = Layout(UInt64())
_NOT_YET = -1  # [ns] simulated time before the first state


class RecorderNode(GncNode):
    """Writes raw messages; their times are simulated, so that two runs make equal bags."""

    ROLE: ClassVar[str] = RECORDER

    def build(self, scenario: Scenario) -> None:
        """Open the bag."""
        self._written = 0
        self._now = _NOT_YET
        self._early: dict[str, tuple[Callable[[bytes], None], bytes]] = {}
        parameters = scenario.recorder
        folder = parameters.storage_folder or time.strftime("bags/%Y-%m-%d-%H-%M-%S")
        self._bag = BagWriter(
            Path(folder),
            compression=parameters.compression,
            chunk_size=parameters.chunk_size,
        )
        self.on_close(self._finish_bag)
        self._bag.attach(SCENARIO_ATTACHMENT, "application/yaml", scenario_text(scenario))

    def open(self) -> None:
        """Subscribe to everything that is to be recorded."""
        wanted = self.scenario.recorder.topics
        for topic in TOPICS:
            if topic.is_recorded(wanted):
                name = self.resolve_topic_name(topic.name)
                announce(self._bag, name, topic)
                qos = topic.qos if topic.is_latched else RECORD
                self.listen(topic, self._writer(topic, name), qos)
        self._publish_recorded = self.advertise(RECORDED).publish
        self.every(FLUSH_PERIOD, self._flush)

    def start(self) -> None:
        """Record what is latched and came early."""
        for record, data in self._early.values():
            record(data)
        self._early.clear()

    def progress(self) -> int:
        """Messages written."""
        return getattr(self, "_written", 0)

    def _finish_bag(self) -> None:
        """Close the bag, and shout if it is not complete."""
        counts = self._bag.counts
        if self._written:
            self._bag.close()
            self.get_logger().info(f"{self._written} messages in {self._bag.folder}")
        else:
            self._bag.abort()  # nothing that looks like a recording is left behind
        gapless = {self.resolve_topic_name(topic.name) for topic in self._gapless()}
        lost = {n: count.gaps for n, count in counts.items() if count.gaps and n in gapless}
        if lost:
            self.get_logger().error(f"MESSAGES LOST, the bag has gaps (steps by topic): {lost}")

    def _gapless(self) -> Iterator[Topic]:
        """Yield the topics that were published at every step, so that a gap means a loss."""
        free_run = self.scenario.plant.mode == "free_run"
        for topic in TOPICS:
            # In free_run a late answer is no loss; timing is reported by wall time in lockstep.
            if topic is not WALL_TIMING and (not free_run or PLANT in topic.publishers):
                yield topic

    def _writer(self, topic: Topic, name: str) -> Callable[[bytes], None]:
        """Return the callback of one topic: the hot path, once for every message of the graph."""
        write, time_of = self._bag.write, message_time(topic)
        is_state = topic is STATE
        last = b""

        def record(data: bytes) -> None:
            nonlocal last
            if data == last:
                return  # a repeat after a stall
            if not self.active:
                if topic.is_latched:
                    self._early[name] = (record, data)
                return
            last = data
            try:
                stamp = max(self._now, 0) if time_of is None else time_of(data)
                write(name, stamp, stamp, data)
            except RecordingError as error:
                self.fail(error)
                return
            except struct.error:
                self.refuse(topic, f"{len(data)} bytes without a time stamp")
                return
            self._written += 1
            if is_state:
                self._tell_progress(data, first=self._now < 0)
                self._now = stamp

        return record

    def _tell_progress(self, state: bytes, *, first: bool) -> None:
        step = step_of(state)
        if step is not None and (first or step % RECORDER_STRIDE == 0):
            self._publish_recorded(_STEP.pack([step]))

    def _flush(self) -> None:
        try:
            self._bag.flush()
        except RecordingError as error:
            self.fail(error)


def main() -> int:
    """Run the node until it is told to end."""
    return run(RecorderNode)


if __name__ == "__main__":
    raise SystemExit(main())
