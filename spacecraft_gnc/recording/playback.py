"""Messages of a bag in playback order.

In simulated time many messages bear the same stamp, and players shuffle them (rosbag2#2173). Here
those of one stamp keep the order of cause and effect: by control step, and within a step the state,
what the plant tells beside it, the clock, the reference, the torque.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import groupby
from operator import itemgetter
from typing import Final, NamedTuple

from spacecraft_gnc.errors import RecordingError
from spacecraft_gnc.recording.bag import Bag
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.signals.graph import CLOCK
from spacecraft_gnc.signals.qos import INFINITE_NS, QosProfile
from spacecraft_gnc.signals.signal import LAST, Signal

_LAST: Final = (LAST, 0)
_NS_PER_S: Final = 1_000_000_000
_MOST_SECONDS: Final = 2**31  # of builtin_interfaces/Time
_CLOCK_QOS: Final = QosProfile()
_UNKNOWN_DEPTH: Final = 100  # discovery does not tell depths: other recorders write 0


class PlayedTopic(NamedTuple):
    """A topic of a bag, as a player needs to know it."""

    name: str
    type_name: str
    """``pkg/msg/Type``"""
    type_hash: str
    """REP-2011 hash of the definition in the bag; empty where there is none."""
    qos: QosProfile
    """The most that its recorded publishers offered."""
    stepped: bool = False
    """Whether its messages carry their control step."""

    @property
    def is_latched(self) -> bool:
        """Whether whoever joins late gets its last messages."""
        return self.qos.durability == "transient_local"


class Moment(NamedTuple):
    """All messages of one stamp."""

    time_ns: int
    messages: list[tuple[str, bytes]]
    """(topic, serialized message) in the order of cause and effect."""


class Playback:
    """What of a bag is played.

    ``/clock`` is always played: as it was recorded, or else one tick for every stamp.

    Parameters
    ----------
    bag
        An open bag.
    wanted
        Topics to play, by full name or its last part; empty: all.
    signals
        Known ones, whose ranks order the messages of one step; others keep the order in which they
        were recorded, behind them.

    Raises
    ------
    RecordingError
        If the bag holds no message, or not what is wanted.
    """

    def __init__(
        self, bag: Bag, wanted: Collection[str] = (), signals: Iterable[Signal] = ()
    ) -> None:
        known = enumerate((*signals, CLOCK))
        self._ranks = {s.name.strip("/"): (s.rank, place) for place, s in known if s.rank < LAST}
        self.start_ns, self.end_ns = bag.span_ns
        if self.end_ns < self.start_ns:
            raise RecordingError(
                f"{bag.path}: received a bag without a message; required something to play; record "
                "again"
            )
        self._bag = bag
        self.left_out = {} if wanted else dict(bag.left_out)
        """Why a topic is not played, by its name; of ``wanted`` ones nothing else is told."""
        self.ticks = CLOCK.name not in bag.topics
        """Whether the clock is made here."""
        self.topics: dict[str, PlayedTopic] = {}
        for name in dict.fromkeys([*_chosen(bag, wanted), *([] if self.ticks else [CLOCK.name])]):
            try:
                self.topics[name] = _topic(bag, name)
            except RecordingError as error:
                self.left_out[name] = str(error)
        if self.ticks:
            self.topics[CLOCK.name] = PlayedTopic(CLOCK.name, CLOCK.type, "", _CLOCK_QOS)

    @property
    def held(self) -> dict[str, int]:
        """How many messages the bag holds of each topic that is to be played."""
        counts = self._bag.counts
        return {name: counts[name] for name in (*self.topics, *self.left_out) if counts[name]}

    def remarks(self) -> list[str]:
        """Return what of the bag is not played, one line each."""
        return self._bag.remarks(self.left_out)

    @property
    def duration(self) -> float:
        """From the first stamp to the last [s]."""
        return (self.end_ns - self.start_ns) / _NS_PER_S

    def leave_out(self, name: str, reason: str) -> None:
        """Do not play a topic."""
        del self.topics[name]
        self.left_out[name] = reason
        self.ticks = self.ticks and name != CLOCK.name

    def time_ns(self, position: float) -> int:
        """Return the stamp [ns] of a position [s] after the first one."""
        return self.start_ns + round(position * _NS_PER_S)

    def position(self, time_ns: int) -> float:
        """Return the position [s] after the first stamp of a stamp [ns]."""
        return (time_ns - self.start_ns) / _NS_PER_S

    def moments(self, from_ns: int) -> Iterator[Moment]:
        """Yield the messages from a stamp on.

        Raises
        ------
        RecordingError
            If the bag is damaged.
        """
        messages = self._bag.timed(self.topics, from_ns)
        for time_ns, group in groupby(messages, key=itemgetter(0)):
            yield Moment(time_ns, self._ordered(time_ns, [(name, data) for _, name, data in group]))

    def latched(self, before_ns: int) -> list[tuple[str, bytes]]:
        """Return what whoever joins at a stamp would get of the latched topics."""
        latched = {name: topic for name, topic in self.topics.items() if topic.is_latched}
        last: dict[str, list[bytes]] = {}
        for time_ns, name, data in self._bag.timed(latched):
            if time_ns >= before_ns:
                break
            last[name] = [*last.get(name, []), data][-latched[name].qos.depth :]
        return [(name, data) for name, kept in last.items() for data in kept]

    def _ordered(self, time_ns: int, messages: list[tuple[str, bytes]]) -> list[tuple[str, bytes]]:
        """Sort the messages of one stamp by step, cause and order of recording."""
        steps = [self._step(name, data) for name, data in messages]
        current = next((step for step in steps if step is not None), 0)
        keys = []
        for i, (step, (name, _)) in enumerate(zip(steps, messages, strict=True)):
            # A message without a step belongs to the one that was recorded before it.
            current = current if step is None else step
            keys.append((current, self._ranks.get(name.rpartition("/")[2], _LAST), i))
        if self.ticks:
            keys.append((min(keys)[0], self._ranks[CLOCK.name.strip("/")], len(messages)))
            seconds, nanoseconds = divmod(time_ns, _NS_PER_S)
            if seconds >= _MOST_SECONDS:
                raise RecordingError(
                    f"{self._bag.path}: received a message of log time {seconds} s; required less "
                    f"than {_MOST_SECONDS} s, which a ROS clock can tell; the log time was "
                    "recorded so: record again"
                )
            stamp = (seconds, nanoseconds)
            tick = CLOCK.encode(stamp, 0, [stamp])
            messages = [*messages, (CLOCK.name, tick)]
        return [messages[key[2]] for key in sorted(keys)]

    def _step(self, name: str, data: bytes) -> int | None:
        return step_of(data) if self.topics[name].stepped else None


def _chosen(bag: Bag, wanted: Collection[str]) -> list[str]:
    chosen = []
    for word in wanted:
        short = word.strip("/")
        found = [n for n in bag.topics if n.strip("/") == short or n.rpartition("/")[2] == short]
        if word in bag.left_out:
            raise RecordingError(
                f"--topics: received {word!r}, which cannot be played ({bag.left_out[word]}); "
                f"required a topic of ROS 2 messages; choose another one"
            )
        if not found:
            raise RecordingError(
                f"--topics: received {word!r}; required a topic of {bag.path}: "
                f"{', '.join(sorted(bag.topics))}; correct the name"
            )
        chosen += found
    return list(dict.fromkeys(chosen)) if wanted else list(bag.topics)


def _topic(bag: Bag, name: str) -> PlayedTopic:
    stepped = bag.is_stepped(name)
    qos = strongest(bag.offered_qos(name))
    return PlayedTopic(name, bag.topics[name], bag.type_hash(name), qos, stepped)


def strongest(offers: Sequence[QosProfile]) -> QosProfile:
    """Return the profile that serves every subscriber that one of the ``offers`` served."""
    if not offers:
        return QosProfile()

    def any_is(field: str, strong: str, weak: str) -> str:
        return strong if any(getattr(offer, field) == strong for offer in offers) else weak

    return QosProfile(
        history=any_is("history", "keep_all", "keep_last"),
        depth=max(offer.depth for offer in offers) or _UNKNOWN_DEPTH,
        reliability=any_is("reliability", "reliable", "best_effort"),
        durability=any_is("durability", "transient_local", "volatile"),
        deadline_ns=_shortest([offer.deadline_ns for offer in offers]),
        lifespan_ns=max((offer.lifespan_ns or INFINITE_NS) for offer in offers),
        liveliness=any_is("liveliness", "manual_by_topic", "automatic"),
        liveliness_lease_ns=_shortest([offer.liveliness_lease_ns for offer in offers]),
    )


def _shortest(durations: Sequence[int]) -> int:
    """Return the shortest; zero means infinite, as in rmw."""
    return min((duration or INFINITE_NS) for duration in durations)
