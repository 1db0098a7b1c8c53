"""Read access to a bag: rosbag2 folder, single .mcap file, or one that was cut off."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from mcap.reader import McapReader, make_reader
from rosbags.highlevel import AnyReader

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording import BAG_FOLDER
from spacecraft_gnc.recording._layout import Definitions
from spacecraft_gnc.recording._metadata import METADATA_NAME
from spacecraft_gnc.recording._scan import Progress, scan
from spacecraft_gnc.recording._verify import verify
from spacecraft_gnc.recording.qos import QosProfile
from spacecraft_gnc.recording.recover import MAGIC, rewrite

MCAP_SUFFIX: Final = ".mcap"
_REQUIRED: Final = "required a bag folder (with metadata.yaml) or a .mcap file"


class Bag:
    """An open bag; obtain it from `open_bag`.

    Attributes
    ----------
    path
        As the user named it.
    topics
        Type of each recorded topic, ``pkg/msg/Type`` by full topic name.
    unfinished
        Whether the bag was cut off.
    definitions
        Fields of the recorded types, as `_layout.decode` takes them.
    """

    def __init__(self, path: Path, reader: AnyReader, files: list[Path], unfinished: bool) -> None:
        self.path = path
        self.unfinished = unfinished
        self.topics = {connection.topic: connection.msgtype for connection in reader.connections}
        self.definitions: Definitions = reader.typestore.fielddefs
        self._reader = reader
        self._files = files

    def messages(self, topics: Collection[str]) -> Iterator[tuple[str, bytes]]:
        """Yield (topic, serialized message) in the order of the log times.

        Raises
        ------
        RecordingError
            If the file is damaged.
        """
        for _, topic, data in self.timed(topics):
            yield topic, data

    def recorded(
        self, topics: Collection[str], progress: Progress | None = None
    ) -> Iterator[tuple[str, bytes]]:
        """Yield (topic, serialized message) in the order of recording, each chunk checked.

        Raises
        ------
        RecordingError
            If the file is damaged.
        """
        for file in self._files:
            with _damage(self.path):
                yield from scan(file, topics, progress)

    def definition(self, topic: str) -> str:
        """Return the .msg text of a topic's type as recorded, nested types behind it."""
        found = next(item for item in self._reader.connections if item.topic == topic)
        return str(found.msgdef.data)

    def verify(self, progress: Progress | None = None) -> None:
        """Compare every checksum in the files with what they hold.

        Raises
        ------
        RecordingError
            If a byte has changed since the bag was recorded.
        """
        for file in self._files:
            with _damage(self.path):
                verify(file, progress)

    def timed(self, topics: Collection[str], from_ns: int = 0) -> Iterator[tuple[int, str, bytes]]:
        """Yield (log time [ns], topic, serialized message) in their order, from a log time on.

        Raises
        ------
        RecordingError
            If the file is damaged.
        """
        chosen = [item for item in self._reader.connections if item.topic in topics]
        if not chosen:  # an empty filter would mean every topic
            return
        with _damage(self.path):
            for connection, stamp, data in self._reader.messages(chosen, start=from_ns):
                yield stamp, connection.topic, bytes(data)

    @property
    def span_ns(self) -> tuple[int, int]:
        """Log times of the first and the last message [ns]; the last before the first: none."""
        return self._reader.start_time, self._reader.end_time - 1

    def offered_qos(self, topic: str) -> list[QosProfile]:
        """Return the recorded profiles of a topic's publishers."""
        found: list[Any] = []
        for connection in self._reader.connections:
            if connection.topic == topic:
                found += getattr(connection.ext, "offered_qos_profiles", [])
        return [_profile(qos) for qos in found]

    def type_hash(self, topic: str) -> str:
        """Return the REP-2011 hash of a topic's type, computed from the definition in the bag."""
        with _damage(self.path):
            return self._reader.typestore.hash_rihs01(self.topics[topic])

    def decode(self, topic: str, data: bytes) -> Any:
        """Return the message object; its type comes from the definitions in the bag.

        Raises
        ------
        RecordingError
            If the message does not follow its definition.
        """
        with _damage(self.path):
            return self._reader.deserialize(data, self.topics[topic])

    def attachments(self) -> dict[str, bytes]:
        """Return the attached files by name."""
        with _damage(self.path), self._readers() as readers:
            return {
                item.name: item.data for reader in readers for item in reader.iter_attachments()
            }

    def metadata(self) -> dict[str, dict[str, str]]:
        """Return the metadata records by name; a later record replaces an earlier one."""
        with _damage(self.path), self._readers() as readers:
            return {
                item.name: item.metadata for reader in readers for item in reader.iter_metadata()
            }

    @contextmanager
    def _readers(self) -> Iterator[list[McapReader]]:
        """Open the files once more, for the records that the bag reader leaves out."""
        with ExitStack() as stack:
            yield [make_reader(stack.enter_context(file.open("rb"))) for file in self._files]


def _profile(qos: Any) -> QosProfile:
    return QosProfile(
        history=qos.history.name.lower(),
        depth=qos.depth,
        reliability=qos.reliability.name.lower(),
        durability=qos.durability.name.lower(),
        deadline_ns=_nanoseconds(qos.deadline),
        lifespan_ns=_nanoseconds(qos.lifespan),
        liveliness=qos.liveliness.name.lower(),
        liveliness_lease_ns=_nanoseconds(qos.liveliness_lease_duration),
    )


def _nanoseconds(time: Any) -> int:
    return int(time.sec * 10**9 + time.nsec)


@contextmanager
def open_bag(path: Path | str, *, allow_unfinished: bool = False) -> Iterator[Bag]:
    """Open a bag for reading.

    Parameters
    ----------
    path
        Bag folder or .mcap file, or the folder of a run of ``gnc launch`` with a bag in it.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.

    Raises
    ------
    RecordingError
        If there is no bag, or it is empty, cut off, damaged or not of ROS 2.
    """
    path = bag_in(Path(path))
    with ExitStack() as stack:
        files = _storage_files(path)
        unfinished = _is_unfinished(path, files)
        source = path
        if unfinished:
            if not allow_unfinished:
                raise RecordingError(
                    f"{path}: received an unfinished bag (the recorder was killed, or the file is "
                    f"cut off); required a closed one; save what is whole: gnc recover {path}"
                )
            folder = Path(stack.enter_context(TemporaryDirectory(prefix="gnc_bag_")))
            source = folder / f"recovered{MCAP_SUFFIX}"
            _recover(path, files[-1], source)
            files = [source]
        with _damage(path):
            reader = stack.enter_context(AnyReader([source]))
        yield Bag(path, reader, files, unfinished)


def bag_in(path: Path) -> Path:
    """Return the bag in the folder of a run; any other path as it is."""
    bag = path / BAG_FOLDER
    is_bag = (path / METADATA_NAME).exists() or any(path.glob(f"*{MCAP_SUFFIX}"))
    return bag if bag.is_dir() and not is_bag else path


def _storage_files(path: Path) -> list[Path]:
    """Return the .mcap files of a bag, in order."""
    if path.is_dir():
        files = sorted(path.glob(f"*{MCAP_SUFFIX}"))
        if not files and not (path / METADATA_NAME).exists():
            raise RecordingError(
                f"{path}: received a folder without a bag; {_REQUIRED}; check the path"
            )
        return files
    if not path.exists():
        raise RecordingError(f"{path}: no such file or folder; {_REQUIRED}; check the path")
    if path.suffix != MCAP_SUFFIX:
        raise RecordingError(f"{path}: received another kind of file; {_REQUIRED}; check the path")
    return [path]


def _is_unfinished(path: Path, files: list[Path]) -> bool:
    for file in files:
        head, tail = _ends(file)
        if not head:
            raise RecordingError(f"{file}: received an empty file; {_REQUIRED}; record again")
        if head != MAGIC:
            raise RecordingError(
                f"{file}: received a file that is not MCAP; {_REQUIRED}; check the path"
            )
        if tail != MAGIC:
            return True
    return path.is_dir() and not (path / METADATA_NAME).exists()


def _ends(file: Path) -> tuple[bytes, bytes]:
    """Return the first and the last bytes of a file, as many as the magic has."""
    try:
        with file.open("rb") as stream:
            head = stream.read(len(MAGIC))
            size = stream.seek(0, 2)
            stream.seek(max(size - len(MAGIC), len(head)))
            return head, stream.read()
    except OSError as error:
        raise RecordingError(
            f"{file}: cannot be read ({error.strerror}); {_REQUIRED}; check its permissions"
        ) from error


def _recover(path: Path, file: Path, target: Path) -> None:
    with _damage(path):
        messages = rewrite(file, target)
    if not messages:
        raise RecordingError(
            f"{path}: received an unfinished bag without a whole message; required at least one; "
            "record again"
        )


@contextmanager
def _damage(path: Path) -> Iterator[None]:
    """Turn whatever a parser raises on damaged or foreign data into a RecordingError."""
    try:
        yield
    except RecordingError:
        raise
    except Exception as error:  # damaged bytes can raise anything in a parser
        reason = " ".join(str(error).split()) or type(error).__name__
        raise RecordingError(
            f"{path}: cannot be read as a ROS 2 bag ({reason}); {_REQUIRED} that is intact; "
            "record again"
        ) from error
