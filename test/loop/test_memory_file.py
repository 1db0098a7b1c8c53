"""Plain values as bytes, and the file that outlives a process."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from spacecraft_gnc.loop.memory_file import MemoryFile
from spacecraft_gnc.loop.plain import pack, unpack

LEAVES = (
    st.none()
    | st.booleans()
    | st.integers(-(2**63), 2**63 - 1)
    | st.floats(allow_nan=False)
    | st.text()
    | st.binary()
)
PLAIN = st.recursive(LEAVES, lambda inner: st.lists(inner).map(tuple))
ARRAYS = arrays(np.float64, array_shapes(min_dims=0, min_side=0)) | arrays(
    np.int64, array_shapes(min_dims=0, min_side=0)
)


@pytest.fixture
def descriptor() -> Iterator[int]:
    with tempfile.TemporaryFile() as file:
        yield file.fileno()


@given(PLAIN)
def test_plain_values_come_back(value: object) -> None:
    assert unpack(pack(value)) == value


@given(ARRAYS, st.booleans())
def test_arrays_come_back_to_the_last_bit(array: np.ndarray, writeable: bool) -> None:
    array.setflags(write=writeable)
    (found,) = unpack(pack((array,)))
    assert found.tobytes() == array.tobytes()
    assert (found.shape, found.dtype) == (array.shape, array.dtype)
    assert found.flags.writeable == writeable
    assert found.flags.c_contiguous


@given(PLAIN, st.data())
def test_cut_bytes_are_refused(value: object, data: st.DataObject) -> None:
    whole = pack((value, 1))
    cut = data.draw(st.integers(0, len(whole) - 1))
    with pytest.raises(ValueError, match="bytes: received"):
        unpack(whole[:cut])


@settings(max_examples=300)
@given(st.binary(max_size=60))
def test_any_bytes_are_a_value_or_refused(data: bytes) -> None:
    with suppress(ValueError):
        unpack(data)


def test_what_is_not_plain_is_refused() -> None:
    with pytest.raises(TypeError, match="received a object; required plain"):
        pack((object(),))


def test_the_newest_memory_before_a_step_is_found(descriptor: int) -> None:
    file = MemoryFile(descriptor)
    assert file.find(10) is None
    file.keep(-1, b"start")
    for k in range(4):
        file.note(k, (b"state %d" % k, b"reference"))
    file.keep(3, b"memory after 3")
    file.note(4, (b"state 4", b""))
    again = MemoryFile(descriptor)
    found = again.find(5)
    assert found is not None
    assert (found.step, found.memory, found.steps) == (3, b"memory after 3", ((b"state 4", b""),))
    found = again.find(4)
    assert found is not None
    assert (found.step, found.steps) == (3, ())
    found = again.find(3)  # answered, but not published: from before
    assert found is not None
    assert (found.memory, len(found.steps)) == (b"start", 3)
    again.go_on(found)
    again.note(3, (b"another 3", b""))
    found = MemoryFile(descriptor).find(4)
    assert found is not None
    assert found.step == 3  # the newer half is still whole
    again.keep(3, b"memory after the other 3")
    found = MemoryFile(descriptor).find(4)
    assert found is not None
    assert found.memory == b"memory after the other 3"


def test_old_records_behind_new_ones_do_not_count(descriptor: int) -> None:
    file = MemoryFile(descriptor)
    for first in (0, 10, 20):
        file.keep(first - 1, b"m")
        for k in range(first, first + 10 - first // 4):
            file.note(k, (b"state", b"reference"))
    found = MemoryFile(descriptor).find(100)
    assert found is not None
    assert (found.step, len(found.steps)) == (19, 5)


@pytest.mark.parametrize("seed", range(20))
def test_damage_leaves_what_comes_before(descriptor: int, seed: int) -> None:
    draw = random.Random(seed)
    file = MemoryFile(descriptor)
    file.keep(-1, b"first memory")
    states = [bytes([k]) * 40 for k in range(8)]
    for k, state in enumerate(states):
        file.note(k, (state, b"r"))
    file.keep(7, b"second memory")
    at = draw.randrange(400)
    (byte,) = os.pread(descriptor, 1, at)
    os.pwrite(descriptor, bytes([byte ^ 1 << draw.randrange(8)]), at)
    for step in range(8):
        found = MemoryFile(descriptor).find(step)
        if found is not None:
            assert found.memory == b"first memory"
            assert [state for state, _ in found.steps] == states[: len(found.steps)]
    found = MemoryFile(descriptor).find(8)
    assert found is not None
    assert found.memory == b"second memory"


WRITER = """
import sys
from spacecraft_gnc.loop.memory_file import MemoryFile
file = MemoryFile(int(sys.argv[1]))
file.keep(-1, b"-1" * 50)
print("writing", flush=True)
for k in range(10**9):
    file.note(k, (b"%d" % k * 20, b"%d" % -k * 9))
    if k % 7 == 0:
        file.keep(k, b"%d" % k * 50)
"""


@pytest.mark.parametrize("seed", range(5))
def test_a_writer_killed_at_any_instruction_leaves_a_whole_past(descriptor: int, seed: int) -> None:
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(descriptor)],
        pass_fds=(descriptor,),
        stdout=subprocess.PIPE,
    )
    assert writer.stdout is not None
    assert writer.stdout.readline() == b"writing\n"
    with pytest.raises(subprocess.TimeoutExpired):
        writer.wait(random.Random(seed).uniform(0.0, 0.05))
    writer.send_signal(signal.SIGKILL)
    writer.wait()
    writer.stdout.close()
    found = MemoryFile(descriptor).find(2**60)
    assert found is not None
    assert found.memory == b"%d" % found.step * 50
    for k, inputs in enumerate(found.steps, found.step + 1):
        assert inputs == (b"%d" % k * 20, b"%d" % -k * 9)
    last = found.step + len(found.steps)
    before = MemoryFile(descriptor).find(last)  # the last one may not have been published
    assert before is not None
    assert before.step + len(before.steps) == last - 1


def test_a_full_file_forgets_and_goes_on(descriptor: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("spacecraft_gnc.loop.memory_file._HALF", 4096)
    file = MemoryFile(descriptor)
    file.keep(-1, b"m")
    for k in range(100):
        file.note(k, (b"state" * 10, b"r"))
    assert file.find(100) is None
    file.keep(99, b"again")
    file.note(100, (b"state", b"r"))
    found = file.find(101)
    assert found is not None
    assert (found.memory, len(found.steps)) == (b"again", 1)
    file.keep(100, bytes(5000))
    assert file.find(101) is None
