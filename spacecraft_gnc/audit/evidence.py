"""Evidence of an audit: recorded topics by control step, and the scenario flown."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.columns import Columns, iter_columns, read_columns
from spacecraft_gnc.recording.metadata import RECOVERED_RECORD
from spacecraft_gnc.signals.graph import GOVERNOR, PLANT
from spacecraft_gnc.signals.signal import Signal
from spacecraft_gnc.types import Array


class Telemetry(NamedTuple):
    """A topic for viewers, whose messages follow from those of others."""

    signal: Signal
    """Without a control step; its values are those of its fields (`Signal.pack` is None)."""
    steps: Callable[[Evidence], NDArray[np.int64]]
    """Those at which it is published, ascending."""
    values: Callable[[Evidence, NDArray[np.int64]], Sequence[Any]]
    """Its values at steps (m,); NaN where what they follow from was not recorded."""
    reason: str = ""
    """Why it may be published at no step at all."""


class Topics(NamedTuple):
    """Topics of a vehicle that an audit reads."""

    every_step: tuple[Signal, ...]
    """Those with a message at every step."""
    sparse: tuple[Signal, ...]
    """Others that are kept."""
    solves: Signal | None = None
    """The topic whose plans are read some thousand at a time, as `Evidence.solves` yields them."""
    plans: tuple[str, ...] = ()
    """Its fields that are."""
    craft: tuple[str, ...] = ()
    """Namespaces of the vehicle's craft, relative to the flight's; empty: it is one."""
    telemetry: tuple[Telemetry, ...] = ()
    """Those for viewers."""
    later: Mapping[Signal, Callable[[Any], bool]] = MappingProxyType({})
    """Those that flights of earlier versions did not have, each with whether a scenario of any
    version needs it."""

    def of_craft(self, craft: Sequence[str]) -> Topics:
        """Return the topics with those of each craft in place of a signal that each has."""
        own = self._replace(craft=tuple(craft))
        return own._replace(
            every_step=tuple(one for signal in self.every_step for one in own.each(signal)),
            sparse=tuple(one for signal in self.sparse for one in own.each(signal)),
        )

    def each(self, signal: Signal) -> tuple[Signal, ...]:
        """Return a signal of every craft, in their order; one that they have not each, itself."""
        if not (signal.of_craft and self.craft):
            return (signal,)
        return tuple(signal.of(name) for name in self.craft)

    @property
    def leading(self) -> frozenset[Signal]:
        """Those of the plant, which tell of the end of the last step, too."""
        return frozenset(signal for signal in self.every_step if PLANT in signal.publishers)


Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Evidence:
    """A recorded flight, read for an audit.

    Attributes
    ----------
    path
        The bag.
    scenario
        What flew, as recorded.
    topics
        Of the vehicle.
    columns
        Every topic but the plans of the solver, which `plans` yields.
    n
        Control steps flown.
    unfinished
        Whether the bag was cut off, and read as far as it goes.
    recovered
        Whether it was cut off and `gnc recover` made it whole.
    is_cut
        Whether it has loose ends: cut off, or of a flight that was stopped.
    """

    path: Path
    scenario: Any
    topics: Topics
    columns: dict[Signal, Columns]
    n: int
    unfinished: bool
    recovered: bool
    is_cut: bool
    bag: Bag
    namespace: str | None

    def rows(self, topic: Signal, name: str, steps: NDArray[np.int64]) -> Array:
        """Return values of a field (m, ...) at steps (m,); NaN where one was not recorded."""
        columns = self.columns[topic]
        values = columns.fields.get(name, np.empty((0, *topic.fields[name].shape)))
        found = np.full((len(steps), *values.shape[1:]), np.nan)
        places = np.searchsorted(columns.steps, steps)
        there = places < columns.steps.size
        there[there] = columns.steps[places[there]] == steps[there]
        found[there] = values[places[there]]
        return found

    def common(self, *topics: Signal) -> NDArray[np.int64]:
        """Return the steps that all of these topics hold."""
        steps = self.columns[topics[0]].steps
        for topic in topics[1:]:
            steps = np.intersect1d(steps, self.columns[topic].steps, assume_unique=True)
        return steps

    def solves(self, progress: Progress | None = None) -> Iterator[Columns]:
        """Yield the solver's messages, some thousand at a time."""
        if self.topics.solves is None:
            return
        for _, block in iter_columns(self.bag, [self.topics.solves], self.namespace, progress):
            yield block


def read_evidence(
    bag: Bag,
    topics: Topics,
    scenario: Any,
    namespace: str | None,
    progress: Progress | None,
    *,
    stopped: bool = False,
) -> Evidence:
    """Read what an audit needs, but for the plans; a flight that was ``stopped`` has loose ends.

    Raises
    ------
    RecordingError
        If the bag is no flight of one spacecraft.
    """
    names = [*topics.every_step, *topics.sparse]
    columns = read_columns(bag, names, namespace, progress, leave_out=topics.plans)
    recovered = RECOVERED_RECORD in bag.metadata()
    is_cut = bag.unfinished or recovered or stopped
    n = _flown(columns, topics, is_cut)
    return Evidence(
        bag.path, scenario, topics, columns, n, bag.unfinished, recovered, is_cut, bag, namespace
    )


def _flown(columns: dict[Signal, Columns], topics: Topics, cut: bool) -> int:
    """Return the control steps flown: up to the last message; in a cut bag, to the last whole one.

    The governor answers the last state, too, of which no control step starts.
    """
    ends = [
        int(columns[topic].steps[-1]) + (topic not in topics.leading)
        for topic in topics.every_step
        if columns[topic].steps.size and (cut or GOVERNOR not in topic.publishers)
    ]
    return (min if cut else max)(ends, default=0)
