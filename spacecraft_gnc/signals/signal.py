"""A signal: a topic, its messages and who exchanges them, as plain data."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Final, NamedTuple

from spacecraft_gnc.signals.codec import Codec, is_flat
from spacecraft_gnc.signals.message import Message, Refused, Stamp
from spacecraft_gnc.signals.nested import encode_nested
from spacecraft_gnc.signals.qos import STREAM, TRANSIENT_LOCAL, QosProfile
from spacecraft_gnc.signals.rules import FINITE, Check, Rule, check_of, reject_step
from spacecraft_gnc.signals.structures import HEADER, SEQUENCE, TIME, numbers_in, parse_kind

STEPPED: Final = ("header", "step")
STAMPED: Final = ("header",)
EVERY: Final = "*"
"""Among the topics of a recorder: all of the graph."""
LAST: Final = 99
"""Rank of a signal that no step causes."""
_STARTS: Final = {"header": HEADER, "step": "uint64"}


class Field(NamedTuple):
    """A field of a message."""

    kind: str
    """Type, as the .msg file writes it: ``float64[9]``, ``geometry_msgs/Vector3``."""
    unit: str = ""
    rule: Rule = FINITE

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of its numbers; a sequence's length is 0 here."""
        count = parse_kind(self.kind).n
        if count == SEQUENCE:
            return (0,)
        numbers = numbers_in(self.kind)
        is_single = count is None and (numbers is None or len(numbers) == 1)
        return () if is_single else (len(numbers or ""),)


@dataclass(frozen=True, eq=False, kw_only=True)
class Signal:
    """A topic of the graph.

    Attributes
    ----------
    name
        Of the topic, relative to the namespace of its agent.
    type
        ``pkg/msg/Type``.
    fields
        In order of declaration, after those of ``start``.
    publishers, subscribers
        Roles; the subscribers have to be matched before step 0.
    start
        First fields: header and control step, the header alone, or neither.
    frame
        ``frame_id`` of the header.
    every_step
        Whether there is a message of each step, so that a gap is a loss.
    unique
        Whether two messages of one step differ only if a bag holds two runs.
    recorded
        Whether a recorder takes it unless asked otherwise.
    shared
        Whether it belongs to the graph and not to one of its agents.
    sealed
        Whether its publishers seal it (`seal`).
    of_craft
        Whether each craft of the vehicle has its own, in the craft's namespace; where the vehicle
        is one craft, that is the agent's.
    qos
        Offered by its publishers.
    rank
        Order of cause and effect within a step.
    pack
        What a core tells, to the values of the fields; None: it tells these.
    unpack
        A checked message to what a core takes; None: the message itself.
    """

    name: str
    type: str
    fields: Mapping[str, Field]
    publishers: tuple[str, ...] = ()
    subscribers: tuple[str, ...] = ()
    start: tuple[str, ...] = STEPPED
    frame: str = ""
    every_step: bool = True
    unique: bool = False
    recorded: bool = True
    shared: bool = False
    sealed: bool = True
    of_craft: bool = False
    qos: QosProfile = STREAM
    rank: int = LAST
    pack: Callable[[Any], Sequence[Any]] | None = None
    unpack: Callable[[Message], Any] | None = None

    def __str__(self) -> str:
        """Return the name of the topic."""
        return self.name

    def of(self, craft: str) -> Signal:
        """Return the signal of one craft, named relative to the agent; the same each time."""
        return _of(self, craft)

    @property
    def kinds(self) -> dict[str, str]:
        """Type of each field of the message."""
        starts = {name: _STARTS[name] for name in self.start}
        return starts | {name: field.kind for name, field in self.fields.items()}

    @property
    def is_stepped(self) -> bool:
        """Whether its messages carry their control step."""
        return self.start == STEPPED

    @cached_property
    def is_stamped(self) -> bool:
        """Whether its messages begin with a time."""
        first = next(iter(self.kinds.values()))
        return first in (HEADER, TIME)

    @property
    def is_flat(self) -> bool:
        """Whether messages are read and checked here: they nest no strings."""
        return self._codec is not None

    @property
    def is_latched(self) -> bool:
        """Whether a late joiner gets the last messages."""
        return self.qos.durability == TRANSIENT_LOCAL

    def is_recorded(self, wanted: Collection[str]) -> bool:
        """Whether a recorder asked for topics ``wanted`` (empty: all) takes this one."""
        names = {name.strip("/") for name in wanted}
        return self.recorded and (not names or not names.isdisjoint((EVERY, self.name.strip("/"))))

    def encode(self, stamp: Stamp, step: int, value: Any) -> bytes:
        """Return the CDR bytes of a message.

        Parameters
        ----------
        stamp, step
            For a header and a step, where the message has them.
        value
            As a core tells it, or the values of the fields where ``pack`` is None.

        Raises
        ------
        ShapeError
            If the value does not fit.
        """
        values = value if self.pack is None else self.pack(value)
        if self._codec is not None:
            return self._codec.encode(stamp, step, values)
        told = dict(zip(self.fields, values, strict=True))
        if self.start:
            told["header"] = {"stamp": stamp, "frame_id": self.frame}
            told["step"] = step
        return encode_nested(self.kinds, told)

    def read(self, data: bytes) -> Message:
        """Return a message as it came.

        Raises
        ------
        Refused
            If the bytes are none of this signal.
        """
        if self._codec is None:
            raise Refused(f"{self.name}: messages of {self.type} are not read here", "layout")
        return self._codec.decode(data)

    def decode(self, data: bytes, last_step: int = 0) -> Message:
        """Return a message whose step and numbers keep their rules.

        Raises
        ------
        Refused
            If it is none of this signal, older than ``last_step``, or breaks a rule.
        """
        message = self.read(data)
        slots, places = message.slots, message.places
        if self.is_stepped and slots[places["step"]] < last_step:
            raise Refused(reject_step(message.step, last_step), "step")
        for name, check, when in self._checks:
            if when is None or message[when[0]] == when[1]:
                reason = check(name, slots[places[name]])
                if reason is not None:
                    raise Refused(reason)
        return message

    def value(self, message: Message) -> Any:
        """Return a message as a core takes it."""
        return message if self.unpack is None else self.unpack(message)

    @cached_property
    def type_hash(self) -> str:
        """REP-2011 hash of the message type, from its fields."""
        from spacecraft_gnc.signals.type_hash import type_hash

        return type_hash(self.type, self.kinds)

    @cached_property
    def _codec(self) -> Codec | None:
        kinds = self.kinds
        return Codec(self.type.rpartition("/")[2], kinds, self.frame) if is_flat(kinds) else None

    @cached_property
    def _checks(self) -> list[tuple[str, Check, tuple[str, int] | None]]:
        checks = []
        for name, field in self.fields.items():
            numbers = numbers_in(parse_kind(field.kind).base) or ""
            check = check_of(field.rule, set(numbers) <= set("fd") and bool(numbers))
            if check is not None:
                checks.append((name, check, field.rule.when))
        return checks


@lru_cache(maxsize=256)
def _of(signal: Signal, craft: str) -> Signal:
    return replace(signal, name=f"{craft}/{signal.name}", of_craft=False)
