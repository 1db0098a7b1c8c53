"""File in which a core's memory outlives its process: a memory, and the inputs of the steps since.

The file is mapped, so that what is written there stays when the process is killed, at whatever
instruction. It has two halves. Each holds a memory after some step and, behind it, the inputs of
the steps that were answered since, one after the other; a new memory is written to the other half.
The older one stays whole until then, with the inputs up to the step of the newer one: a step that
was answered, but not published, can be answered again from the memory before it. Checksums and a
sequence number in each record tell where what was written ends.
"""

from __future__ import annotations

import mmap
import os
import struct
import zlib
from typing import Final, NamedTuple

_HALF: Final = 1 << 25  # [bytes], of which only those count that were written to
_MEMORY: Final = struct.Struct("<QqII")  # sequence number, step, length, checksum
_INPUTS: Final = struct.Struct("<QqIII")  # sequence number, step, two lengths, checksum

Inputs = tuple[bytes, bytes]
"""What a step is answered from, as messages: the state, and the reference or nothing."""


class Kept(NamedTuple):
    """What was found in a file."""

    step: int
    """After which the memory was kept; -1: before the first step."""
    memory: bytes
    steps: tuple[Inputs, ...]
    """Inputs of the steps answered since."""
    half: int
    end: int
    """Where the inputs of the next step go."""


class MemoryFile:
    """Keep a core's memory and the inputs since.

    Parameters
    ----------
    descriptor : int
        Of an open file, which is made as large as needed; it may be closed afterwards.
    """

    def __init__(self, descriptor: int) -> None:
        size = 2 * _HALF
        if os.fstat(descriptor).st_size != size:
            os.ftruncate(descriptor, size)
        self._map = mmap.mmap(descriptor, size)
        found = [kept for kept in map(self._read, (0, 1)) if kept is not None]
        self._number = max((self._number_of(kept.half) for kept in found), default=0)
        self._half, self._end, self._number_here = 1, 0, 0
        self._is_open = False

    def find(self, step: int) -> Kept | None:
        """Return the newest memory from before a step, with inputs of steps before it only."""
        found = [kept for kept in map(self._read, (0, 1)) if kept is not None and kept.step < step]
        if not found:
            return None
        newest = max(found, key=lambda kept: self._number_of(kept.half))
        return self._read(newest.half, step)

    def go_on(self, kept: Kept) -> None:
        """Add further inputs behind those found."""
        self._half, self._end, self._is_open = kept.half, kept.end, True
        self._number_here = self._number_of(kept.half)

    def keep(self, step: int, memory: bytes) -> None:
        """Keep a memory after a step; the one before stays until the next."""
        half = 1 - self._half
        at, number = half * _HALF, self._number + 1
        self._map[at : at + _MEMORY.size] = bytes(_MEMORY.size)
        self._is_open = _MEMORY.size + len(memory) <= _HALF
        if not self._is_open:
            self.clear()
            return
        self._half, self._end = half, _MEMORY.size + len(memory)
        self._number = self._number_here = number
        self._map[at + _MEMORY.size : at + self._end] = memory
        check = _checksum(number, step, memory)
        _MEMORY.pack_into(self._map, at, number, step, len(memory), check)

    def note(self, step: int, inputs: Inputs) -> None:
        """Add the inputs of a step. Where there is no room left, nothing is remembered any more."""
        if not self._is_open:
            return
        state, reference = inputs
        first = self._end + _INPUTS.size
        second = first + len(state)
        end = second + len(reference)
        if end > _HALF:
            self.clear()
            return
        at, data, number = self._half * _HALF, self._map, self._number_here
        data[at + first : at + second] = state
        data[at + second : at + end] = reference
        check = _checksum(number, step, state, reference)
        lengths = len(state), len(reference)
        _INPUTS.pack_into(data, at + self._end, number, step, *lengths, check)
        self._end = end

    def clear(self) -> None:
        """Forget everything."""
        for half in (0, 1):
            self._map[half * _HALF : half * _HALF + _MEMORY.size] = bytes(_MEMORY.size)
        self._is_open = False

    def _number_of(self, half: int) -> int:
        return int(_MEMORY.unpack_from(self._map, half * _HALF)[0])

    def _read(self, half: int, before: int | None = None) -> Kept | None:
        """Return what a half holds; None: nothing that is whole."""
        at, data = half * _HALF, self._map
        number, step, length, check = _MEMORY.unpack_from(data, at)
        if number == 0 or length > _HALF - _MEMORY.size:
            return None
        memory = data[at + _MEMORY.size : at + _MEMORY.size + length]
        if check != _checksum(number, step, memory):
            return None
        end, steps = _MEMORY.size + length, []
        while end + _INPUTS.size <= _HALF:
            mine, k, n_state, n_reference, check = _INPUTS.unpack_from(data, at + end)
            first = end + _INPUTS.size
            second, last = first + n_state, first + n_state + n_reference
            if mine != number or last > _HALF or (before is not None and k >= before):
                break
            inputs = data[at + first : at + second], data[at + second : at + last]
            if check != _checksum(number, k, *inputs):
                break
            steps.append(inputs)
            end = last
        return Kept(step, memory, tuple(steps), half, end)


def _checksum(number: int, step: int, *parts: bytes) -> int:
    check = number & 0xFFFFFFFF ^ step & 0xFFFFFFFF
    for part in parts:
        check = zlib.crc32(part, check)
    return check
