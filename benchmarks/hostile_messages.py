"""Hostile messages: what a stranger may put on a topic of the graph, each of a named kind, seeded.

All kinds are bytes; what makes them hostile is said by their functions. None is without a byte: of
a writer that sends one without any, DDS delivers nothing more. On a topic that users may
publish on (a target) only what its declaration refuses is sent: a target that is one would rightly
be flown to.
"""

from __future__ import annotations

import random
import struct
from collections import deque
from collections.abc import Callable
from functools import lru_cache
from typing import Any, Final

from rclpy.serialization import serialize_message

from spacecraft_gnc.ros.endpoints import message_type
from spacecraft_gnc.signals import Refused, Signal
from spacecraft_gnc.signals.codec import LITTLE_ENDIAN
from spacecraft_gnc.signals.seal import without_seal

_HEAD: Final = len(LITTLE_ENDIAN)  # bytes before the payload
_STAMP: Final = struct.Struct("<iI")
_STEP: Final = struct.Struct("<Q")
_NUMBER: Final = struct.Struct("<d")
_LENGTH: Final = struct.Struct("<I")
_ALIGNMENT: Final = 8  # [bytes] of a step
_STEPS: Final = (2**62, 2**63 - 1, 2**63, 2**64 - 1)
_NUMBERS: Final = (float("nan"), float("inf"), float("-inf"), 1e308, 5e-324, -1e300)
_ENCAPSULATIONS: Final = (b"\0\0\0\0", b"\0\3\0\0", b"\0\7\0\0", b"\0\x0b\0\0", b"\xff" * 4, b"")
_LONG, _HUGE = 10_000, 1_000_000  # characters
_HUGE_SHARE: Final = 0.02  # of the long ones
_SAMPLES: Final = 200  # genuine messages kept of a topic
_TRIES: Final = 20


class Genuine:
    """Messages of the nodes as they were heard, seals and all, by topic and by type."""

    def __init__(self) -> None:
        self._heard: dict[str, deque[bytes]] = {}
        self._of_type: dict[str, deque[bytes]] = {}

    def hear(self, signal: Signal, topic: str, data: bytes) -> None:
        """Keep a message."""
        for kept, key in ((self._heard, topic), (self._of_type, signal.type)):
            kept.setdefault(key, deque(maxlen=_SAMPLES)).append(data)

    def replay(self, topic: str, chance: random.Random) -> bytes | None:
        """Return a message that was heard before; None: none was."""
        heard = self._heard.get(topic)
        return chance.choice(list(heard)[: _SAMPLES // 2 or 1]) if heard else None

    def sample(self, signal: Signal, chance: random.Random) -> bytes:
        """Return a message of a signal's type, without its seal; an empty one if none was heard."""
        heard = self._of_type.get(signal.type)
        if not heard:
            return bytes(serialize_message(message_type(signal.type)()))
        return without_seal(chance.choice(list(heard)))


class Attack:
    """Makes hostile messages.

    Parameters
    ----------
    seed
        Of all that is random.
    genuine
        What was heard of the graph; it grows meanwhile.
    """

    def __init__(self, seed: int, genuine: Genuine) -> None:
        self._chance = random.Random(seed)  # noqa: S311
        self._genuine = genuine
        self._kinds: dict[str, Callable[[Signal, str], bytes | None]] = {
            "random bytes": self._random,
            "truncated": self._truncated,
            "bits flipped": self._flipped,
            "NaN and infinite": self._not_finite,
            "extreme step": self._extreme_step,
            "negative stamp": self._negative_stamp,
            "empty": self._empty,
            "wrong encapsulation": self._encapsulation,
            "huge strings": self._huge,
            "replayed": self._replayed,
        }

    @property
    def kinds(self) -> tuple[str, ...]:
        """Names of the kinds."""
        return tuple(self._kinds)

    def message(self, signal: Signal, topic: str) -> tuple[str, bytes]:
        """Return (kind, bytes) of the next message for a topic."""
        for _ in range(_TRIES):
            kind = self._chance.choice(self.kinds)
            data = self._kinds[kind](signal, topic)
            if data is not None and is_fixed(signal.type):
                data = data[: len(self._sample(signal))]  # DDS would refuse more on our side
            if data and (signal.publishers or _is_refused(signal, data)):
                return kind, data
        return "empty", self._empty(signal, topic)

    def _sample(self, signal: Signal) -> bytearray:
        return bytearray(self._genuine.sample(signal, self._chance))

    def _random(self, signal: Signal, topic: str) -> bytes:
        """Anything, with or without the encapsulation of a message."""
        head = self._chance.choice((b"", LITTLE_ENDIAN))
        return head + self._chance.randbytes(self._chance.randrange(600))

    def _truncated(self, signal: Signal, topic: str) -> bytes:
        data = self._sample(signal)
        return bytes(data[: self._chance.randrange(len(data))])

    def _flipped(self, signal: Signal, topic: str) -> bytes:
        data = self._sample(signal)
        for _ in range(self._chance.randint(1, 8)):
            data[self._chance.randrange(len(data))] ^= 1 << self._chance.randrange(8)
        return bytes(data)

    def _not_finite(self, signal: Signal, topic: str) -> bytes | None:
        """Numbers that are none, in one of the last words: the first ones are header and step."""
        data = self._sample(signal)
        words = (len(data) - _HEAD) // _NUMBER.size
        if words < 2:
            return None
        word = self._chance.randrange(words // 2, words)
        _NUMBER.pack_into(data, _HEAD + _NUMBER.size * word, self._chance.choice(_NUMBERS))
        return bytes(data)

    def _extreme_step(self, signal: Signal, topic: str) -> bytes | None:
        """Give it a step that no flight comes to: after it every real one would be old."""
        data = self._sample(signal)
        at = step_at(signal)
        if at is None:
            if signal.type.endswith("UInt64"):
                at = _HEAD
            else:
                return None
        _STEP.pack_into(data, at, self._chance.choice(_STEPS))
        return bytes(data)

    def _negative_stamp(self, signal: Signal, topic: str) -> bytes | None:
        if not signal.is_stamped:
            return None
        data = self._sample(signal)
        seconds = self._chance.choice((-1, -(2**31), 2**31 - 1))
        _STAMP.pack_into(data, _HEAD, seconds, self._chance.choice((0, 10**9, 2**32 - 1)))
        return bytes(data)

    def _empty(self, signal: Signal, topic: str) -> bytes:
        """Return the message that ROS makes unless told otherwise: arrays empty, numbers zero."""
        return bytes(serialize_message(message_type(signal.type)()))

    def _encapsulation(self, signal: Signal, topic: str) -> bytes:
        return self._chance.choice(_ENCAPSULATIONS) + bytes(self._sample(signal)[_HEAD:])

    def _huge(self, signal: Signal, topic: str) -> bytes:
        """Give it a string of up to a megabyte, or a length that promises one."""
        is_huge = self._chance.random() < _HUGE_SHARE
        message = message_type(signal.type)()
        if _fill(message, "x" * (_HUGE if is_huge else _LONG)):
            return bytes(serialize_message(message))
        data = self._sample(signal)
        _LENGTH.pack_into(data.ljust(_HEAD + 4, b"\0"), _HEAD, 2**31 - 1)
        return bytes(data)

    def _replayed(self, signal: Signal, topic: str) -> bytes | None:
        """Repeat a genuine message, byte for byte, long after its step."""
        return self._genuine.replay(topic, self._chance)


def step_at(signal: Signal) -> int | None:
    """Return where a message of a signal has its step; None: it has none."""
    if not signal.is_stepped:
        return None
    end = _STAMP.size + _LENGTH.size + len(signal.frame) + 1
    return _HEAD + end + -end % _ALIGNMENT


@lru_cache(maxsize=64)
def is_fixed(type_name: str) -> bool:
    """Tell whether all messages of a type have one size."""
    fields = message_type(type_name).get_fields_and_field_types().values()
    nested = [kind for kind in fields if "/" in kind]
    is_flat = not any("string" in kind or "sequence" in kind for kind in fields)
    return is_flat and all(is_fixed(kind.replace("/", "/msg/")) for kind in nested)


def _is_refused(signal: Signal, data: bytes) -> bool:
    try:
        signal.decode(data)
    except Refused:
        return True
    return False


def _fill(message: Any, text: str) -> bool:
    """Put a text into the first string of a message; return whether it has one."""
    for name, kind in message.get_fields_and_field_types().items():
        if kind == "string":
            setattr(message, name, text)
            return True
        is_single = "/" in kind and not kind.endswith("]") and not kind.startswith("sequence")
        if is_single and _fill(getattr(message, name), text):
            return True
    return False
