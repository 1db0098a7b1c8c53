"""Whoever watches a graph is shown the vehicle whose plant is there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from live.watching import Wall
from node_messages import ends
from rclpy.node import Node

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ros.live_source import LiveSource
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.vehicles.two_wheel.signals import STATE, Accelerations, Motion
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
    assert picture.strip.tolist() == SPEEDS.tolist()
    assert picture.torque is None
