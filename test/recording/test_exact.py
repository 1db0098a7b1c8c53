"""Messages count as exact where encoding what they decode to gives their bytes again."""

from __future__ import annotations

import numpy as np
import pytest
from flown_bags import flipped
from hypothesis import example, given
from hypothesis import strategies as st
from recording.bags import CODEC

from spacecraft_gnc.recording._layout import decode
from spacecraft_gnc.signals.attitude import GOVERNOR_STATUS
from spacecraft_gnc.signals.message import Refused
from spacecraft_gnc.vehicles.rigid_body.signals import TORQUE
from spacecraft_gnc.vehicles.two_wheel.signals import STATE

_IDENTITY = [0.0, 0.0, 0.0, 1.0]
_TRUE = [True, False, True]
MESSAGES = {
    TORQUE: TORQUE._codec.encode((3, 4), 7, ([1.0, -2.0, 3.0], 2)),
    GOVERNOR_STATUS: GOVERNOR_STATUS._codec.encode(
        (3, 4), 7, (0.5, True, 1.0, "sun", 3, -1, 9, 2)
    ),
    STATE: STATE._codec.encode(
        (3, 4), 7,
        (np.eye(3), _IDENTITY, [0.1] * 3, [0.2] * 3, [1.0] * 3, _TRUE, [2.0] * 3, 1, 5.0),
    ),
}  # fmt: skip
"""Of fixed length; with a string and a bool; with sequences."""
SIGNALS = list(MESSAGES)


def exact(signal, *messages):
    """Return whether each message is exact, in their order."""
    found = np.zeros(len(messages), dtype=bool)
    for group in decode(CODEC.store.fielddefs, signal.type, messages):
        found[group.rows] = group.exact
    return found.tolist()


def again(signal, data):
    """Return the bytes of what a message decodes to."""
    message = signal.read(data)
    if message["frame_id"] != signal.frame:
        return None  # encoded again with the signal's own frame
    values = [message.slots[message.places[name]] for name in signal.fields]
    texts = [
        value.rstrip(b"\0").decode() if isinstance(value, bytes) else value for value in values
    ]
    return signal._codec.encode(message.stamp, message.step, texts)


@pytest.mark.parametrize("signal", SIGNALS, ids=str)
def test_what_a_signal_encodes_is_exact(signal):
    data = MESSAGES[signal]
    assert exact(signal, data, data) == [True, True]
    assert again(signal, data) == data


@given(signal=st.sampled_from(SIGNALS), place=st.floats(0.0, 1.0, exclude_max=True))
@example(signal=TORQUE, place=27.0 / len(MESSAGES[TORQUE]) + 1e-9)
@example(signal=STATE, place=0.999)
def test_one_bit_is_exact_where_it_decodes_and_encodes_to_itself(signal, place):
    data = flipped(MESSAGES[signal], int(place * 8 * len(MESSAGES[signal])))
    try:
        expected = again(signal, data)
    except (Refused, UnicodeDecodeError, OverflowError):
        return  # no message, or of a text that no encoder gives
    try:
        found = exact(signal, data)
    except Exception as error:  # noqa: BLE001 - a length that does not fit is refused elsewhere
        assert "received" in str(error)  # noqa: PT017
        return
    if expected is not None:
        assert found == [expected == data]


@pytest.mark.parametrize(
    "change",
    [
        lambda data: data + b"\0\0\0\0",
        lambda data: data[:2] + b"\0\1" + data[4:],
        lambda data: data.replace(b"sun", b"\xff\xfe\xfd"),
        lambda data: data.replace(b"sun\0", b"su\0\0"),
    ],
    ids=["longer", "options", "no UTF-8", "two NULs"],
)
def test_other_forms_of_a_message_are_not_exact(change):
    data = MESSAGES[GOVERNOR_STATUS]
    assert change(data) != data
    assert exact(GOVERNOR_STATUS, change(data)) == [False]


def test_an_end_that_is_not_padded_is_not_exact():
    assert exact(TORQUE, MESSAGES[TORQUE][:-3]) == [False]


def test_a_bool_is_0_or_1():
    data = MESSAGES[GOVERNOR_STATUS]
    bools = [
        i for i in range(40, 60) if data[i] == 1 and data[i - 8 : i] == b"\0" * 6 + b"\xe0\x3f"
    ]
    (place,) = bools
    assert exact(GOVERNOR_STATUS, data[:place] + b"\2" + data[place + 1 :]) == [False]
