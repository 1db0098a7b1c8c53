"""Message definitions of a bag, parsed on demand so that a foreign one harms no other."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final

from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from spacecraft_gnc.recording._index import ChannelInfo

_CDR: Final = "cdr"
_MSG: Final = "ros2msg"
_IDL: Final = ("ros2idl", "omgidl")
_MESSAGE_NAME: Final = re.compile(r"[A-Za-z]\w*/msg/[A-Za-z]\w*")
_IDL_SEPARATOR: Final = "=" * 80 + "\n"
_HASH: Final = "RIHS01_"


def foreign(channel: ChannelInfo) -> str:
    """Return why a channel holds no ROS 2 messages; empty where it does."""
    if not channel.schema_encoding:
        return f"encoding {channel.encoding or 'unknown'}, without a message definition"
    if channel.encoding != _CDR:
        return f"encoding {channel.encoding or 'unknown'}, not {_CDR}"
    if channel.schema_encoding not in (_MSG, *_IDL):
        return f"its definition is {channel.schema_encoding}, not {_MSG}"
    if not _MESSAGE_NAME.fullmatch(channel.type_name):
        return f"{channel.type_name or 'its type'} is no ROS 2 message"
    return ""


def type_hash(channel: ChannelInfo) -> str:
    """Return the REP-2011 hash of a channel's type, computed from its definition.

    Raises
    ------
    ValueError
        If the channel tells another one.
    Exception
        Whatever the definition makes the parser raise.
    """
    found = _store(channel.type_name, channel.schema_encoding, channel.definition).hash_rihs01(
        channel.type_name
    )
    told = channel.metadata.get("topic_type_hash", "")
    if told.startswith(_HASH) and told != found:
        raise ValueError(f"message type {channel.type_name}: hash mismatch {found} != {told}")
    return found


def typestore(channel: ChannelInfo) -> Typestore:
    """Return the types that a channel's definition holds."""
    return _store(channel.type_name, channel.schema_encoding, channel.definition)


@lru_cache(maxsize=64)
def _store(type_name: str, encoding: str, definition: str) -> Typestore:
    store = get_typestore(Stores.EMPTY)
    if encoding == _MSG:
        store.register(get_types_from_msg(definition, type_name))
        return store
    parts = [definition]
    if definition.startswith(f"{_IDL_SEPARATOR}IDL: "):
        parts = [part.partition("\n")[2] for part in definition.split(_IDL_SEPARATOR)[1:]]
    types = {}
    for part in parts:
        types.update(get_types_from_idl(part))
    store.register(types)
    return store
