"""Repair of a truncated bag, and a record of its losses."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path
from typing import Final

import yaml
from mcap.records import Channel, McapRecord, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from spacecraft_gnc import __version__
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording._file import prepare_folder, stopped
from spacecraft_gnc.recording._files import MCAP_SUFFIX, bag_files, bag_in, damage
from spacecraft_gnc.recording.metadata import (
    DISTRO,
    GAPLESS,
    LOSSES_RECORD,
    RECOVERED_RECORD,
    ROSBAG2_RECORD,
    BagSummary,
    dump,
    write_metadata,
)
from spacecraft_gnc.recording.recover import Copy, WholeRecords
from spacecraft_gnc.recording.schema_text import fields
from spacecraft_gnc.recording.stamps import STEPPED_START, Topic
from spacecraft_gnc.signals import attitude, graph

_SPARSE: Final = {str(s) for s in (graph.WALL_TIMING, attitude.TARGET, attitude.ACCEPTED_TARGET)}
"""Topics without a message at most steps, in bags of versions that did not say so."""
_REPORT_EVERY: Final = 1000  # messages between two reports of the progress


@dataclass(slots=True)
class Rebuilt:
    """What was saved of a bag, and what is known to be missing.

    Attributes
    ----------
    folder
        The new bag.
    topics
        Saved messages by topic.
    last_whole_step
        Last control step of which every topic that speaks at every step was saved; None where no
        topic does.
    last_stamp
        Log time of the latest message [s].
    missing_steps
        Steps up to the last one saved that are not in the bag, by topic.
    cut_bytes
        Bytes of records that were cut off.
    damaged_chunks
        Chunks that were whole in length but not in content.
    orphans
        Messages left out, for no record before them tells their topic.
    """

    folder: Path
    topics: dict[str, int] = field(default_factory=dict)
    last_whole_step: int | None = None
    last_stamp: float = 0.0
    missing_steps: dict[str, int] = field(default_factory=dict)
    cut_bytes: int = 0
    damaged_chunks: int = 0
    orphans: int = 0

    @property
    def messages(self) -> int:
        """Saved messages of all topics."""
        return sum(self.topics.values())


def default_folder(source: Path) -> Path:
    """Return where a bag is rebuilt unless told otherwise: beside it."""
    named = source if source.name not in {"", ".."} else source.resolve()  # "." has no name
    return named.with_name(f"{named.name.removesuffix(MCAP_SUFFIX)}-recovered")


def rebuild(
    source: Path | str,
    folder: Path | str | None = None,
    progress: Callable[[int, int], None] = lambda _done, _total: None,
) -> Rebuilt:
    """Save what is whole of a bag that was cut off into a new bag.

    Messages, attachments and metadata are kept as they are; the new bag says in the record
    `RECOVERED_RECORD` that it was rebuilt.

    Parameters
    ----------
    source
        Bag folder, .mcap file, or the folder of a run of ``gnc launch`` with a bag in it.
    folder
        New bag, `default_folder` if None; it must not exist, or be empty.
    progress
        Called with bytes read and bytes in all.

    Raises
    ------
    RecordingError
        If there is no bag, it is whole already or holds no whole message, or the new one cannot be
        written. Nothing is left behind then.
    """
    source = bag_in(Path(source))
    with bag_files(source) as found:
        if not found.unfinished:
            raise RecordingError(
                f"{source}: received a whole bag; required one that was cut off; use it as it is"
            )
        target = default_folder(source) if folder is None else Path(folder)
        return _rebuild(source, target, found.files, progress)


def _rebuild(
    source: Path, target: Path, files: list[Path], progress: Callable[[int, int], None]
) -> Rebuilt:
    """Write the new bag; leave nothing behind where that fails."""
    made = prepare_folder(target)
    try:
        return _Rebuild(source, target).run(files, progress)
    except OSError as error:
        _remove(target, made)
        raise stopped(target, 0, error) from error
    except BaseException:
        _remove(target, made)
        raise


def _remove(folder: Path, made: bool) -> None:
    with suppress(OSError):
        for path in folder.iterdir():
            path.unlink()
        if made:
            shutil.rmtree(folder)


class _Rebuild:
    """One run of `rebuild`."""

    def __init__(self, source: Path, folder: Path) -> None:
        self._source = source
        self._path = folder / f"{folder.resolve().name}_0{MCAP_SUFFIX}"
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Topic] = {}
        self._topics: dict[str, Topic] = {}
        self._start_ns, self._end_ns = 2**63 - 1, 0
        self._distro = DISTRO
        self._result = Rebuilt(folder)

    def run(self, files: list[Path], progress: Callable[[int, int], None]) -> Rebuilt:
        """Copy the files, then close the bag."""
        with self._path.open("xb") as output:
            writer = Writer(output, compression=CompressionType.ZSTD, enable_data_crcs=True)
            writer.start(profile="ros2", library=f"spacecraft_gnc {__version__}, recovered")
            copy = Copy(writer)
            for file in files:
                self._copy(file, copy, progress)
            self._tell()
            if not self._result.messages:
                raise RecordingError(
                    f"{self._source}: received an unfinished bag without a whole message; required "
                    "at least one; record again"
                )
            writer.add_metadata(RECOVERED_RECORD, self._record())
            losses = {name: str(topic.lost) for name, topic in self._topics.items()}
            writer.add_metadata(LOSSES_RECORD, losses)
            summary = self._summary()
            text = dump(summary.information())
            writer.add_metadata(ROSBAG2_RECORD, {"serialized_metadata": text})
            writer.finish()  # type: ignore[no-untyped-call]
        write_metadata(self._result.folder, summary)
        return self._result

    def _copy(self, file: Path, copy: Copy, progress: Callable[[int, int], None]) -> None:
        copy.begin_file()
        with file.open("rb") as stream:
            records = WholeRecords(stream)
            for count, record in enumerate(self._intact(records)):
                if self._take(record):
                    copy.add(record)
                if count % _REPORT_EVERY == 0:
                    progress(stream.tell(), records.size)
        self._result.cut_bytes += records.cut
        self._result.damaged_chunks += records.damaged_chunks
        self._result.orphans += records.orphans

    def _intact(self, records: WholeRecords) -> Iterator[McapRecord]:
        """Yield records; what a parser raises becomes a RecordingError, what a disk raises not."""
        with damage(self._source):
            yield from records

    def _take(self, record: McapRecord) -> bool:
        """Note what a record tells; return whether it goes into the new bag as it is."""
        match record:
            case Schema():
                self._schemas[record.id] = record
            case Channel():
                self._channels[record.id] = self._topic(record)
            case Message():
                self._count(self._channels[record.channel_id], record)
            case Metadata() if record.name == LOSSES_RECORD:
                for name in record.metadata.keys() & self._topics.keys():
                    self._topics[name].reported = int(record.metadata[name])
                return False
            case Metadata() if record.name == ROSBAG2_RECORD:
                told = yaml.safe_load(record.metadata.get("serialized_metadata", "")) or {}
                self._distro = told.get("ros_distro") or DISTRO
                return False
        return True

    def _topic(self, channel: Channel) -> Topic:
        schema = self._schemas.get(channel.schema_id)
        text = schema.data.decode(errors="replace") if schema is not None else ""
        # Timing is reported by wall time in lockstep; a bag of an older version does not say so.
        assumed = str(channel.topic.rpartition("/")[2] not in _SPARSE).lower()
        return self._topics.setdefault(
            channel.topic,
            Topic(
                channel.id,
                schema.name if schema is not None else "",
                channel.metadata.get("offered_qos_profiles", ""),
                channel.metadata.get("topic_type_hash", ""),
                stepped=[*fields(text)][:2] == STEPPED_START,
                gapless=channel.metadata.get(GAPLESS, assumed) == "true",
            ),
        )

    def _count(self, topic: Topic, message: Message) -> None:
        topic.messages += 1
        if topic.stepped:
            topic.count_step(message.data)
        self._start_ns = min(self._start_ns, message.log_time)
        self._end_ns = max(self._end_ns, message.log_time)

    def _tell(self) -> None:
        """Sum up what was saved."""
        result = self._result
        result.topics = {name: topic.messages for name, topic in self._topics.items()}
        result.last_stamp = self._end_ns * 1e-9
        every = {name: t for name, t in self._topics.items() if t.stepped and t.gapless}
        result.missing_steps = {name: topic.gaps for name, topic in every.items() if topic.gaps}
        ends = [topic.next_step for topic in every.values() if topic.messages]
        result.last_whole_step = min(ends) - 1 if ends else None

    def _record(self) -> dict[str, str]:
        result = self._result
        return {
            "source": str(self._source),
            "at": datetime.now(timezone.utc).isoformat(timespec="seconds"),
            "by": f"spacecraft_gnc {__version__}",
            "messages": str(result.messages),
            "last_whole_step": ""
            if result.last_whole_step is None
            else f"{result.last_whole_step}",
            "cut_bytes": str(result.cut_bytes),
            "damaged_chunks": str(result.damaged_chunks),
            "orphans": str(result.orphans),
        }

    def _summary(self) -> BagSummary:
        topics = [topic.summary(name) for name, topic in self._topics.items()]
        marks = {RECOVERED_RECORD: str(self._source)}
        return BagSummary(
            self._path.name, self._start_ns, self._end_ns, topics, self._distro, marks
        )
