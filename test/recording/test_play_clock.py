"""Where a player is, at wall times handed in."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spacecraft_gnc.recording.play_clock import PlayClock

times = st.floats(0.0, 1e4)
rates = st.floats(1e-3, 1e3)


@given(times, rates, times, times)
def test_position_advances_by_rate_times_wall_time(start, rate, now, elapsed):
    clock = PlayClock(rate, False, start, now)
    assert clock.position(now + elapsed) == pytest.approx(start + rate * elapsed, rel=1e-6)


@given(times, rates, st.floats(1e-3, 100.0))
def test_after_the_wait_the_due_position_is_reached(start, rate, ahead):
    clock = PlayClock(rate, False, start, 5.0)
    wait = clock.wait(start + ahead, 5.0)
    assert clock.position(5.0 + wait) == pytest.approx(start + ahead)
    assert clock.wait(start + ahead, 5.0 + 2.0 * wait) == 0.0


@given(st.lists(st.tuples(st.sampled_from(["rate", "pause", "go"]), rates), max_size=20))
def test_position_never_jumps_unless_sought(changes):
    clock, now = PlayClock(1.0, False, 0.0, 0.0), 0.0
    for what, value in changes:
        now += 0.25
        before = clock.position(now)
        if what == "rate":
            clock.set_rate(value, now)
        else:
            clock.pause(what == "pause", now)
        assert clock.position(now) == before


def test_paused_it_stands():
    clock = PlayClock(2.0, True, 3.0, 0.0)
    assert clock.position(100.0) == 3.0
    assert clock.wait(4.0, 100.0) == math.inf
    assert clock.wait(3.0, 100.0) == math.inf
    clock.pause(False, 100.0)
    assert clock.wait(4.0, 100.0) == 0.5


def test_unpaced_it_is_where_the_last_message_was():
    clock = PlayClock(0.0, False, 0.0, 0.0)
    assert clock.wait(1e9, 0.0) == 0.0
    clock.passed(7.0)
    assert clock.position(50.0) == 7.0
    clock.set_rate(2.0, 50.0)
    assert clock.position(51.0) == 9.0


def test_a_seek_goes_there():
    clock = PlayClock(2.0, False, 0.0, 0.0)
    clock.seek(40.0, 10.0)
    assert clock.position(11.0) == 42.0
    assert clock.wait(44.0, 11.0) == 1.0
