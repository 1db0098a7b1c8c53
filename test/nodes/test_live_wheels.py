"""Whoever watches a graph is shown the vehicle whose plant is there."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from live.watching import Wall
from node_messages import ends
from rclpy.node import Node

from spacecraft_gnc.analysis.live.picture import Phase, Picture, Setup
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ros import live_source
from spacecraft_gnc.ros.heard import Heard
from spacecraft_gnc.ros.live_source import LiveSource
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.vehicles.registry import vehicle_of
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Diagnosis, Mode, Rest
from spacecraft_gnc.vehicles.two_wheel.live import LIVE
from spacecraft_gnc.vehicles.two_wheel.signals import DIAGNOSIS, STATE, Accelerations, Motion
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

SPEEDS = np.array([1.0, -2.0, 3.0])


def test_a_plant_with_wheels_is_found_and_shown(ros: Any) -> None:
    wall, watcher = Wall(), ros.add(Node("watcher"))
    view = SimpleNamespace(
        node=watcher,
        domain_id=ros.nodes_domain(),
        publishers=watcher.get_publishers_info_by_topic,
    )
    source = LiveSource(view, clock=wall)
    assert "nothing received yet from /attitude_state" in source.picture().note
    flyer = ros.add(Node("flyer"))
    publisher = flyer.create_publisher(*ends(STATE))
    ros.spin_until(lambda: bool(watcher.get_publishers_info_by_topic("/wheel_state")))
    wall.now += 1.0
    assert "nothing received yet from /wheel_state" in source.picture().note
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    still = np.zeros(3)
    state = WheelState(2, np.eye(3), still, SPEEDS, still, np.ones(3, dtype=bool))
    motion = Motion(state, Accelerations(still, Source.ZERO), 0.0)
    publisher.publish(STATE.encode(stamp_of(2, 10**9), 2, motion))
    ros.spin_until(lambda: source.heard)
    picture = source.picture()
    assert (picture.step, picture.time) == (2, 2.0)
    assert picture.values["wheel_speed"].tolist() == SPEEDS.tolist()
    assert picture.values["wheel_acceleration"] is None
    told = picture.readouts(source.setup)
    assert [line.text for line in told["wheels"]] == ["1 rad/s", "-2 rad/s", "3 rad/s"]


def test_the_diagnosis_of_a_graph_is_shown() -> None:
    room = vehicle_of("two_wheel")
    heard = Heard(room, LIVE)
    diagnosis = Diagnosis(
        np.array([True, True, False]), np.array([0.0, 1e-16, 0.5]), np.full(3, 0.1),
        np.array([np.nan, 1.0, 0.25]), Mode.HOLDING, Rest.NOWHERE, np.array([0.0, 0.0, 2e-3]),
        np.eye(3), 0.1,
    )  # fmt: skip
    heard.put(DIAGNOSIS, 2, DIAGNOSIS.encode(stamp_of(2, 10**9), 2, diagnosis))
    picture = Picture(phase=Phase.FLYING, values=LIVE.values(heard.row(2), LIVE.constants(None)))
    assert picture.as_json()["wheel_response"] == [None, 1.0, 0.25]
    setup = Setup.without_scenario("graph", room, live=True)
    told = {line.label: line.text for line in picture.readouts(setup)["diagnosis"]}
    assert told == {
        "flown": "holding", "excluded": "wheel 3", "residual 3": "0.5 rad/s, bound 0.1",
        "answer 3": "25 % of its command", "rest": "impossible",
        "keeps turning at": "2 mrad/s", "about body axis": "0, 0, 1",
        "axis off the target by": "5.73°",
    }  # fmt: skip


class Graph:
    """A made-up graph of one plant without nodes."""

    def __init__(self, ros: Any, topic: str) -> None:
        self.node, self.domain_id, self.topic = ros.add(Node("watcher")), ros.nodes_domain(), topic

    def publishers(self, name: str) -> list[str]:
        return ["plant"] if name == self.topic else []


def test_a_vehicle_that_cannot_be_watched_is_told_in_one_line(ros: Any, monkeypatch: Any) -> None:
    room = vehicle_of("two_wheel")
    monkeypatch.setattr(live_source, "vehicles_by_state", lambda: {STATE: replace(room, live=None)})
    source = LiveSource(Graph(ros, "/wheel_state"), clock=Wall())
    with pytest.raises(ParameterError, match=r"vehicle two_wheel: received .* 'live'"):
        source.look()


def test_another_vehicle_may_fly_next(ros: Any) -> None:
    graph, wall = Graph(ros, "/wheel_state"), Wall()
    source = LiveSource(graph, clock=wall)
    source.look()
    assert "wheel_speed" in source.setup.history
    graph.topic = "/attitude_state"
    wall.now += 1.0
    source.look()
    assert "momentum" in source.setup.history
