"""Seals: only who has the key of a flight can write them, and everybody can read what is sealed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.signals.seal import (
    KEY,
    SIZE,
    KeyRefused,
    key_in,
    new_key,
    opener,
    sealer,
    without_seal,
)

FLIGHT = new_key()


@given(data=st.binary(max_size=300))
def test_a_seal_is_checked_and_removed(data: bytes) -> None:
    sealed = sealer(FLIGHT, "/attitude_state", "/plant")(data)
    assert len(sealed) == len(data) + SIZE
    assert opener(FLIGHT, "/attitude_state")(sealed) == data
    assert without_seal(sealed) == data


@given(data=st.binary(max_size=300), at=st.integers(0, 10_000), bit=st.integers(0, 7))
def test_no_changed_bit_passes(data: bytes, at: int, bit: int) -> None:
    sealed = bytearray(sealer(FLIGHT, "/attitude_state", "/plant")(data))
    place = at % len(sealed)
    sealed[place] ^= 1 << bit
    opened = opener(FLIGHT, "/attitude_state")(bytes(sealed))
    mark = range(len(data), len(data) + 4)  # tells where a seal is, and proves nothing
    assert opened is None or place in mark


@given(data=st.binary(max_size=300))
def test_bytes_of_a_stranger_are_refused(data: bytes) -> None:
    cut = opener(FLIGHT, "/attitude_state")
    assert cut(data) is None
    assert cut(sealer(new_key(), "/attitude_state", "/plant")(data)) is None
    assert cut(sealer(FLIGHT, "/attitude_reference", "/plant")(data)) is None  # replayed elsewhere


def test_without_a_key_nothing_is_sealed_nor_checked() -> None:
    assert opener(b"", "/clock")(b"1234") == b"1234"
    sealed = sealer(FLIGHT, "/clock", "/plant")(b"1234")
    assert opener(b"", "/clock")(sealed) == b"1234"


def test_a_message_is_taken_once_and_none_older_than_the_last() -> None:
    seal, other = (sealer(FLIGHT, "/attitude_state", name) for name in ("/plant", "/other"))
    first, second, of_other = seal(b"1"), seal(b"2"), other(b"3")
    cut = opener(FLIGHT, "/attitude_state")
    assert [cut(data) for data in (second, second, first)] == [b"2", None, None]
    assert cut(of_other) == b"3"  # each sender has its own order
    assert cut(seal(b"2")) == b"2"  # said again by its sender


@pytest.mark.parametrize(("text", "key"), [("", None), ("off", b""), ("00ff", b"\x00\xff")])
def test_the_key_of_an_environment(text: str, key: bytes | None) -> None:
    assert key_in({KEY: text}) == key
    assert key_in({}) is None


@pytest.mark.parametrize("text", ["no hex", "0", "00" * 33])
def test_what_is_no_key_is_refused_and_not_shown(text: str) -> None:
    with pytest.raises(KeyRefused, match="hexadecimal digits, or 'off'") as refusal:
        key_in({KEY: text})
    assert text not in str(refusal.value).replace(str(len(text)), "")


def test_keys_of_two_flights_differ() -> None:
    assert new_key() != new_key()
    assert len(new_key()) == 16


def test_ros_reads_sealed_messages() -> None:
    serialization = pytest.importorskip("rclpy.serialization")
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
    from rosgraph_msgs.msg import Clock
    from std_msgs.msg import String

    nested = DiagnosticArray(status=[DiagnosticStatus(name="plant")])
    for message in (String(data="/plant"), Clock(), nested):
        sealed = sealer(FLIGHT, "/a", "/plant")(serialization.serialize_message(message))
        assert serialization.deserialize_message(sealed, type(message)) == message
