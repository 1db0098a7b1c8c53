"""Controllers and governors killed in lockstep: the flight is that without ROS, bit for bit."""

from __future__ import annotations

import itertools
import os
import random
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from graph.comparison import CASE1, assert_equals_flight, assert_equals_simulation
from graph.killing import (
    PATIENCE,
    kill_controller_between_steps,
    kill_governor_between_steps,
    standing_still,
)
from node_messages import ends
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.progress import Display, Report
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.columns import read_columns
from spacecraft_gnc.scenario import load
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, TARGET, at_rest
from spacecraft_gnc.signals.graph import CONTROLLER, GOVERNOR

pytestmark = pytest.mark.graph
RESTARTS = (
    "plant.command_timeout=120.0",  # a busy machine may take long to start a process
    "launcher.on_node_death=restart",
)
KALABIC = CASE1.with_name("kalabic2014_governor.yaml")
ELSEWHERE = lie.exp(np.array([0.4, 0.0, 0.0]))
"""Target that the governor takes in flight."""


def log_of(out: Path, name: str) -> str:
    return (out / "logs" / f"{name}.log").read_text()


@pytest.mark.parametrize(
    ("scenario", "step", "changes"),
    [
        ("gupta2015_case1", 300, ("plant.duration=800.0",)),
        pytest.param(
            "gupta2015_case1",
            300,
            ("plant.duration=800.0", "nmpc_controller.method=neighboring_extremal"),
            marks=pytest.mark.long,
        ),
        pytest.param("phogat_replanned", 20, (), marks=pytest.mark.long),
    ],
    ids=["shooting", "neighboring_extremal", "planned"],
)
def test_a_restarted_controller_goes_on_where_the_other_ended(
    graph: Any, at: Any, scenario: str, step: int, changes: tuple[str, ...]
) -> None:
    path = CASE1.with_name(f"{scenario}.yaml")
    changes = (*changes, *RESTARTS)
    out = graph.fly(*changes, scenario=path, display=at(step, kill_controller_between_steps))
    assert graph.outcome.restarts == (CONTROLLER,)
    assert "took up the memory of step " in log_of(out, CONTROLLER)
    assert_equals_simulation(out / "bag", *changes, scenario=path)


class Killer(Display):
    """Kills controller and governor in turn, wherever they are just then."""

    def __init__(self, seed: int) -> None:
        self._draw = random.Random(seed)
        self._names = itertools.cycle((CONTROLLER, GOVERNOR))
        self._next = 100
        self.launcher: Launcher | None = None
        self.kills = 0

    def flying(self, report: Report) -> None:
        if report.step < self._next or self.kills == 4 or self.launcher is None:
            return
        self._next = report.step + self._draw.randrange(50, 300)
        self.kills += 1
        os.kill(self.launcher._processes[next(self._names)].pid, signal.SIGKILL)


@pytest.mark.long
def test_nodes_killed_at_any_moment_change_nothing_but_what_they_had_yet_to_tell(
    graph: Any,
) -> None:
    killer, changes = Killer(4), ("plant.duration=400.0", *RESTARTS)
    out = graph.fly(*changes, scenario=KALABIC, display=killer)
    assert graph.outcome.restarts == (CONTROLLER, GOVERNOR) * 2
    flown, simulated = read_flight(out / "bag").trajectory, load(KALABIC, changes).build().run()
    for name in ("attitude", "momentum"):  # in which every torque is
        assert np.array_equal(getattr(flown, name), getattr(simulated, name)), name


class TargetThenKill:
    """Has the governor take a target, and kills it while the graph stands still.

    The graph stands still too until the target has come: else a flight on a busy machine may be
    over before DDS has made the user known.
    """

    def __call__(self, launcher: Launcher) -> None:
        context = rclpy.Context()
        rclpy.init(args=[], context=context, domain_id=launcher._domain_id)
        executor, node = SingleThreadedExecutor(context=context), Node("user", context=context)
        executor.add_node(node)
        heard: list[Any] = []
        kind, name, qos = ends(ACCEPTED_TARGET)
        answers = node.create_subscription(kind, name, heard.append, qos)
        topic = node.create_publisher(*ends(TARGET))

        def spin_until(done: Callable[[], Any], otherwise: str) -> None:
            patience = time.monotonic() + PATIENCE
            while not done():
                assert time.monotonic() < patience, otherwise
                executor.spin_once(timeout_sec=0.05)

        def is_known() -> bool:
            both = topic.get_subscription_count() >= 2  # governor and recorder
            return both and answers.get_publisher_count() > 0

        try:
            with standing_still(launcher, CONTROLLER):
                spin_until(is_known, "the user was never discovered")
                topic.publish(TARGET.encode((0, 0), 0, at_rest(ELSEWHERE)))
                assert topic.wait_for_all_acked(Duration(seconds=PATIENCE)), "the target was lost"
            spin_until(lambda: heard, "the target was never taken")
        finally:
            node.destroy_node()
            executor.shutdown()
            rclpy.shutdown(context=context)
        kill_governor_between_steps(launcher)


class Told:
    """A governor that takes a target at a step."""

    def __init__(self, governor: Any, step: int, target: Any) -> None:
        self._governor, self._step, self._given = governor, step, target

    def __getattr__(self, name: str) -> Any:
        return getattr(self._governor, name)

    def decide(self, state: Any) -> Any:
        if state.step == self._step:
            self._governor.set_target(self._given)
        return self._governor.decide(state)


def test_a_restarted_governor_keeps_reference_and_target(graph: Any, at: Any) -> None:
    changes = ("plant.duration=400.0", *RESTARTS)
    out = graph.fly(*changes, scenario=KALABIC, display=at(60, TargetThenKill()))
    assert graph.outcome.restarts == (GOVERNOR,)
    assert "took up the memory of step " in log_of(out, GOVERNOR)
    with open_bag(out / "bag") as bag:
        (step,) = read_columns(bag, (ACCEPTED_TARGET,))[ACCEPTED_TARGET].steps
    loop = load(KALABIC, changes).build()
    loop.governor = Told(loop.governor, int(step), ELSEWHERE)
    assert_equals_flight(out / "bag", loop.run())
    audit = audit_bag(out / "bag")
    assert audit.passed, audit.first
    notes = {check.name: check.note for check in audit.checks}
    assert notes["decision of the governor"] == "targets taken in flight: 1"


def test_nothing_of_a_memory_is_left(graph: Any) -> None:
    out = graph.fly("plant.duration=4.0", "launcher.on_node_death=restart")
    assert sorted(path.name for path in out.iterdir()) == ["bag", "logs", "scenario.yaml"]
    assert all(path.suffix == ".log" for path in (out / "logs").iterdir())
    assert not graph.launcher._memories._files
