"""A formation watched by the namespace of one of its craft: the flight of all is shown."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from live.watching import Wall
from node_messages import ends
from rclpy.node import Node

from spacecraft_gnc.analysis.live.picture import Phase
from spacecraft_gnc.loop.protocols import Command, Source
from spacecraft_gnc.ros.live_source import LiveSource
from spacecraft_gnc.signals.message import stamp_of
from spacecraft_gnc.vehicles.formation.signals import COMMAND, STATE, Motion
from spacecraft_gnc.vehicles.formation.state import FormationState

NAMES = ("sc1", "sc2", "sc3")
PERIOD_NS = 100_000_000_000
POSITION = np.arange(9.0).reshape(3, 3)


def watch(ros: Any, namespace: str) -> LiveSource:
    watcher = ros.add(Node("watcher"))
    view = SimpleNamespace(
        node=watcher,
        domain_id=ros.nodes_domain(),
        publishers=watcher.get_publishers_info_by_topic,
    )
    return LiveSource(view, namespace, clock=Wall())


def test_a_craft_means_the_flight(ros: Any) -> None:
    source = watch(ros, "sc2")
    flyer = ros.add(Node("flyer"))
    topics = {s.name: s for s in (STATE, *map(COMMAND.of, NAMES))}
    publish = {name: flyer.create_publisher(*ends(signal)) for name, signal in topics.items()}
    ros.spin_until(lambda: source._view.publishers(f"/{STATE}"))
    ros.spin_until(lambda: all(source._view.publishers(f"/{name}") for name in topics))
    source.look()
    ros.spin_until(lambda: all(p.get_subscription_count() == 1 for p in publish.values()))
    assert set(topics) <= set(source._heard.signals)
    state = FormationState(7, POSITION, POSITION, np.array([True, True, False]), POSITION)
    stamp = stamp_of(7, PERIOD_NS)
    publish[STATE.name].publish(STATE.encode(stamp, 7, Motion(state, (Source.METHOD,) * 3)))
    for i, name in enumerate(NAMES):
        command = Command(np.full(3, float(i)), Source.METHOD)
        publish[f"{name}/{COMMAND}"].publish(COMMAND.encode(stamp, 7, command))
    inboxes = source._heard.inboxes
    ros.spin_until(lambda: all(inboxes[name].last for name in topics))
    picture = source.picture()
    assert (picture.phase, picture.step) == (Phase.FLYING, 7)
    row = source._heard.row(7)
    np.testing.assert_array_equal(row["position"], POSITION)
    assert [inboxes[f"{name}/{COMMAND}"].count for name in NAMES] == [1, 1, 1]
