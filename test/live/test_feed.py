"""Every watcher gets every frame and every sample, however late it came."""

from __future__ import annotations

import threading
from itertools import islice

import pytest
from live.watching import PATIENCE, Stage, Wall, recorded

from spacecraft_gnc.analysis.live.feed import PERIOD, Feed
from spacecraft_gnc.analysis.live.history import History
from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup
from spacecraft_gnc.errors import ParameterError


class Live:
    """A flight to which a test adds."""

    transport = None

    def __init__(self):
        self.setup = Setup(title="one", live=True)
        self.history = History()
        self.step = -1

    def picture(self):
        self.step += 1
        self.history.append([self.step])
        return Picture(phase=Phase.FLYING, step=self.step)


def frames(events, count):
    """Return the next ``count`` frames of a watcher, and what came between them."""
    found, other = [], []
    while len(found) < count:
        event = next(events)
        (found if event.name == "frame" else other).append(event)
    return [event.data for event in found], [event.name for event in other]


def test_a_frame_each_tick_ten_times_a_second_of_flight() -> None:
    stage = Stage(rate=4.0)
    stage.wall.now += 0.01  # beyond the rounding of the sums
    events, times = stage.feed.events(), []
    for number in range(1, 31):
        stage.tick()
        (frame,), _ = frames(events, 1)
        assert frame["number"] == number
        times.append(frame["time"])
    assert PERIOD == 0.1
    assert times == pytest.approx([0.4 * k for k in range(30)], abs=1e-6)


def test_a_watcher_gets_every_sample_once() -> None:
    flight = Live()
    feed = Feed(flight)
    early, samples = feed.events(), []
    for _ in range(50):
        feed.tick()
        (frame,), _ = frames(early, 1)
        samples += frame["samples"]
    assert samples == [[k] for k in range(50)]
    (frame,), first = frames(feed.events(), 1)  # a late one
    assert first == ["setup", "history"]
    assert frame["samples"] == samples


def test_a_slow_watcher_misses_frames_but_no_samples() -> None:
    feed = Feed(Live())
    events = feed.events()
    feed.tick()
    frames(events, 1)
    for _ in range(20):
        feed.tick()
    (frame,), _ = frames(events, 1)
    assert frame["number"] == 21
    assert frame["samples"] == [[k] for k in range(1, 21)]


def test_another_flight_is_told_from_its_start() -> None:
    flight = Live()
    feed = Feed(flight)
    events = feed.events()
    feed.tick()
    frames(events, 1)
    flight.setup = Setup(title="two", live=True)
    flight.history.clear()
    feed.tick()
    (frame,), other = frames(events, 1)
    assert other == ["setup", "history"]
    assert frame["samples"] == [[1]]


def test_closing_lets_a_waiting_watcher_go() -> None:
    feed = Feed(Live())
    ended = threading.Event()

    def watch() -> None:
        assert list(feed.events()) == []
        ended.set()

    threading.Thread(target=watch, daemon=True).start()
    feed.close()
    assert ended.wait(PATIENCE)


def test_a_live_flight_takes_no_commands() -> None:
    with pytest.raises(ParameterError, match="the flight is live"):
        Feed(Live()).control("pause", None)


def test_nothing_that_is_not_finite_reaches_the_page() -> None:
    flight = recorded(Wall())
    event = Feed(flight)
    event.tick()
    text = b"".join(e.encode() for e in islice(event.events(), 3)).decode()
    assert "NaN" not in text
    assert "Infinity" not in text


def test_a_recording_begins_when_its_first_watcher_comes() -> None:
    wall = Wall()
    flight = recorded(wall, begun=False)
    feed = Feed(flight)
    feed.tick()
    wall.now += 50.0
    assert (flight.picture().phase, flight.picture().step) == (Phase.PAUSED, 0)
    first = feed.events()
    feed.tick()
    next(first)
    wall.now += 10.1
    assert (flight.picture().phase, flight.picture().step) == (Phase.PLAYING, 25)
    second = feed.events()
    feed.tick()
    next(second)
    assert flight.picture().step == 25
