"""What was heard of a vehicle's signals, as rows of its flight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.drawing.live import VehicleLive
from spacecraft_gnc.ros.graph_of import vehicle_signals
from spacecraft_gnc.ros.inboxes import Inbox
from spacecraft_gnc.signals import Message, Refused, Signal
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.signals.members import Seams
from spacecraft_gnc.vehicles.registry import flight_of
from spacecraft_gnc.vehicles.vehicle import Vehicle

_SCALAR: Final[tuple[int, ...]] = ()


class _Place(NamedTuple):
    """Where a value of a row is found."""

    signal: str
    member: str
    shape: tuple[int, ...]


class Heard:
    """The last messages of one vehicle's signals, by control step.

    Parameters
    ----------
    vehicle
        Whose flight it is.
    room
        What is shown of it: the names that a row has beside the columns of the flight.
    craft
        Namespaces of its craft, relative to its own; empty: it is one, or they are not known.
    """

    def __init__(self, vehicle: Vehicle, room: VehicleLive, craft: Sequence[str] = ()) -> None:
        own = vehicle_signals(vehicle)
        self.craft = tuple(craft)
        self.seams = Seams.among(own)
        stepped = [signal for signal in (*own, WALL_TIMING) if signal.is_stepped]
        self._each = {s.name: [s.of(name) for name in craft] for s in stepped if s.of_craft}
        told = (one for s in stepped for one in self._each.get(s.name, [s]))
        self.signals = {signal.name: signal for signal in told}
        self.inboxes = {name: Inbox() for name in self.signals}
        self._targets: dict[int, Any] = {}
        self._places = dict(self._find(vehicle, room))

    def _find(self, vehicle: Vehicle, room: VehicleLive) -> Iterator[tuple[str, _Place]]:
        """Yield the place of each value that a message carries."""
        for name, column in flight_of(vehicle).columns():
            if not column.at_end and column.signal:
                yield name, _Place(column.signal, column.member, column.shape)
        for name, carried_by in room.fields.items():
            signal, _, member = carried_by.partition("/")
            yield name, _Place(signal, member, _SCALAR)

    def put(self, signal: Signal, step: int, data: bytes) -> None:
        """Take in the message of a step."""
        self.inboxes[signal.name].put(step, data)
        if signal is self.seams.accepted:
            message = self._read(signal, data)
            if message is not None:
                self._targets[step] = message

    def clear(self) -> None:
        """Forget all: another flight begins."""
        for inbox in self.inboxes.values():
            inbox.messages.clear()
        self._targets.clear()

    @property
    def is_whole(self) -> bool:
        """Whether each signal that tells something of every step has come."""
        told = self._shown & self.signals.keys()
        wanted = [name for name in told if self.signals[name].every_step]
        return all(self.inboxes[name].last for name in wanted)

    def state(self, step: int) -> Message:
        """Return the checked state of a step, or else the last one.

        Raises
        ------
        Refused
            If it breaks a rule.
        """
        return self.seams.state.decode(self._data(self.seams.state, step))

    def last(self, signal: Signal) -> Message | None:
        """Return the last message of a signal; None: it is absent, or none."""
        return self._read(signal, self.inboxes[signal.name].last)

    def row(self, step: int) -> dict[str, Any]:
        """Return what is known of a step, by name; each message of the step, or else the last one.

        The target is the one taken last in flight; None: the scenario's counts.
        """
        names = self._shown & self.signals.keys()
        messages = {name: self._message(self.signals[name], step) for name in names}
        return {name: self._told(messages, place) for name, place in self._places.items()}

    @property
    def _shown(self) -> set[str]:
        """Names of the signals of which a row tells."""
        named = {place.signal for place in self._places.values()}
        return named | {one.name for name in named & self._each.keys() for one in self._each[name]}

    def _told(self, messages: dict[str, Message | None], place: _Place) -> Any:
        """Return a value of a row; of a signal that each craft has, a row for each."""
        if place.signal not in self._each:
            return _value(messages.get(place.signal), place)
        own = place._replace(shape=place.shape[1:])
        values = [_value(messages.get(one.name), own) for one in self._each[place.signal]]
        return None if not values or any(v is None for v in values) else np.stack(values)

    def _message(self, signal: Signal, step: int) -> Message | None:
        if signal is self.seams.target:
            taken = max((known for known in self._targets if known <= step), default=None)
            return None if taken is None else self._targets[taken]
        return self._read(signal, self._data(signal, step))

    def _data(self, signal: Signal, step: int) -> bytes:
        inbox = self.inboxes[signal.name]
        return inbox.messages.get(step, inbox.last)

    def _read(self, signal: Signal, data: bytes) -> Message | None:
        """Return a message; None: it is absent or, where a core would act on it, a bad one."""
        read = signal.decode if signal in self.seams else signal.read
        try:
            return read(data) if data else None
        except Refused:
            return None


def _value(message: Message | None, place: _Place) -> Any:
    """Return a value of a message; None where it has none, or a column that is not finite."""
    if message is None or place.member not in message.places:
        return None
    if place.shape == _SCALAR:
        value = message[place.member]
        return np.asarray(value) if isinstance(value, tuple) else value
    array = message.array(place.member).reshape(place.shape)
    return array if np.isfinite(array).all() else None
