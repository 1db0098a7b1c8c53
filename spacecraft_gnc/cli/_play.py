"""``gnc replay --publish``: a bag into a live graph."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from spacecraft_gnc.cli._common import RunFailed, print_json
from spacecraft_gnc.cli._keys import pressed_keys
from spacecraft_gnc.cli._progress import show_progress
from spacecraft_gnc.errors import ParameterError, RecordingError
from spacecraft_gnc.launcher import domain, environment

if TYPE_CHECKING:
    from spacecraft_gnc.recording.play_clock import PlayClock
    from spacecraft_gnc.recording.playback import Playback
    from spacecraft_gnc.ros.player import Plan, Played

AS_FAST_AS_IT_GOES: Final = "max"
_KEYS: Final = "space pauses, left and right go 10 s, up and down double and halve the rate, q ends"


class Playing(NamedTuple):
    """What the user asks of the player."""

    source: Path
    rate: str
    start: float
    paused: bool
    loop: bool
    topics: list[str]
    expected: list[str]
    patience: float
    domain_id: int | None
    unfinished: bool
    as_json: bool
    quiet: bool


def play(wish: Playing) -> None:
    """Publish a bag and report what was published."""
    from spacecraft_gnc.recording.bag import open_bag
    from spacecraft_gnc.recording.playback import Playback
    from spacecraft_gnc.vehicles.known_signals import every_signal

    rate = parse_rate(wish.rate)
    if not 0.0 <= wish.patience < math.inf:
        raise ParameterError(
            f"--patience: received {wish.patience:g} s; required a finite number >= 0; give for "
            "example 2.0"
        )
    if wish.source.suffix == ".npz" and wish.source.is_file():
        raise RecordingError(
            f"{wish.source}: received arrays of gnc simulate; required a bag, whose messages are "
            "published as they were recorded; fly with gnc launch"
        )
    with open_bag(wish.source, allow_unfinished=wish.unfinished) as bag:
        playback = Playback(bag, wish.topics, every_signal())
        if not 0.0 <= wish.start <= playback.duration:
            raise ParameterError(
                f"--start: received {wish.start:g} s; required 0 to {playback.duration:g} s, the "
                "length of the bag; choose a place in it"
            )
        _require_played(playback, wish.expected)
        with _own_domain(wish) as domain_id:
            from spacecraft_gnc.ros.player import Plan

            plan = Plan(
                rate,
                wish.start,
                wish.paused,
                wish.loop,
                _full_names(playback, wish.expected),
                wish.patience,
            )
            _run(wish, playback, plan, domain_id)


def parse_rate(text: str) -> float:
    """Return a rate; 0 stands for as fast as it goes.

    Raises
    ------
    ParameterError
        If it is negative, infinite or no number.
    """
    if text.strip().lower() == AS_FAST_AS_IT_GOES:
        return 0.0
    try:
        rate = float(text)
    except ValueError:
        rate = -1.0
    if not 0.0 <= rate < math.inf:
        raise ParameterError(
            f"--rate: received {text!r}; required a number >= 0, where 0 or "
            f"{AS_FAST_AS_IT_GOES!r} means as fast as it goes; give for example 1.0"
        )
    return rate


def _matching(playback: Playback, word: str) -> list[str]:
    short = word.strip("/")
    return [n for n in playback.topics if n.strip("/") == short or n.rpartition("/")[2] == short]


def _require_played(playback: Playback, expected: list[str]) -> None:
    for word in expected:
        if not _matching(playback, word):
            raise ParameterError(
                f"--wait-for: received {word!r}; required a topic that is played: "
                f"{', '.join(sorted(playback.topics))}; correct the name"
            )


def _full_names(playback: Playback, words: list[str]) -> tuple[str, ...]:
    return tuple(name for word in words for name in _matching(playback, word))


@contextmanager
def _own_domain(wish: Playing) -> Iterator[int]:
    """Hold a domain, and the right to its clock, as the launcher and the plant do."""
    about = {"scenario": f"replay of {wish.source}"}
    given = wish.domain_id
    if given is None and os.environ.get(environment.DOMAIN_ID):
        given = environment.domain_id(os.environ)
    graph = domain.claim_free(about) if given is None else domain.claim_given(given, about)
    clock = domain.claim(domain.CLOCK, graph.domain_id, about)
    try:
        yield graph.domain_id
    finally:
        clock.release()
        graph.release()


def _run(wish: Playing, playback: Playback, plan: Plan, domain_id: int) -> None:
    from spacecraft_gnc.ros.player import Player

    silent = wish.quiet or wish.as_json
    with Player(playback, plan, domain_id) as player, pressed_keys() as key:
        if not wish.quiet:
            where = (
                f"{playback.duration:g} s on ROS_DOMAIN_ID={domain_id}; look at it with gnc inspect"
            )
            stream = sys.stderr if wish.as_json else sys.stdout
            print(f"{wish.source}: {where} topics --domain-id {domain_id}", file=stream, flush=True)
        if key is not None and not silent:
            print(_KEYS, flush=True)
        for remark in playback.remarks():
            print(f"warning: {remark}", file=sys.stderr, flush=True)
        player.await_subscribers()
        if wish.expected and player.played.unheard:
            unheard = ", ".join(player.played.unheard)
            text = f"warning: nobody listens to {unheard} after {plan.patience:g} s"
            print(text, file=sys.stderr, flush=True)
        with show_progress("playing", silent=silent) as progress:

            def watch(clock: PlayClock, position: float) -> str | None:
                state = "paused" if clock.paused else f"at rate {clock.rate:g}"
                state = state if clock.paused or clock.rate else "as fast as it goes"
                progress(int(position), int(playback.duration), f"playing {state}, seconds")
                return None if key is None else key()

            played = player.run(watch)
    _report(wish, playback, played, domain_id)
    require_all_played(wish.source, wish.start, playback, played)


def require_all_played(source: Path, start: float, playback: Playback, played: Played) -> None:
    """Refuse to end well when less was played than the bag holds.

    Whoever goes elsewhere in between, or ends before, plays what was asked for.

    Raises
    ------
    RunFailed
        If a topic was left out, or fewer messages were published than recorded.
    """
    if played.interrupted:
        return
    absent = [name for name in playback.held if name in playback.left_out]
    if absent:
        raise RunFailed(
            f"{source}: {', '.join(absent)} not played; required all that it holds; name "
            "what is to be played with --topics"
        )
    if start > 0.0 or played.jumped or played.rounds != 1:
        return
    for name, held in playback.held.items():
        count = played.messages.get(name, 0)
        if count < held:
            raise RunFailed(
                f"{source}: {name}: played {count} messages; required {held}, as many as its "
                "files hold; their order is damaged: gnc audit tells where"
            )


def _report(wish: Playing, playback: Playback, played: Played, domain_id: int) -> None:
    from spacecraft_gnc.signals.graph import CLOCK

    for name in played.overrun:
        print(f"warning: a subscriber of {name} did not keep up", file=sys.stderr)
    count = sum(played.messages.values())
    if wish.as_json:
        answer: dict[str, Any] = {
            "source": wish.source,
            "domain_id": domain_id,
            "duration": playback.duration,
            "position": played.position,
            "wall_time": played.wall_time,
            "messages": played.messages,
            "skipped": playback.left_out,
            "unheard": played.unheard,
            "overrun": played.overrun,
            "rounds": played.rounds,
            "interrupted": played.interrupted,
        }
        print_json(answer)
    elif not wish.quiet:
        ended = f"ended at {played.position:g} s" if played.interrupted else "played to its end"
        ticks = (
            f", {played.messages.get(CLOCK.name, 0)} of them clock ticks made here,"
            if playback.ticks
            else ""
        )
        print(f"{wish.source}: {ended}, {count} messages{ticks} in {played.wall_time:.3g} s")
