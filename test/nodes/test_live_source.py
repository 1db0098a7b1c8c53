"""What somebody who watches a graph is shown, and told, with a wall clock made up by the test."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from live.watching import Wall
from node_messages import encode_reference, encode_state, ends
from rclpy.node import Node
from spacecraft_gnc_msgs.msg import WallTiming

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.live.history import columns
from spacecraft_gnc.analysis.live.picture import Phase
from spacecraft_gnc.loop.protocols import Command, GovernorDecision, Reference, Source, State
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode
from spacecraft_gnc.ros.live_source import LiveSource
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, GOVERNOR_STATUS, REFERENCE
from spacecraft_gnc.signals.graph import WALL_TIMING
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.vehicles.rigid_body.outputs import Outputs
from spacecraft_gnc.vehicles.rigid_body.signals import SOLVER_STATUS, STATE, TORQUE

ZERO = np.zeros(3)
PERIOD_NS = 400_000_000
OUTPUTS = Outputs(
    SimpleNamespace(controller=SimpleNamespace(method="shooting", horizon=5, zones=()))
)


def turn(angle: float) -> np.ndarray:
    return lie.exp(np.array([0.0, 0.0, angle]))


class Stage:
    """A flight whose messages a test makes up, and somebody who watches it."""

    def __init__(self, ros: Any) -> None:
        self.ros, self.wall = ros, Wall()
        self.watcher = ros.add(Node("watcher"))
        self.flyer: Any = None
        self.publish: dict[str, Any] = {}
        view = SimpleNamespace(
            node=self.watcher,
            domain_id=ros.nodes_domain(),
            publishers=self.watcher.get_publishers_info_by_topic,
        )
        self.source = LiveSource(view, clock=self.wall)

    def take_off(self) -> None:
        self.flyer = self.ros.add(Node("flyer"))
        topics = (STATE, REFERENCE, TORQUE, SOLVER_STATUS, GOVERNOR_STATUS, WALL_TIMING)
        for topic in topics:
            publisher = self.flyer.create_publisher(*ends(topic))
            self.publish[topic.name] = publisher.publish
            self.ros.spin_until(lambda p=publisher: p.get_subscription_count() == 1)

    def land(self) -> None:
        self.ros.executor.remove_node(self.flyer)
        self.ros.nodes.remove(self.flyer)
        self.flyer.destroy_node()
        gone = self.watcher.get_publishers_info_by_topic
        self.ros.spin_until(lambda: not gone("/attitude_state"))
        self.wall.now += 1.0

    def fly(self, step: int, *, alpha: float = 1.0) -> None:
        """Publish a step, and let its messages arrive in the order that is worst."""
        stamp = stamp_of(step, PERIOD_NS)
        torque = Command(np.array([0.0, 0.0, 1e-3 * step]), Source.SHIFTED_PLAN, None)
        decision = GovernorDecision(Reference(turn(0.5), ZERO, ZERO), alpha, True, 0.1, "", 1)
        state = State(step, turn(0.1 * step), ZERO)
        self.publish[STATE.name](encode_state(stamp, state, ZERO))
        told = OUTPUTS.controller(state, decision.reference, torque, (2e-3, math.nan))
        for signal, value in (*OUTPUTS.governor(decision), *told):
            if signal.name in self.publish:
                self.publish[signal.name](signal.encode(stamp, step, value))
        timing = WallTiming(step=step, wall_elapsed=0.1 * step, missed_deadlines=3)
        timing.header.stamp.sec, timing.header.stamp.nanosec = stamp
        self.publish[WALL_TIMING.name](timing)
        inboxes = self.source._heard.inboxes
        names = list(self.publish)
        self.ros.spin_until(lambda: all(step in inboxes[name].messages for name in names))


@pytest.fixture
def stage(ros: Any) -> Stage:
    return Stage(ros)


def test_before_the_flight_it_says_what_is_missing(stage: Stage) -> None:
    picture = stage.source.picture()
    assert picture.phase is Phase.WAITING
    assert "nothing received yet from /attitude_state" in picture.note
    assert "no plant is there" in picture.note
    stage.take_off()
    stage.wall.now += 1.0
    assert "a plant is there, but has not begun" in stage.source.picture().note


def test_a_flight_is_shown_with_its_numbers(stage: Stage) -> None:
    stage.take_off()
    for step in range(4):
        stage.fly(step)
    picture = stage.source.picture()
    assert (picture.phase, picture.note, picture.step) == (Phase.FLYING, "", 3)
    assert picture.time == pytest.approx(1.2)
    shown = picture.values
    assert shown["error_deg"] == pytest.approx(math.degrees(0.2))
    assert shown["torque"] == pytest.approx([0.0, 0.0, 3e-3])
    assert shown["source"] == "shifted plan"
    assert (shown["solve"]["status"], shown["solve"]["solve_time"]) == ("no solve", 2e-3)
    assert (picture.timing.missed, picture.timing.speed) == (3, pytest.approx(4.0))
    assert shown["decision"]["margin"] == 0.1


def test_the_history_has_each_step_with_its_own_torque(stage: Stage) -> None:
    stage.take_off()
    for step in range(6):
        stage.fly(step)
        if step % 2:
            stage.source.picture()
    column = {name: i for i, name in enumerate(columns(stage.source.setup))}
    rows = stage.source.history.since(0)
    # The newest step waits: its torque might still be on the way.
    assert [row[column["torque"]][2] for row in rows] == pytest.approx([1e-3 * k for k in range(5)])
    assert [row[column["time"]] for row in rows] == pytest.approx([0.4 * k for k in range(5)])


def test_silence_is_stale_and_then_told(stage: Stage) -> None:
    stage.take_off()
    for step in range(3):
        stage.wall.now += 0.1
        stage.fly(step)
    assert stage.source.picture().phase is Phase.FLYING
    stage.wall.now += 2.5
    picture = stage.source.picture()
    assert picture.phase is Phase.STALE
    assert "no new state for 2 s" in picture.note


def test_a_slow_flight_is_not_stale(stage: Stage) -> None:
    stage.take_off()
    for step in range(3):
        stage.wall.now += 4.0
        stage.fly(step)
    stage.wall.now += 6.0
    assert stage.source.picture().phase is Phase.FLYING


def test_a_flight_that_begins_between_two_looks_is_not_over(stage: Stage) -> None:
    stage.source.picture()  # nobody publishes yet
    stage.wall.now += 0.1
    stage.take_off()
    stage.fly(0)
    stage.fly(1)
    assert stage.source.picture().phase is Phase.FLYING


def test_the_end_is_told_and_the_last_step_is_kept(stage: Stage) -> None:
    stage.take_off()
    for step in range(3):
        stage.fly(step)
    stage.source.picture()
    stage.land()
    picture = stage.source.picture()
    assert (picture.phase, picture.step) == (Phase.OVER, 2)
    assert "the flight is over" in picture.note
    assert len(stage.source.history) == 3


def test_another_flight_begins_with_an_empty_past(stage: Stage) -> None:
    stage.take_off()
    for step in range(5):
        stage.fly(step)
    stage.source.picture()
    generation = stage.source.history.generation
    for step in range(2):
        stage.fly(step)
    assert stage.source.picture().step == 1
    assert stage.source.history.generation != generation
    assert len(stage.source.history) == 1


def test_each_step_has_the_target_that_the_governor_took_last(stage: Stage) -> None:
    stage.take_off()
    publisher = stage.flyer.create_publisher(*ends(ACCEPTED_TARGET))
    stage.fly(0)
    assert stage.source.picture().values["target"] is None
    for step, angle in ((1, 0.5), (3, 0.7)):
        stamp = stamp_of(step, PERIOD_NS)
        reference = Reference(turn(angle), ZERO, ZERO)
        publisher.publish(encode_reference(stamp, step, reference))
    stage.ros.spin_until(lambda: len(stage.source._heard._targets) == 2)
    for step in range(1, 5):
        stage.fly(step)
    assert stage.source.picture().values["target"] == pytest.approx(turn(0.7))
    place = columns(stage.source.setup).index("target_error_deg")
    errors = [row[place] for row in stage.source.history.since(0)]
    away = [math.degrees(abs(angle)) for angle in (0.4, 0.3, 0.4)]
    assert errors[1:] == pytest.approx(away, abs=1e-3)  # of step 0 the scenario's, not known here


def test_a_broken_message_is_no_end(stage: Stage) -> None:
    stage.take_off()
    stage.fly(0)
    data = bytearray(encode_state((1, 0), State(1, turn(0.1), ZERO), ZERO))
    data[60:68] = np.array([math.nan]).tobytes()
    stage.publish[STATE.name](bytes(data))
    stage.ros.spin_until(lambda: stage.source._step == 1)
    picture = stage.source.picture()
    assert "a state was refused" in picture.note
    assert picture.values["attitude"] is None


def test_the_scenario_is_read_from_the_nodes(stage: Stage) -> None:
    for kind in (PlantNode, ControllerNode, GovernorNode):
        node = stage.ros.add(kind())
        assert node.trigger_configure().name == "SUCCESS"

    def known() -> bool:
        stage.wall.now += 0.01
        stage.source.picture()
        return stage.source.setup.period > 0.0

    stage.ros.spin_until(known)
    setup = stage.source.setup
    assert (setup.method, setup.governor, setup.mode) == ("shooting", "none", "lockstep")
    assert (setup.n_steps, setup.period, setup.constants["torque_limit"]) == (375, 0.4, 0.01)
    for node in stage.ros.nodes[1:]:
        node.trigger_shutdown()
