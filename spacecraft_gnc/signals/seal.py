"""Seals of messages: proof that a node of this flight sent them.

rclpy 7.1 does not tell which publisher sent a message (its message info has sequence numbers, but
no GID), and a GID could be imitated. So every node of a launch has a key that the launcher made,
and appends to each serialized message who sent it, when, and a keyed hash (BLAKE2s) of topic,
message and both. A message is taken once: of each sender only what is newer than the last, so that
nobody can repeat what was overheard. ROS readers ignore bytes after the last field, so everybody
can still read the messages; only who has the key can write them. Bags hold the messages without
their seals, so two flights record the same bytes.

A node without a key, started by hand, neither seals nor checks.
"""

from __future__ import annotations

import hmac
import secrets
import time
from collections.abc import Callable, Mapping
from hashlib import blake2s
from struct import Struct
from typing import Final

from spacecraft_gnc.errors import GncError

KEY: Final = "SPACECRAFT_GNC_KEY"
"""Environment variable with the key of a flight, in hexadecimal."""
_MARK: Final = b"\xffGNC"
_HASH_SIZE: Final = 8  # [bytes]
_HEAD: Final = Struct("<4s4sQ")  # mark, sender, time [ns] of the machine since its start
SIZE: Final = _HEAD.size + _HASH_SIZE  # [bytes], a multiple of four, to which RTPS pads
_KEY_SIZE: Final = 16  # [bytes]

OFF: Final = "off"
"""Value of `KEY` under which nothing is sealed."""
_LARGEST_KEY: Final = 32  # [bytes]

Cut = Callable[[bytes], "bytes | None"]
"""Returns a message without its seal; None: it has none that fits, or was taken before."""


class KeyRefused(GncError):
    """The environment holds something else than a key."""


def new_key() -> bytes:
    """Return a random key of a flight."""
    return secrets.token_bytes(_KEY_SIZE)


def key_in(environment: Mapping[str, str]) -> bytes | None:
    """Return the key of the flight that an environment belongs to; empty: none is wanted.

    None where it says nothing of it.

    Raises
    ------
    KeyRefused
        If it is none.
    """
    text = environment.get(KEY, "")
    if text in ("", OFF):
        return b"" if text else None
    try:
        key = bytes.fromhex(text)
    except ValueError:
        key = b""
    if not 1 <= len(key) <= _LARGEST_KEY:
        raise KeyRefused(
            f"{KEY}: received {len(text)} characters that are no key; required 2 to "
            f"{2 * _LARGEST_KEY} hexadecimal digits, or {OFF!r}; unset it"
        )
    return key


def sealer(key: bytes, topic: str, sender: str) -> Callable[[bytes], bytes]:
    """Return what seals a sender's messages of a topic; both are named in full."""
    blank = _blank(key, topic)
    who = blake2s(sender.encode(), digest_size=4).digest()

    def seal(data: bytes) -> bytes:
        message = data + _HEAD.pack(_MARK, who, time.monotonic_ns())
        digest = blank.copy()
        digest.update(message)
        return message + digest.digest()

    return seal


def opener(key: bytes, topic: str) -> Cut:
    """Return what checks and removes the seals of the messages of a topic, named in full.

    Without a key it checks nothing, and removes what looks like a seal.
    """
    if not key:
        return without_seal
    blank = _blank(key, topic)
    latest: dict[bytes, int] = {}

    def cut(data: bytes) -> bytes | None:
        digest = blank.copy()
        digest.update(data[:-_HASH_SIZE])
        if not hmac.compare_digest(digest.digest(), data[-_HASH_SIZE:]):
            return None
        _, who, sent = _HEAD.unpack_from(data, len(data) - SIZE)
        if sent <= latest.get(who, -1):
            return None
        latest[who] = sent
        return data[:-SIZE]

    return cut


def without_seal(data: bytes) -> bytes:
    """Return a message without its seal, if it has one; unchecked, for those who only look on."""
    at = len(data) - SIZE
    return data[:at] if at >= 0 and data.startswith(_MARK, at) else data


def _blank(key: bytes, topic: str) -> blake2s:
    return blake2s(topic.encode() + b"\0", digest_size=_HASH_SIZE, key=key)
