"""MCAP bag writer for a recorder: raw CDR bytes in, a rosbag2 folder out.

While a bag is open its folder holds one .mcap file and no metadata.yaml; `BagWriter.close` writes
metadata.yaml last and in one step. A folder without it is a bag that was cut off.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Final

from mcap.writer import CompressionType, Writer

from spacecraft_gnc import __version__
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording._append import appender
from spacecraft_gnc.recording._file import RecordFile, prepare_folder, refused_message, stopped
from spacecraft_gnc.recording.metadata import (
    DISTRO,
    GAPLESS,
    LOSSES_RECORD,
    ROSBAG2_RECORD,
    BagSummary,
    dump,
    write_metadata,
)
from spacecraft_gnc.recording.schema_text import canonical_name, fields
from spacecraft_gnc.recording.stamps import STEPPED_START, Topic, TopicCount

CHUNK_SIZE: Final = 256 * 1024  # [bytes]
FLUSH_PERIOD: Final = 0.5
"""A chunk is closed at this age, however small it is [s]; with a timer that calls
`BagWriter.flush` as often, a killed recorder loses less than a second."""
_MESSAGE_OVERHEAD = 31  # bytes that an MCAP message record adds to its payload


class BagWriter:
    """Write one rosbag2 bag (MCAP storage) of serialized messages, from one thread.

    Parameters
    ----------
    folder
        The bag: ``folder/NAME_0.mcap`` and, once closed, ``folder/metadata.yaml``. It must not
        exist, or be empty.
    name
        NAME; by default the folder's.
    compression
        Of the chunks: ``zstd``, ``lz4`` or ``none``.
    chunk_size
        Messages are compressed and indexed in chunks of about this size [bytes].

    Raises
    ------
    RecordingError
        Here and from every method: if the folder holds something, cannot be written, or its disk is
        full. After such an error the writer is closed; what was saved stays readable as an
        unfinished bag, and a bag without a message is removed.
    """

    def __init__(
        self,
        folder: Path | str,
        *,
        name: str | None = None,
        compression: str = "zstd",
        chunk_size: int = CHUNK_SIZE,
    ) -> None:
        self.folder = Path(folder)
        self.path = self.folder / f"{name or self.folder.resolve().name}_0.mcap"
        self._chunk_size = chunk_size
        self._topics: dict[str, Topic] = {}
        self._live: dict[str, Topic] = {}  # emptied on closing: write() needs no other check
        self._schema_ids: dict[str, int] = {}
        self._start_ns, self._end_ns = 2**63 - 1, 0
        self._pending = 0
        self._losses_changed = False
        self._saved_messages = 0
        self._due = time.monotonic() + FLUSH_PERIOD
        self._file: RecordFile | None = None
        self._made_folder = prepare_folder(self.folder)
        try:
            self._file = RecordFile(self.path)
        except OSError as error:
            raise self._fail(error) from error
        self._mcap = Writer(
            self._file,  # type: ignore[arg-type]  # it has all of IO that Writer uses
            chunk_size=2**62,  # chunks are closed here, by size and by age
            compression=CompressionType[compression.upper()],
            enable_data_crcs=True,  # any byte that changes is found by `_verify`
        )
        self._append = appender(self._mcap)
        with self._saving():
            self._mcap.start(profile="ros2", library=f"spacecraft_gnc {__version__}")

    def add_topic(
        self,
        topic: str,
        type_name: str,
        schema_text: str,
        *,
        qos_yaml: str = "",
        type_hash: str = "",
        gapless: bool = True,
    ) -> None:
        """Announce a topic; needed once before its first message.

        Parameters
        ----------
        topic
            Full name, ``/attitude_state``.
        type_name
            ``pkg/msg/Type``.
        schema_text
            Complete ``ros2msg`` definition (`recording.schema_text.schema_text`).
        qos_yaml
            Offered profiles of the publishers (`recording.qos.qos_yaml`).
        type_hash
            REP-2011 hash ``RIHS01_...``; readers check the definition against it.
        gapless
            Whether a control step without a message counts as a loss.
        """
        if topic in self._topics:
            return
        type_name = canonical_name(type_name)
        with self._saving():
            channel_id = self._mcap.register_channel(
                topic,
                "cdr",
                self._schema_id(type_name, schema_text),
                {
                    "offered_qos_profiles": qos_yaml,
                    "topic_type_hash": type_hash,
                    GAPLESS: str(gapless).lower(),
                },
            )
        stepped = [*fields(schema_text)][:2] == STEPPED_START
        self._topics[topic] = Topic(channel_id, type_name, qos_yaml, type_hash, stepped, gapless)
        self._live[topic] = self._topics[topic]

    def write(self, topic: str, log_time_ns: int, publish_time_ns: int, data: bytes) -> None:
        """Append one message.

        Parameters
        ----------
        topic
            A topic announced with `add_topic`.
        log_time_ns
            Reception on the bag's time line [ns, not negative]: simulated time, so that a player
            plays the flight and not the computation.
        publish_time_ns
            Time of publication [ns, not negative].
        data
            The serialized message with its encapsulation header.
        """
        entry = self._live.get(topic)
        if entry is None or log_time_ns < 0 or publish_time_ns < 0:
            raise refused_message(self.path, topic, entry is not None, log_time_ns, publish_time_ns)
        self._append(entry.channel_id, entry.messages, log_time_ns, publish_time_ns, data)
        entry.messages += 1
        if entry.stepped:
            entry.count_step(data)
        self._start_ns = min(self._start_ns, log_time_ns)
        self._end_ns = max(self._end_ns, log_time_ns)
        self._pending += len(data) + _MESSAGE_OVERHEAD
        if self._pending >= self._chunk_size or time.monotonic() >= self._due:
            self.flush()

    def report_loss(self, topic: str, lost: int) -> None:
        """Tell how many messages of a topic were lost, all in all, on their way to the writer."""
        self._topics[topic].reported = lost
        self._losses_changed = True

    def flush(self) -> None:
        """Hand everything written so far to the operating system: a killed process keeps it."""
        with self._saving():
            self._mcap.flush()  # type: ignore[no-untyped-call]
        if self._losses_changed:
            self._add_losses()
        self._saved_messages = sum(topic.messages for topic in self._topics.values())
        self._pending = 0
        self._due = time.monotonic() + FLUSH_PERIOD

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Store a file in the bag, for instance ``scenario.yaml`` (``application/yaml``)."""
        with self._saving():
            self._mcap.add_attachment(
                create_time=time.time_ns(),
                log_time=0,
                name=name,
                media_type=media_type,
                data=data,
            )

    def metadata(self, name: str, entries: Mapping[str, str]) -> None:
        """Store key-value pairs in the bag, for instance the versions of what flew."""
        with self._saving():
            self._mcap.add_metadata(name, dict(entries))

    @property
    def counts(self) -> dict[str, TopicCount]:
        """Messages, gaps, repeats and losses of each topic."""
        return {name: topic.count for name, topic in self._topics.items()}

    def close(self) -> None:
        """Finish the bag: index, footer, metadata.yaml. Closing twice does nothing."""
        if self._file is None:
            return
        self.flush()
        self._add_losses()
        with self._saving() as file:
            # Once, at the end: readers join records of one name, or take any of them.
            text = dump(self._summary().information())
            self._mcap.add_metadata(ROSBAG2_RECORD, {"serialized_metadata": text})
            self._mcap.finish()  # type: ignore[no-untyped-call]
            file.sync()
        try:
            self._close_file()
            write_metadata(self.folder, self._summary())
        except OSError as error:
            raise self._fail(error) from error

    def abort(self) -> None:
        """Save what was written but leave the bag unfinished; without a message, remove it."""
        if self._file is None:
            return
        with suppress(RecordingError):
            self.flush()
        self._close_file()
        self._remove_if_empty()

    def __enter__(self) -> BagWriter:  # noqa: PYI034  # Self is not in Python 3.10
        """Return the writer."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the bag; after an exception `abort` instead."""
        self.close() if error is None else self.abort()

    @contextmanager
    def _saving(self) -> Iterator[RecordFile]:
        """Make a group of records whole: committed together, or none of them."""
        if self._file is None:
            raise RecordingError(f"{self.path}: the bag is closed; open a new one to record more")
        try:
            yield self._file
            self._file.commit()
        except OSError as error:
            raise self._fail(error) from error

    def _fail(self, error: OSError) -> RecordingError:
        """Close the damaged bag and return the error to raise."""
        if self._file is not None:
            with suppress(OSError):
                self._file.rollback()
            with suppress(OSError):
                self._close_file()
        self._remove_if_empty()
        return stopped(self.path, self._saved_messages, error)

    def _close_file(self) -> None:
        file, self._file = self._file, None
        self._live.clear()
        if file is not None:
            file.close()

    def _remove_if_empty(self) -> None:
        if self._saved_messages:
            return
        with suppress(OSError):
            self.path.unlink(missing_ok=True)
            if self._made_folder:
                self.folder.rmdir()

    def _schema_id(self, type_name: str, schema_text: str) -> int:
        if type_name not in self._schema_ids:
            self._schema_ids[type_name] = self._mcap.register_schema(
                type_name, "ros2msg", schema_text.encode()
            )
        return self._schema_ids[type_name]

    def _add_losses(self) -> None:
        """Say what is missing; a later record of this name replaces an earlier one."""
        self.metadata(LOSSES_RECORD, {name: str(t.lost) for name, t in self._topics.items()})
        self._losses_changed = False

    def _summary(self) -> BagSummary:
        topics = [topic.summary(name) for name, topic in self._topics.items()]
        return BagSummary(self.path.name, self._start_ns, self._end_ns, topics, DISTRO)
