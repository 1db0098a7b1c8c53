"""The rate at which targets are let in."""

from __future__ import annotations

import math
from typing import Any

import pytest
from node_messages import encode_reference, tell
from rclpy.action import GoalResponse

from spacecraft_gnc.loop.protocols import Reference
from spacecraft_gnc.nodes._door import TokenBucket
from spacecraft_gnc.nodes.reference_governor import GovernorNode
from test.nodes.test_slew import ZERO, turn


class Clock:
    """Tells the time that a test sets."""

    time = 5.0

    def __call__(self) -> float:
        return self.time


def taken(bucket: TokenBucket, wanted: int) -> int:
    return sum(bucket.take() for _ in range(wanted))


def test_a_burst_and_then_a_rate() -> None:
    clock = Clock()
    bucket = TokenBucket(20.0, 10, clock)
    assert taken(bucket, 100) == 10
    clock.time += 0.25
    assert taken(bucket, 100) == 5
    clock.time += 0.025  # half a token
    assert taken(bucket, 100) == 0
    clock.time += 0.025
    assert taken(bucket, 100) == 1
    clock.time += 1e6  # it holds no more than a burst
    assert taken(bucket, 100) == 10


@pytest.mark.parametrize("rate", [7.0, 20.0, 900.0])
def test_over_a_long_time_the_rate_is_kept_whatever_the_beat(rate: float) -> None:
    clock = Clock()
    bucket = TokenBucket(rate, 10, clock)
    let_in = 0
    for _ in range(5000):
        clock.time += 0.01
        let_in += taken(bucket, 20)
    assert rate * 50.0 - 1 <= let_in <= rate * 50.0 + 10


def test_targets_that_come_too_often_are_refused(ros: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    governor = ros.add(GovernorNode())
    assert governor.trigger_configure().name == "SUCCESS"
    assert governor.trigger_activate().name == "SUCCESS"
    bucket = TokenBucket(20.0, 10, Clock())
    monkeypatch.setattr(governor._door, "_bucket", bucket)
    tell(governor, "target_attitude", b"garbage")  # takes nothing of what the user may send
    warned: list[str] = []
    monkeypatch.setattr(governor, "diagnose", lambda *told: warned.append(told[1]))
    governor._last_report = -math.inf  # that of the garbage is not what is looked for
    for k in range(15):
        target = Reference(turn(0.1 * k), ZERO, ZERO)
        tell(governor, "target_attitude", encode_reference((0, 0), k, target))
    assert governor.refusals == {"target_attitude/layout": 1, "target_attitude/rate": 5}
    assert warned[0].startswith("target_attitude: received more than 20 targets per second; ")
    assert governor._governor.target[0, 0] == turn(0.9)[0, 0]
    assert governor._slews._admit(None) is GoalResponse.REJECT
    assert governor.refusals["slew_to/rate"] == 1
