"""When the plant steps: decided from numbers alone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.nodes._pace import Applied, FreeRun, Lockstep

U = np.array([1.0, 0.0, 0.0])


class Vehicle:
    """Remembers what a pace asks of it."""

    def __init__(self, n_steps: int = 1000) -> None:
        self.step = 0
        self.n_steps = n_steps
        self.applied: list[tuple[float, Source]] = []
        self.repeats = 0
        self.events: list[str] = []

    @property
    def finished(self) -> bool:
        return self.step >= self.n_steps

    def begin(self) -> None:
        pass

    def idle(self, agent: str) -> Any:
        return np.zeros(3)

    def advance(self, applied: Mapping[str, Applied]) -> None:
        self.step += 1
        self.applied += [(float(control[0]), source) for control, source in applied.values()]

    def repeat(self) -> None:
        self.repeats += 1

    def event(self, text: str) -> None:
        self.events.append(text)


def test_lockstep_steps_on_its_torque_only() -> None:
    vehicle = Vehicle()
    pace = Lockstep(vehicle, [""], command_timeout=5.0, window=0)
    pace.begin(10.0)
    assert "step 1" in (pace.command("", 1, Applied(U, Source.OPTIMAL), 10.1) or "")
    assert pace.command("", 0, Applied(U, Source.OPTIMAL), 10.2) is None
    assert vehicle.applied == [(1.0, Source.OPTIMAL)]
    assert pace.tally.latency == pytest.approx(0.2)
    assert "step 0" in (pace.command("", 0, Applied(U, Source.OPTIMAL), 10.3) or "")
    assert vehicle.step == 1


def test_lockstep_repeats_after_a_stall_and_gives_up_in_the_end() -> None:
    vehicle = Vehicle()
    pace = Lockstep(vehicle, [""], command_timeout=1.0, window=0)
    pace.begin(0.0)
    for tenths in range(1, 10):
        pace.tick(tenths / 10)
    assert vehicle.repeats == 3
    assert vehicle.applied == []
    pace.tick(1.0)
    assert vehicle.applied == [(0.0, Source.ZERO)]
    assert "no command for step 0" in vehicle.events[0]
    assert (pace.tally.missed, pace.tally.held) == (1, 1)


def test_lockstep_waits_for_the_recorder() -> None:
    vehicle = Vehicle()
    pace = Lockstep(vehicle, [""], command_timeout=5.0, window=10)
    pace.begin(0.0)
    for k in range(11):
        assert pace.command("", k, Applied(U, Source.OPTIMAL), 0.1 * k) is None
    assert vehicle.step == 10
    assert pace.command("", 10, Applied(U, Source.OPTIMAL), 1.2) is not None  # one torque is enough
    pace.recorded(5, 1.3)
    assert vehicle.step == 11


def test_lockstep_forgets_a_recorder_that_is_gone() -> None:
    vehicle = Vehicle()
    pace = Lockstep(vehicle, [""], command_timeout=5.0, window=1)
    pace.begin(0.0)
    pace.command("", 0, Applied(U, Source.OPTIMAL), 0.1)
    pace.command("", 1, Applied(U, Source.OPTIMAL), 0.2)
    pace.tick(5.3)
    assert "recorder" in vehicle.events[0]
    assert vehicle.applied == [(1.0, Source.OPTIMAL)] * 2  # the torque that waited, not zero
    pace.command("", 2, Applied(U, Source.OPTIMAL), 5.4)
    assert vehicle.step == 3


def test_free_run_keeps_its_schedule() -> None:
    vehicle = Vehicle()
    pace = FreeRun(vehicle, [""], wall_period=0.02, max_held_steps=2)
    pace.begin(100.0)
    for k in range(50):
        start = 100.0 + 0.02 * k
        assert pace.command("", k, Applied(U * k, Source.OPTIMAL), start + 0.005) is None
        pace.tick(start + 0.0201)
    assert [u for u, _ in vehicle.applied] == list(range(50))
    assert pace.tally.missed == 0
    assert pace.tally.slack == pytest.approx(0.015)


def test_free_run_holds_then_lets_go() -> None:
    vehicle = Vehicle()
    pace = FreeRun(vehicle, [""], wall_period=1.0, max_held_steps=2)
    pace.begin(0.0)
    pace.command("", 0, Applied(U, Source.OPTIMAL), 0.5)
    for second in range(1, 6):
        pace.tick(float(second))
    held = (1.0, Source.OPTIMAL)
    assert vehicle.applied == [held, held, held, (0.0, Source.ZERO), (0.0, Source.ZERO)]
    assert (pace.tally.missed, pace.tally.held) == (4, 4)
    assert math.isnan(pace.tally.latency)


def test_free_run_catches_up_and_counts_every_miss() -> None:
    vehicle = Vehicle(n_steps=7)
    pace = FreeRun(vehicle, [""], wall_period=1.0, max_held_steps=100)
    pace.begin(0.0)
    pace.tick(5.5)
    assert vehicle.step == 5
    assert pace.tally.missed == 5
    assert (
        pace.command("", 3, Applied(U, Source.OPTIMAL), 5.6) is None
    )  # late: counted already, not applied
    assert pace.command("", 9, Applied(U, Source.OPTIMAL), 5.6) is not None
    pace.tick(100.0)
    assert vehicle.step == 7
    assert vehicle.applied[-1] == (0.0, Source.ZERO)


AGENTS = ("sc1", "sc2")


def test_lockstep_waits_for_every_agent() -> None:
    vehicle = Vehicle()
    pace = Lockstep(vehicle, AGENTS, command_timeout=1.0, window=0)
    pace.begin(0.0)
    assert pace.command("sc2", 0, Applied(2 * U, Source.OPTIMAL), 0.1) is None
    assert "step 0" in (pace.command("sc2", 0, Applied(U, Source.OPTIMAL), 0.15) or "")
    assert vehicle.step == 0
    assert pace.command("sc1", 0, Applied(U, Source.METHOD), 0.2) is None
    assert vehicle.step == 1
    assert sorted(vehicle.applied) == [(1.0, Source.METHOD), (2.0, Source.OPTIMAL)]
    assert pace.tally.latency == pytest.approx(0.2)


def test_lockstep_says_which_agent_is_silent() -> None:
    vehicle = Vehicle()
    pace = Lockstep(vehicle, AGENTS, command_timeout=1.0, window=0)
    pace.begin(0.0)
    pace.command("sc1", 0, Applied(U, Source.OPTIMAL), 0.1)
    pace.tick(1.0)
    assert "no command of sc2 for step 0" in vehicle.events[0]
    assert sorted(vehicle.applied) == [(0.0, Source.ZERO), (1.0, Source.OPTIMAL)]
    assert pace.tally.missed == 1


def test_free_run_counts_a_step_of_a_silent_agent_once() -> None:
    vehicle = Vehicle()
    pace = FreeRun(vehicle, AGENTS, wall_period=1.0, max_held_steps=0)
    pace.begin(0.0)
    pace.command("sc1", 0, Applied(U, Source.OPTIMAL), 0.5)
    pace.tick(1.0)
    assert sorted(vehicle.applied) == [(0.0, Source.ZERO), (1.0, Source.OPTIMAL)]
    assert (pace.tally.missed, pace.tally.held) == (1, 1)
