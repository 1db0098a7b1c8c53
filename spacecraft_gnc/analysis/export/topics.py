"""Topics of a bag as named columns with units."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.analysis.export.field_text import FieldText, field_texts
from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import Bag, open_bag
from spacecraft_gnc.recording.columns import Columns, read_columns, require_reach
from spacecraft_gnc.recording.steps import namespace_topics
from spacecraft_gnc.signals.signal import Signal
from spacecraft_gnc.vehicles.known_signals import every_signal, signal_of, state_signals

STEP: Final = "step"
STAMP: Final = "stamp"
_STEP_TEXT: Final = FieldText("-", "control step [-]", "")
_STAMP_TEXT: Final = FieldText("s", "simulated time in the header of the message [s]", "")
_UNKNOWN: Final = FieldText("", "", "")


class Field(NamedTuple):
    """A field of a topic, one row for each message."""

    name: str
    values: NDArray[Any]
    """(m,) or (m, width)."""
    text: FieldText


class Column(NamedTuple):
    """One number or string for each message."""

    name: str
    """``topic.field``, ``topic.field.x`` or ``topic.field.0``."""
    values: NDArray[Any]
    """(m,)"""
    rows: NDArray[np.int64]
    """(m,) rows of the table that these belong to."""
    text: FieldText


@dataclass(frozen=True, slots=True)
class Topic:
    """All messages of a topic."""

    name: str
    steps: NDArray[np.int64]
    fields: tuple[Field, ...]


@dataclass(frozen=True, slots=True)
class Export:
    """What is written.

    Attributes
    ----------
    path
        The bag.
    topics
        Of the flight, by step.
    left_out
        Recorded topics whose messages belong to no control step.
    remarks
        What else of the bag is not read, one line each.
    """

    path: Path
    topics: tuple[Topic, ...]
    left_out: tuple[str, ...]
    remarks: tuple[str, ...] = ()

    def steps(self) -> NDArray[np.int64]:
        """Return every step that any topic has, ascending: the rows of the table."""
        return np.asarray(np.unique(np.concatenate([topic.steps for topic in self.topics])))

    def columns(self) -> Iterator[Column]:
        """Yield the columns of one table of all topics; `steps` is its first."""
        steps = self.steps()
        for topic in self.topics:
            rows = np.searchsorted(steps, topic.steps)
            for field in topic.fields:
                name = f"{topic.name}.{field.name}"
                if field.values.ndim == 1:
                    yield Column(name, field.values, rows, field.text)
                    continue
                for i in range(field.values.shape[1]):
                    part = field.text.components[i] if field.text.components else str(i)
                    yield Column(f"{name}.{part}", field.values[:, i], rows, field.text)


def read_export(
    path: Path,
    names: Sequence[str] = (),
    *,
    namespace: str | None = None,
    allow_unfinished: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Export:
    """Read the topics of a flight.

    Parameters
    ----------
    path
        Bag folder or .mcap file.
    names
        Of the topics, without their namespace; none: all that carry a control step.
    namespace
        Of the spacecraft, where the bag holds several.
    allow_unfinished
        Read what is whole of a bag that was cut off, instead of refusing it.
    progress
        Called with the bytes read so far and in all.

    Raises
    ------
    RecordingError
        If the bag cannot be read, or a topic was not recorded or carries no step.
    """
    with open_bag(path, allow_unfinished=allow_unfinished) as bag:
        recorded = namespace_topics(bag, namespace, state_signals())
        known = _stepped(bag, recorded)
        _require(path, [name.strip("/") for name in names], known)
        wanted = [name for name in known if not names or name in {n.strip("/") for n in names}]
        signals = [known[name] for name in wanted]
        columns = read_columns(bag, signals, namespace, progress) if signals else {}
        topics = tuple(
            _topic(bag, name, recorded[name], columns[known[name]])
            for name in wanted
            if columns[known[name]].steps.size
        )
        if not topics:
            raise RecordingError(
                f"{path}: received 0 states and 0 torques; required at least one whole control "
                "step; record a longer run"
            )
        require_reach(bag, *(topic.steps for topic in topics))
        left_out = tuple(sorted(topic for name, topic in recorded.items() if name not in known))
        remarks = tuple(bag.remarks())
    return Export(path, topics, *(((), ()) if names else (left_out, remarks)))


def _stepped(bag: Bag, recorded: Mapping[str, str]) -> dict[str, Signal]:
    """Return the signals with a control step by name; of users, what counts is told elsewhere."""
    order = {signal: place for place, signal in enumerate(every_signal())}
    found = {
        name: signal_of(topic, bag.topics[topic])
        for name, topic in recorded.items()
        if bag.is_stepped(topic)
    }
    told = [name for name, signal in found.items() if signal.publishers or not signal.fields]
    told.sort(key=lambda name: order.get(found[name], 99))
    return {name: _of_its_craft(found[name], name) for name in told}


def _of_its_craft(signal: Signal, name: str) -> Signal:
    """Return the signal of the craft in whose namespace a topic stands, if it does."""
    craft = name.rpartition("/")[0]
    return signal.of(craft) if craft and (signal.of_craft or not signal.fields) else signal


def _require(path: Path, names: Sequence[str], known: Iterable[str]) -> None:
    for name in names:
        if name not in known:
            raise RecordingError(
                f"--topics: received {name!r}; required a topic of control steps in {path}; use "
                f"{', '.join(known)}"
            )


def _topic(bag: Bag, name: str, topic: str, columns: Columns) -> Topic:
    texts = field_texts(bag.channel(topic).definition)
    fields = [
        Field(STEP, columns.steps, _STEP_TEXT),
        Field(STAMP, columns.stamps, _STAMP_TEXT),
    ]
    for field, values in columns.fields.items():
        fields.append(Field(field, values, texts.get(field.partition(".")[0], _UNKNOWN)))
    return Topic(name, columns.steps, tuple(fields))
