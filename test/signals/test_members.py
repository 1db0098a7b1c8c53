"""Roles and agents of a graph: who hears whom, and where a topic stands."""

from __future__ import annotations

import pytest

from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, REFERENCE, TARGET
from spacecraft_gnc.signals.graph import CLOCK, CONTROLLER, DIAGNOSTICS, READY
from spacecraft_gnc.signals.members import Members, Place, Seams, foreign, is_recorded_of
from spacecraft_gnc.vehicles.rigid_body.signals import SIGNALS, STATE, TORQUE

ALONE = Members(("plant", "nmpc_controller", "reference_governor", "recorder"))
PAIR = Members(
    ("plant", "recorder", "sc1/nmpc_controller", "sc1/reference_governor", "sc2/nmpc_controller")
)


def test_one_spacecraft_alone() -> None:
    place = ALONE.place("/", CONTROLLER)
    assert place == Place("")
    assert place.node(CONTROLLER) == "/nmpc_controller"
    assert place.topic(STATE) == "/attitude_state"
    assert (ALONE.subscribers(STATE, ""), ALONE.publishers(STATE, "")) == (3, 1)
    assert ALONE.subscribers(CLOCK, "") == 5  # four nodes follow it, and the recorder records it
    assert Members(ALONE.names, ["torque_command"]).subscribers(STATE, "") == 2


def test_a_namespace_moves_the_whole_graph() -> None:
    place = ALONE.place("/fleet/one", CONTROLLER)
    assert place == Place("/fleet/one")
    assert place.node(CONTROLLER) == "/fleet/one/nmpc_controller"
    assert place.topic(STATE) == "/fleet/one/attitude_state"
    assert place.topic(CLOCK) == "/clock"


@pytest.mark.parametrize("root", ["", "/fleet"])
def test_several_spacecraft_in_one_graph(root: str) -> None:
    place = PAIR.place(f"{root}/sc1", CONTROLLER)
    assert place == Place(root, "sc1")
    assert place.node(CONTROLLER) == f"{root}/sc1/nmpc_controller"
    assert place.topic(STATE) == f"{root}/sc1/attitude_state"
    assert place.topic(READY) == f"{root}/graph_ready"
    plant = PAIR.place(root or "/", "plant")
    assert plant == Place(root)
    assert plant.of_space("sc2").topic(TORQUE) == f"{root}/sc2/torque_command"
    assert plant.of_space("sc2").within_graph(TORQUE) == "sc2/torque_command"
    assert (PAIR.subscribers(STATE, "sc1"), PAIR.subscribers(STATE, "sc2")) == (3, 2)
    assert (PAIR.publishers(STATE, "sc1"), PAIR.publishers(REFERENCE, "sc2")) == (1, 0)
    assert PAIR.publishers(READY, "") == 4
    assert PAIR.publishers(DIAGNOSTICS, "") == 5
    assert PAIR.subscribers(CLOCK, "") == 6


def test_a_topic_is_recorded_of_all_agents_or_of_one() -> None:
    assert is_recorded_of(STATE, "sc1", ["attitude_state"])
    assert is_recorded_of(STATE, "sc1", ["/sc1/attitude_state"])
    assert not is_recorded_of(STATE, "sc2", ["sc1/attitude_state"])
    assert is_recorded_of(STATE, "sc2", [])
    known = [("sc1", STATE), ("", CLOCK)]
    assert foreign(known, ["sc1/attitude_state", "clock", "sc2/attitude_state"]) == (
        "sc2/attitude_state",
    )


def test_the_seams_of_a_vehicle_follow_from_who_publishes_to_whom() -> None:
    assert Seams.among(SIGNALS) == Seams(STATE, TORQUE, REFERENCE, TARGET, ACCEPTED_TARGET)
    with pytest.raises(LookupError, match="none from nmpc_controller to plant"):
        Seams.among([STATE, REFERENCE])
    without = Seams.among([STATE, TORQUE, REFERENCE, *graph.SIGNALS])
    assert (without.target, without.accepted) == (None, None)
