"""A bag of ours as other producers write it: split, compressed, unindexed, with other topics in it.

Each maker takes a closed bag and the folder of the new one, and returns what a user would name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import yaml
import zstandard
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, IndexType, Writer

INFORMATION = "rosbag2_bagfile_information"
STAMP_NS = 400_000_000
"""Log time of what is added to a flight [ns]."""


class Contents(NamedTuple):
    """Everything in the file of a bag."""

    schemas: list[Schema]
    channels: list[Channel]
    messages: list[Message]
    attachments: list[Attachment]
    metadata: list[Metadata]

    @classmethod
    def of(cls, bag: Path) -> Contents:
        (file,) = bag.glob("*.mcap")
        with file.open("rb") as stream:
            reader = make_reader(stream)
            summary = reader.get_summary()
            return cls(
                list(summary.schemas.values()),
                list(summary.channels.values()),
                [message for *_, message in reader.iter_messages(log_time_order=False)],
                list(reader.iter_attachments()),
                list(reader.iter_metadata()),
            )


def write(
    path: Path,
    contents: Contents,
    extra: Callable[[Writer], None] | None = None,
    compression: CompressionType = CompressionType.ZSTD,
    pack: Callable[[bytes], bytes] = bytes,
    **options: Any,
) -> Path:
    """Write an MCAP file, with what ``extra`` adds before the flight."""
    with path.open("wb") as stream:
        writer = Writer(stream, compression=compression, chunk_size=4000, **options)
        writer.start("ros2", "another producer")
        schemas = {s.id: writer.register_schema(s.name, s.encoding, s.data) for s in contents[0]}
        channels = {
            c.id: writer.register_channel(
                c.topic, c.message_encoding, schemas[c.schema_id], dict(c.metadata)
            )
            for c in contents.channels
        }
        for item in contents.attachments:
            writer.add_attachment(0, 0, item.name, item.media_type, item.data)
        if extra is not None:
            extra(writer)
        for m in contents.messages:
            writer.add_message(
                channels[m.channel_id], m.log_time, pack(m.data), m.publish_time, m.sequence
            )
        writer.finish()
    return path


def folder_of(bag: Path, folder: Path, parts: int = 1, **options: Any) -> Path:
    """Write the bag again as a folder of so many files, its metadata.yaml right."""
    contents, count = Contents.of(bag), parts
    folder.mkdir()
    names = [f"{folder.name}_{i}.mcap" for i in range(count)]
    size = -(-len(contents.messages) // count)
    for i, name in enumerate(names):
        part = contents._replace(messages=contents.messages[i * size : (i + 1) * size])
        write(folder / name, part, **options)
    about = yaml.safe_load((bag / "metadata.yaml").read_text())
    about[INFORMATION]["relative_file_paths"] = names
    about[INFORMATION].pop("files")
    (folder / "metadata.yaml").write_text(yaml.safe_dump(about))
    return folder


def edit(folder: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    """Change metadata.yaml of a bag, and nothing else."""
    file = folder / "metadata.yaml"
    about = yaml.safe_load(file.read_text())
    change(about[INFORMATION])
    file.write_text(yaml.safe_dump(about))
    return folder


def without_qos(about: dict[str, Any]) -> None:
    for entry in about["topics_with_message_count"]:
        entry["topic_metadata"]["offered_qos_profiles"] = []


def with_latched_qos(about: dict[str, Any]) -> None:
    for entry in about["topics_with_message_count"]:
        for profile in entry["topic_metadata"]["offered_qos_profiles"]:
            profile["durability"] = "transient_local"


def with_the_span_of_the_end(about: dict[str, Any]) -> None:
    """As producers leave it whose start is that of the last file."""
    end = about["starting_time"]["nanoseconds_since_epoch"] + about["duration"]["nanoseconds"]
    about["starting_time"] = {"nanoseconds_since_epoch": end - STAMP_NS}
    about["duration"] = {"nanoseconds": STAMP_NS}
    about["message_count"] = 3


def with_another_channel(
    name: str, encoding: str, data: bytes, topic: str, message_encoding: str = "cdr"
) -> Callable[[Writer], None]:
    """Return what adds one message of a channel with a schema (without one: empty ``encoding``)."""

    def add(writer: Writer) -> None:
        schema = writer.register_schema(name, encoding, data) if encoding else 0
        channel = writer.register_channel(topic, message_encoding, schema)
        writer.add_message(channel, STAMP_NS, b"\0\1\0\0" + bytes(16), STAMP_NS)

    return add


def compressed_whole(bag: Path, folder: Path) -> Path:
    """Compress the file of the bag as a whole, as rosbag2_compression does."""
    made = folder_of(bag, folder)
    (file,) = made.glob("*.mcap")
    (made / f"{file.name}.zstd").write_bytes(zstandard.compress(file.read_bytes()))
    file.unlink()

    def change(about: dict[str, Any]) -> None:
        about["relative_file_paths"] = [f"{file.name}.zstd"]
        about["compression_format"], about["compression_mode"] = "zstd", "FILE"

    return edit(made, change)


def compressed_messages(bag: Path, folder: Path) -> Path:
    """Compress each message by itself, as rosbag2_compression does in its other mode."""
    made = folder_of(bag, folder, pack=zstandard.compress)
    mode = {"compression_format": "zstd", "compression_mode": "MESSAGE"}
    return edit(made, lambda about: about.update(mode))


NO_INDEX: dict[str, Any] = {
    "use_summary_offsets": False,
    "use_statistics": False,
    "repeat_channels": False,
    "repeat_schemas": False,
    "index_types": IndexType.NONE,
}
SHAPES: dict[str, Callable[[Path, Path], Path]] = {
    "lz4": lambda bag, out: folder_of(bag, out, compression=CompressionType.LZ4),
    "without chunks": lambda bag, out: folder_of(bag, out, use_chunking=False),
    "without an index": lambda bag, out: folder_of(bag, out, **NO_INDEX),
    "without attachment index": lambda bag, out: folder_of(
        bag, out, index_types=IndexType.CHUNK | IndexType.MESSAGE
    ),
    "without checksums": lambda bag, out: folder_of(bag, out, enable_crcs=False),
    "in twelve files": lambda bag, out: folder_of(bag, out, 12),
    "in three files, a wrong span": lambda bag, out: edit(
        folder_of(bag, out, 3), with_the_span_of_the_end
    ),
    "without QoS in metadata.yaml": lambda bag, out: edit(folder_of(bag, out), without_qos),
    "with other QoS in metadata.yaml": lambda bag, out: edit(folder_of(bag, out), with_latched_qos),
    "without topics in metadata.yaml": lambda bag, out: edit(
        folder_of(bag, out), lambda about: about.pop("topics_with_message_count")
    ),
    "compressed as a whole": compressed_whole,
    "its messages compressed": compressed_messages,
    "its messages compressed, a file": lambda bag, out: next(
        compressed_messages(bag, out).glob("*.mcap")
    ),
    "a file": lambda bag, out: write(out.with_suffix(".mcap"), Contents.of(bag)),
}
"""What holds the same flight, and must be read as the same flight."""

_SERVICE = b"MSG: demo_pkg/srv/Add_Event\nint64 a\nint64 b\n---\nint64 sum\n"
FOREIGN: dict[str, tuple[str, str, Callable[[Writer], None]]] = {
    "a service": (
        "/add/_service_event",
        "demo_pkg/srv/Add_Event is no ROS 2 message",
        with_another_channel("demo_pkg/srv/Add_Event", "ros2msg", _SERVICE, "/add/_service_event"),
    ),
    "JSON": (
        "/web/notes",
        "encoding json, not cdr",
        with_another_channel("foo", "jsonschema", b"{}", "/web/notes", "json"),
    ),
    "Protobuf": (
        "/proto",
        "encoding protobuf, not cdr",
        with_another_channel("foo.Bar", "protobuf", b"\x01\x02", "/proto", "protobuf"),
    ),
    "bytes without a definition": (
        "/raw",
        "encoding application/octet-stream, without a message definition",
        with_another_channel("", "", b"", "/raw", "application/octet-stream"),
    ),
}
"""Topic, why it is left out, what adds it to a flight."""


def merged(files: Sequence[Path], folder: Path) -> Path:
    """Put files of several bags into one folder, under their own names."""
    folder.mkdir()
    for file in files:
        (folder / file.name).write_bytes(file.read_bytes())
    return folder
