"""``gnc replay --publish`` ends well only where it played all that the bag's files hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import pytest

from spacecraft_gnc.cli._common import RunFailed
from spacecraft_gnc.cli._play import require_all_played


class Held(NamedTuple):
    """What of a `Playback` is asked."""

    held: dict[str, int]
    left_out: dict[str, str] = {}  # noqa: RUF012  # never changed


class Count(NamedTuple):
    """What of `Played` is asked."""

    messages: dict[str, int]
    rounds: int = 1
    jumped: bool = False
    interrupted: bool = False


ALL = {"/attitude_state": 51, "/clock": 50}
SHORT = {"/attitude_state": 18, "/clock": 50}


def check(held: Held, count: Count, start: float = 0.0) -> None:
    require_all_played(Path("bag"), start, held, count)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "count",
    [
        Count(ALL),
        Count(ALL | {"/more": 1}),
        Count(SHORT, rounds=2),
        Count(SHORT, jumped=True),
        Count(SHORT, interrupted=True),
    ],
)
def test_played_as_asked(count: Count) -> None:
    check(Held(ALL), count)


def test_played_from_within() -> None:
    check(Held(ALL), Count(SHORT), start=8.0)


@pytest.mark.parametrize("count", [Count(SHORT), Count({})])
def test_fewer_messages_than_the_files_hold(count: Count) -> None:
    played = count.messages.get("/attitude_state", 0)
    with pytest.raises(RunFailed, match=f"/attitude_state: played {played} .*; required 51"):
        check(Held(ALL), count)


@pytest.mark.parametrize(
    ("held", "words"),
    [({"/raw": 1}, "/raw not played; required all that it holds; .* --topics"), ({}, "")],
)
def test_a_topic_left_out_fails_if_it_holds_messages(held: dict[str, int], words: str) -> None:
    bag: Any = Held(ALL | held, {"/raw": "no ROS 2 message"})
    if not words:
        check(bag, Count(ALL))
        return
    with pytest.raises(RunFailed, match=words):
        check(bag, Count(ALL))
