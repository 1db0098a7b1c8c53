"""Counters of one recorded topic."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import NamedTuple

from spacecraft_gnc.recording.metadata import TopicSummary

_UINT32 = struct.Struct("<I")
_UINT64 = struct.Struct("<Q")
_STAMP = struct.Struct("<iI")
_NS_PER_S = 1_000_000_000
_ENCAPSULATION = 4  # bytes before the CDR payload; alignment counts from their end
_FRAME_ID_AT = 12  # in the payload: stamp 8 bytes, length of the string 4
STEPPED_START = [("std_msgs/Header", "header"), ("uint64", "step")]
"""First fields of a message that belongs to a control step."""


class TopicCount(NamedTuple):
    """How many messages of a topic were recorded, and how many are known to be lost."""

    messages: int
    gaps: int
    """Control steps that never came (topics whose messages carry a step)."""
    repeats: int
    """Messages of a step that had come before, or that came out of order."""
    lost: int
    """Messages known to be lost."""


@dataclass(slots=True)
class Topic:
    """A topic being recorded."""

    channel_id: int
    type_name: str
    qos_yaml: str
    type_hash: str
    stepped: bool
    """Whether its messages start with `STEPPED_START`."""
    gapless: bool = True
    """Whether a step without a message is a loss."""
    reported: int = 0
    """Losses that the receiver knows of."""
    messages: int = 0
    gaps: int = 0
    repeats: int = 0
    next_step: int = 0

    @property
    def lost(self) -> int:
        """Messages known to be lost: what the receiver and the steps say is the same loss."""
        return max(self.reported, self.gaps if self.gapless else 0)

    @property
    def count(self) -> TopicCount:
        """What was counted so far."""
        return TopicCount(self.messages, self.gaps, self.repeats, self.lost)

    def summary(self, name: str) -> TopicSummary:
        """Return what metadata.yaml says of the topic."""
        return TopicSummary(
            name, self.type_name, self.qos_yaml, self.type_hash, self.messages, self.lost
        )

    def count_step(self, data: bytes) -> None:
        """Compare the step of a serialized message with the one expected."""
        step = step_of(data)
        if step is None:
            return
        if step >= self.next_step:
            self.gaps += step - self.next_step
            self.next_step = step + 1
        else:
            self.repeats += 1


def step_of(data: bytes) -> int | None:
    """Return the control step of a little-endian CDR message that starts with `STEPPED_START`.

    None where the message is too short to hold one.
    """
    try:
        length = _UINT32.unpack_from(data, _ENCAPSULATION + _FRAME_ID_AT - 4)[0]
        aligned = (_FRAME_ID_AT + length + 7) & ~7
        return int(_UINT64.unpack_from(data, _ENCAPSULATION + aligned)[0])
    except struct.error:
        return None


def time_in(data: bytes) -> int:
    """Return the time [ns] at the start of a little-endian CDR message.

    Raises
    ------
    struct.error
        If the message is too short to hold one.
    """
    seconds, nanoseconds = _STAMP.unpack_from(data, _ENCAPSULATION)
    return int(seconds * _NS_PER_S + nanoseconds)
