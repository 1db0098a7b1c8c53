"""Playing, pausing, seeking: time moves as asked, and never beyond the recording."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from live.watching import Wall

from spacecraft_gnc.analysis.live.transport import FASTEST, Transport
from spacecraft_gnc.errors import ParameterError

START, END = 2.0, 12.0  # [s]


def make(rate=1.0):
    wall = Wall()
    transport = Transport(START, END, rate, wall)
    transport.begin()
    return wall, transport


def test_it_stands_at_its_start_until_somebody_watches() -> None:
    wall = Wall()
    transport = Transport(START, END, 2.0, wall)
    wall.now += 50.0
    assert (transport.time(), transport.paused) == (START, True)
    transport.begin()
    wall.now += 3.0
    assert transport.time() == pytest.approx(START + 6.0)
    transport.pause()
    transport.begin()  # a second watcher
    assert transport.paused


def test_what_was_paused_before_it_began_stays_so() -> None:
    wall = Wall()
    transport = Transport(START, END, 1.0, wall)
    transport.pause()
    transport.begin()
    wall.now += 3.0
    assert (transport.time(), transport.paused) == (START, True)


def test_it_plays_at_its_rate_and_stops_at_the_end() -> None:
    wall, transport = make(rate=2.0)
    assert transport.time() == START
    wall.now += 3.0
    assert transport.time() == pytest.approx(START + 6.0)
    assert not transport.over
    wall.now += 100.0
    assert transport.time() == END
    assert transport.over


def test_a_pause_costs_nothing() -> None:
    wall, transport = make()
    wall.now += 3.0
    transport.pause()
    wall.now += 50.0
    assert transport.time() == pytest.approx(START + 3.0)
    assert transport.paused
    transport.play()
    wall.now += 1.0
    assert transport.time() == pytest.approx(START + 4.0)


@pytest.mark.parametrize("late", [0.0, 5.0])
def test_play_at_the_end_begins_anew(late: float) -> None:
    wall, transport = make()
    wall.now += END - START + late
    jumps = transport.jumps
    transport.play()
    assert transport.time() == START
    assert transport.jumps == jumps + 1


def test_a_seek_keeps_paused_what_is_paused() -> None:
    wall, transport = make()
    transport.pause()
    transport.seek(7.0)
    wall.now += 1.0
    assert transport.time() == 7.0
    assert transport.jumps == 1


def test_a_change_of_rate_does_not_jump() -> None:
    wall, transport = make()
    wall.now += 2.0
    transport.set_rate(3.0)
    assert transport.time() == pytest.approx(START + 2.0)
    wall.now += 1.0
    assert transport.time() == pytest.approx(START + 5.0)


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, math.inf, 2 * FASTEST])
def test_what_is_no_rate_is_refused(rate: float) -> None:
    _, transport = make()
    with pytest.raises(ParameterError, match="rate: received"):
        transport.set_rate(rate)
    assert transport.rate == 1.0


@pytest.mark.parametrize(
    ("action", "value"),
    [("stop", None), ("seek", None), ("rate", None), ("seek", math.nan), ("", 1.0)],
)
def test_what_makes_no_sense_is_refused(action: str, value: float | None) -> None:
    _, transport = make()
    with pytest.raises(ParameterError, match="received"):
        transport.control(action, value)


ACTIONS = st.one_of(
    st.tuples(st.just("play"), st.none()),
    st.tuples(st.just("pause"), st.none()),
    st.tuples(st.just("seek"), st.floats(-50.0, 50.0)),
    st.tuples(st.just("rate"), st.floats(0.01, 100.0)),
)


@given(st.lists(st.tuples(ACTIONS, st.floats(0.0, 20.0)), max_size=20))
def test_time_stays_inside_and_never_runs_backwards_by_itself(steps) -> None:
    wall, transport = make()
    for (action, value), pause in steps:
        transport.control(action, value)
        before = transport.time()
        wall.now += pause
        assert START <= before <= transport.time() <= END
