"""Topics of a flight as arrays by control step, decoded straight from the serialized messages.

Arrival order and time stamps say nothing certain about which messages belong together (they differ
between runs, and players reorder equal stamps); the step that every message carries does.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording._finite import require_finite
from spacecraft_gnc.recording._layout import Group, decode
from spacecraft_gnc.recording._scan import Progress
from spacecraft_gnc.recording._seen import Seen
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.steps import flight_topics
from spacecraft_gnc.signals.signal import Signal
from spacecraft_gnc.types import Array

_BLOCK: Final = 4096  # messages of one topic that are decoded together
_BLOCK_BYTES: Final = 8 << 20  # the same in bytes: plans over hundreds of steps are long
_MOST_LOST: Final = 1000  # a damaged step number must not make arrays of any size
_MOST_STEPS: Final = 2**53  # where a float stops to hold each integer
_STEP: Final = "step"
_STAMP: Final = ("header.stamp.sec", "header.stamp.nanosec")
_FRAME: Final = "header.frame_id"
_HEADER: Final = "header."


@dataclass(frozen=True, slots=True)
class Columns:
    """Messages of one topic as arrays, by control step.

    Attributes
    ----------
    steps : (m,) array of int
        Ascending and unique; of a step that came twice the first message is kept.
    stamps : (m,) array
        Header stamps [s].
    fields
        (m, ...) arrays by dotted field name, without the header: numbers; vectors as (m, 3) in
        order x, y, z; quaternions as (m, 4) in order x, y, z, w; wrenches as (m, 6), force first;
        strings as objects; sequences as (m, longest), padded with NaN.
    repeats : int
        Messages of a step that had come before.
    conflicts : tuple of int
        Steps of those that were not the same message.
    frames : (m,) array of str
        ``frame_id`` of the headers.
    exact : (m,) array of bool
        Whether a message is just what its fields encode to, padding included.
    """

    steps: NDArray[np.int64]
    stamps: Array
    fields: Mapping[str, NDArray[Any]]
    repeats: int = 0
    conflicts: tuple[int, ...] = ()
    frames: NDArray[np.object_] = field(default_factory=lambda: np.empty(0, np.object_))
    exact: NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, np.bool_))

    def missing(self, first: int, last: int) -> tuple[int, ...]:
        """Return the steps of ``first``..``last`` without a message."""
        return tuple(np.setdiff1d(np.arange(first, last + 1), self.steps).tolist())


NO_COLUMNS: Final = Columns(np.empty(0, dtype=np.int64), np.empty(0), {})
"""Of a topic that was not recorded."""


def read_columns(
    bag: Bag,
    signals: Iterable[Signal],
    namespace: str | None = None,
    progress: Progress | None = None,
    leave_out: Collection[str] = (),
) -> dict[Signal, Columns]:
    """Read signals of a flight.

    Parameters
    ----------
    bag
        An open bag.
    signals
        With a control step; one that was not recorded comes back without messages.
    namespace
        Of the spacecraft, where the bag holds several.
    progress
        Called with the bytes read so far and in all.
    leave_out
        Fields that are not kept, for instance the plans of a long flight.

    Raises
    ------
    RecordingError
        If the bag is of another package or version, damaged, holds several spacecraft or several
        runs, or a number that must be finite is not.
    """
    signals = list(signals)
    blocks: dict[Signal, list[Columns]] = {signal: [] for signal in signals}
    for signal, block in iter_columns(bag, signals, namespace, progress):
        kept = {key: value for key, value in block.fields.items() if key not in leave_out}
        blocks[signal].append(replace(block, fields=kept))
    return {signal: _joined(parts) for signal, parts in blocks.items()}


def iter_columns(
    bag: Bag,
    signals: Iterable[Signal],
    namespace: str | None = None,
    progress: Progress | None = None,
) -> Iterator[tuple[Signal, Columns]]:
    """Yield (signal, columns) of some thousand messages at a time, in the order of recording.

    With the flight grows no more than a digest of each message. A step is unique in its block,
    not between blocks. Arguments and errors as in `read_columns`.
    """
    topics = flight_topics(bag, signals, namespace)
    pending: dict[str, list[bytes]] = {topic: [] for topic in topics}
    seen = {topic: Seen(f"{bag.path}: {topic}", signal.unique) for topic, signal in topics.items()}
    for topic, data in bag.recorded(topics, progress):
        block = pending[topic]
        block.append(data)
        if len(block) == _BLOCK or len(block) * len(data) >= _BLOCK_BYTES:
            yield topics[topic], _block(bag, topic, topics[topic], block, seen[topic])
            pending[topic] = []
    for topic, messages in pending.items():
        if messages:
            yield topics[topic], _block(bag, topic, topics[topic], messages, seen[topic])


class _Decoded(NamedTuple):
    """Messages of one layout without their headers."""

    rows: NDArray[np.int64]
    steps: NDArray[np.int64]
    stamps: Array
    fields: dict[str, NDArray[Any]]
    frames: NDArray[np.object_]
    exact: NDArray[np.bool_]


def _block(bag: Bag, topic: str, signal: Signal, messages: list[bytes], seen: Seen) -> Columns:
    """Decode messages, and keep the first of each step."""
    try:
        definitions = bag.definitions(topic)
        groups = [_decoded(group) for group in decode(definitions, bag.topics[topic], messages)]
    except RecordingError as error:
        raise RecordingError(
            f"{bag.path}: {topic}: {error}, as its definition in the bag says; record again"
        ) from error
    for group in groups:
        _require_reachable(f"{bag.path}: {topic}", group.steps)
        require_finite(f"{bag.path}: {topic}", signal, group.steps, group.fields)
    unsorted = _gathered(groups)
    conflicts = seen.conflicts(unsorted.steps.tolist(), messages)
    return _by_step(replace(unsorted, conflicts=conflicts))


def _require_reachable(where: str, steps: NDArray[np.int64]) -> None:
    """Refuse a step that no flight counts to: an unsigned number, read as a signed one, wraps."""
    beyond = np.flatnonzero((steps < 0) | (steps >= _MOST_STEPS))
    if beyond.size:
        raise RecordingError(
            f"{where}: received step {int(steps[beyond[0]]) % 2**64}; required a step below "
            f"2^53, as counted from 0; the message was recorded so: record again"
        )


def _decoded(group: Group) -> _Decoded:
    fields = {name: _plain(values) for name, values in group.fields.items()}
    seconds, nanoseconds = (fields[name] for name in _STAMP)
    steps = fields.pop(_STEP)
    kept = {name: values for name, values in fields.items() if not name.startswith(_HEADER)}
    stamps = seconds + 1e-9 * nanoseconds
    return _Decoded(group.rows, steps, stamps, kept, fields[_FRAME], group.exact)


def _plain(values: NDArray[Any]) -> NDArray[Any]:
    """Return numbers of this machine's byte order, and strings as objects."""
    if values.dtype.kind == "S":
        texts, places = np.unique(values, return_inverse=True)
        decoded = [text.rstrip(b"\0").decode(errors="replace") for text in texts.tolist()]
        return np.array(decoded, dtype=object)[places]
    wide = {"u": np.int64, "i": np.int64, "f": np.float64}.get(values.dtype.kind, values.dtype)
    return values.astype(wide)


def _gathered(parts: list[_Decoded]) -> Columns:
    """Put the groups of a block back into the order in which the messages came."""
    rows = np.concatenate([part.rows for part in parts])
    back = np.argsort(rows)
    fields = {
        name: _stacked([part.fields[name] for part in parts])[back] for name in parts[0].fields
    }
    steps, stamps, frames, exact = (values[back] for values in _every(parts))
    return Columns(steps, stamps, fields, frames=frames, exact=exact)


def _every(parts: Sequence[_Decoded] | Sequence[Columns]) -> Iterator[NDArray[Any]]:
    """Yield steps, stamps, frames and exactness of all parts."""
    yield np.concatenate([part.steps for part in parts])
    yield np.concatenate([part.stamps for part in parts])
    yield np.concatenate([part.frames for part in parts])
    yield np.concatenate([part.exact for part in parts])


def _stacked(arrays: list[NDArray[Any]]) -> NDArray[Any]:
    """Return the rows of all arrays; where their lengths differ, padded with NaN."""
    if len({array.shape[1:] for array in arrays}) == 1:
        return np.concatenate(arrays)
    longest = max(array.shape[1] for array in arrays)
    padded = [
        np.pad(array.astype(float), ((0, 0), (0, longest - array.shape[1])), constant_values=np.nan)
        for array in arrays
    ]
    return np.concatenate(padded)


def _joined(parts: list[Columns]) -> Columns:
    if not parts:
        return NO_COLUMNS
    fields = {name: _stacked([part.fields[name] for part in parts]) for name in parts[0].fields}
    steps, stamps, frames, exact = _every(parts)
    repeats = sum(part.repeats for part in parts)
    conflicts = tuple(step for part in parts for step in part.conflicts)
    return _by_step(Columns(steps, stamps, fields, repeats, conflicts, frames, exact))


def _by_step(columns: Columns) -> Columns:
    """Sort by step, and keep the first message of each."""
    steps, first = np.unique(columns.steps, return_index=True)
    if np.array_equal(first, np.arange(columns.steps.size)):
        return columns
    fields = {name: values[first] for name, values in columns.fields.items()}
    repeats = columns.repeats + columns.steps.size - steps.size
    return Columns(
        steps,
        columns.stamps[first],
        fields,
        repeats,
        columns.conflicts,
        columns.frames[first],
        columns.exact[first],
    )


def require_reach(bag: Bag, *steps: NDArray[np.int64]) -> None:
    """Refuse a step number far beyond what was recorded, which would make arrays of any size.

    Raises
    ------
    RecordingError
        If there is one.
    """
    count, last = sum(each.size for each in steps), max(each.max(initial=0) for each in steps)
    if last > _MOST_LOST * count:
        raise RecordingError(
            f"{bag.path}: received {count} messages and one of them at step {last}; required one "
            f"at least every {_MOST_LOST} steps; a step number is damaged, or most was lost"
        )
