"""Strangers as the graph shows them: by name, by endpoint, without either."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import pytest

from spacecraft_gnc.ros.strangers import Stranger, StrangerWatch, speakers_of
from spacecraft_gnc.scenario import load_fleet
from spacecraft_gnc.scenario.shipped import shipped

TORQUE, CLOCK, SERVICE = "/torque_command", "/clock", "/plant/get_state"
SPEAKERS = {TORQUE: frozenset({"/nmpc_controller"}), CLOCK: frozenset({"/plant"})}


class SeenGraph:
    """What rclpy tells: publishers (node, endpoint) by topic, and servers."""

    def __init__(self) -> None:
        self.publishers: dict[str, list[tuple[str, int]]] = {}
        self.servers = 1

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        return [
            SimpleNamespace(
                node_name=name,
                node_namespace="/",
                topic_type="",
                qos_profile=None,
                endpoint_gid=[number] * 16,
            )
            for name, number in self.publishers.get(topic, ())
        ]

    def count_services(self, _: str) -> int:
        return self.servers


@pytest.fixture
def seen() -> SeenGraph:
    return SeenGraph()


@pytest.fixture
def watch(seen: Any) -> StrangerWatch:
    return StrangerWatch(seen, SPEAKERS, {SERVICE: "/plant"})


def test_the_nodes_of_a_flight_are_no_strangers(seen: SeenGraph, watch: StrangerWatch) -> None:
    watch.look_everywhere()
    seen.publishers = {TORQUE: [("nmpc_controller", 1)], CLOCK: [("plant", 2)]}
    for _ in range(2):
        watch.look_everywhere()
    assert watch.found == ()


def test_every_topic_is_looked_at_in_ten_looks(seen: SeenGraph, watch: StrangerWatch) -> None:
    seen.publishers = {TORQUE: [("a", 1)], CLOCK: [("nmpc_controller", 2)]}
    seen.servers = 2
    for _ in range(10):
        watch.look()
    strangers = {(TORQUE, "/a"), (CLOCK, "/nmpc_controller"), (SERVICE, "")}
    assert set(watch.found) == strangers
    assert len(watch.found) == len(strangers)


def test_one_life_has_one_endpoint(seen: SeenGraph, watch: StrangerWatch) -> None:
    """Also if the first is gone when the second comes."""
    seen.publishers = {TORQUE: [("nmpc_controller", 1)]}
    watch.look_everywhere()
    seen.publishers = {TORQUE: [("nmpc_controller", 2)]}
    watch.admit("/nmpc_controller")
    watch.look_everywhere()
    assert not watch.found
    seen.publishers = {TORQUE: [("nmpc_controller", 3)]}
    watch.look_everywhere()
    assert list(watch.found) == [Stranger(TORQUE, "/nmpc_controller")]


def test_who_has_no_name_gets_time_for_one(
    seen: SeenGraph, watch: StrangerWatch, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    seen.publishers = {TORQUE: [("_NODE_NAME_UNKNOWN_", 1)]}
    for now[0] in (100.0, 104.9):
        watch.look_everywhere()
        assert not watch.found
    now[0] = 105.1
    watch.look_everywhere()
    assert list(watch.found) == [Stranger(TORQUE, "")]


def test_a_node_that_stood_still_is_no_stranger(
    seen: SeenGraph, watch: StrangerWatch, monkeypatch: pytest.MonkeyPatch
) -> None:
    """DDS forgets it after its lease and finds it again; its name may never come back."""
    seen.publishers = {TORQUE: [("nmpc_controller", 1)], CLOCK: [("plant", 2)]}
    watch.look_everywhere()
    seen.publishers = {}
    watch.look_everywhere()
    seen.publishers = {TORQUE: [("_NODE_NAME_UNKNOWN_", 1)], CLOCK: [("_NODE_NAME_UNKNOWN_", 3)]}
    for now in (100.0, 110.0):
        monkeypatch.setattr(time, "monotonic", lambda now=now: now)
        watch.look_everywhere()
    assert list(watch.found) == [Stranger(CLOCK, "")]


@pytest.mark.parametrize(
    ("scenario", "topic", "nodes"),
    [
        ("gupta2015_case1", TORQUE, {"/nmpc_controller"}),
        ("gupta2015_case1", "/attitude_plan", {"/nmpc_controller", "/reference_governor"}),
        ("two_spacecraft", "/sc2/torque_command", {"/sc2/nmpc_controller"}),
        ("two_spacecraft", "/sc1/attitude_state", {"/plant"}),
        ("two_spacecraft", CLOCK, {"/plant"}),
        ("afrl_formation", "/sc3/delta_v_command", {"/sc3/nmpc_controller"}),
        ("afrl_formation", "/sc3/wall_status", {"/sc3/nmpc_controller"}),
        ("two_spacecraft", "/sc1/wall_status", {"/sc1/nmpc_controller"}),
        ("gupta2015_case1", "/wall_status", {"/nmpc_controller"}),
        ("afrl_formation", "/formation_reference", {"/reference_governor"}),
    ],
)
def test_who_may_speak_follows_from_the_signals(scenario: str, topic: str, nodes: set[str]) -> None:
    speakers = speakers_of(load_fleet(shipped(scenario)))
    assert speakers[topic] == nodes
    assert "/diagnostics" not in speakers
    assert not any(name.endswith("/target_attitude") for name in speakers)
    assert all(speakers.values())
