"""Keys, read without waiting."""

from __future__ import annotations

import os

from spacecraft_gnc.cli._keys import Keys


def meanings(typed):
    ours, theirs = os.pipe()
    try:
        os.write(theirs, typed)
        keys = Keys(ours)
        found = []
        while (word := keys.next()) is not None:
            found.append(word)
        return found
    finally:
        os.close(ours)
        os.close(theirs)


def test_every_key_typed_is_heard_once_and_in_order():
    assert meanings(b" \x1b[D\x1b[C \x1b[A\x1bOBq") == [
        "pause",
        "back",
        "forward",
        "pause",
        "faster",
        "slower",
        "quit",
    ]


def test_other_keys_mean_nothing():
    assert meanings(b"xyz\x1b[5~") == []
    assert meanings(b"") == []
    assert meanings(b"?q") == ["quit"]
