"""Seals of messages: proof that a node of this flight sent them.

rclpy 7.1 does not tell which publisher sent a message (its message info has sequence numbers, but
no GID), and a GID could be imitated. So every node of a launch has a key that the launcher made,
and appends to each serialized message a keyed hash (BLAKE2s) of topic and message. ROS readers
ignore bytes after the last field, so everybody can still read the messages; only who has the key
can write them. Bags hold the messages without their seals, so two flights record the same bytes.

A node without a key, started by hand, neither seals nor checks.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Callable, Mapping
from hashlib import blake2s
from typing import Final

KEY: Final = "SPACECRAFT_GNC_KEY"
"""Environment variable with the key of a flight, in hexadecimal."""
SIZE: Final = 12  # [bytes], a multiple of four, to which RTPS pads
_MARK: Final = b"\xffGNC"
_HASH_SIZE: Final = SIZE - len(_MARK)
_KEY_SIZE: Final = 16  # [bytes]

Cut = Callable[[bytes], "bytes | None"]
"""Returns a message without its seal; None: it has none that fits."""


def new_key() -> str:
    """Return a random key of a flight."""
    return secrets.token_hex(_KEY_SIZE)


def key_in(environment: Mapping[str, str]) -> bytes:
    """Return the key of the flight that an environment belongs to; empty: it has none."""
    try:
        return bytes.fromhex(environment.get(KEY, ""))
    except ValueError:
        return b""


def sealer(key: bytes, topic: str) -> Callable[[bytes], bytes]:
    """Return what seals the messages of a topic, named in full; without a key it leaves them."""
    if not key:
        return bytes
    blank = _blank(key, topic)

    def seal(data: bytes) -> bytes:
        digest = blank.copy()
        digest.update(data)
        return data + _MARK + digest.digest()

    return seal


def opener(key: bytes, topic: str) -> Cut:
    """Return what checks and removes the seal of a message of a topic, named in full.

    Without a key it checks nothing, and removes what looks like a seal.
    """
    if not key:
        return without_seal
    blank = _blank(key, topic)

    def cut(data: bytes) -> bytes | None:
        message, seal = data[:-SIZE], data[-_HASH_SIZE:]
        digest = blank.copy()
        digest.update(message)
        return message if hmac.compare_digest(digest.digest(), seal) else None

    return cut


def without_seal(data: bytes) -> bytes:
    """Return a message without its seal, if it has one; unchecked, for those who only look on."""
    is_sealed = data[-SIZE:-_HASH_SIZE] == _MARK
    return data[:-SIZE] if is_sealed else data


def _blank(key: bytes, topic: str) -> blake2s:
    return blake2s(topic.encode() + b"\0", digest_size=_HASH_SIZE, key=key)
