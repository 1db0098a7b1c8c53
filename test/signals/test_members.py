"""Roles and agents of a graph: who hears whom, and where a topic stands."""

from __future__ import annotations

import pytest

from spacecraft_gnc.signals import graph
from spacecraft_gnc.signals.attitude import ACCEPTED_TARGET, REFERENCE, TARGET
from spacecraft_gnc.signals.graph import CLOCK, CONTROLLER, DIAGNOSTICS, READY, WALL_STATUS
from spacecraft_gnc.signals.members import Members, Place, Seams, foreign, is_recorded_of
from spacecraft_gnc.vehicles.formation.signals import COMMAND
from spacecraft_gnc.vehicles.formation.signals import STATE as HILL_STATE
from spacecraft_gnc.vehicles.rigid_body.signals import SIGNALS, STATE, TORQUE

ALONE = Members(("plant", "nmpc_controller", "reference_governor", "recorder"))
PAIR = Members(
    ("plant", "recorder", "sc1/nmpc_controller", "sc1/reference_governor", "sc2/nmpc_controller")
)

CRAFT = ("a/nmpc_controller", "b/nmpc_controller", "c/nmpc_controller")


def test_one_spacecraft_alone() -> None:
    place = ALONE.place("/", CONTROLLER)
    assert place == Place("")
    assert place.node(CONTROLLER) == "/nmpc_controller"
    assert place.topic(STATE) == "/attitude_state"
    assert (ALONE.subscribers(STATE, ""), ALONE.publishers(STATE, "")) == (3, 1)
    assert ALONE.subscribers(CLOCK, "") == 1  # the recorder; all take the time from states
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
    assert PAIR.subscribers(CLOCK, "") == 1


@pytest.mark.parametrize("root", ["", "/fleet"])
def test_one_flight_of_several_craft(root: str) -> None:
    craft = {"a": "", "b": "", "c": ""}
    members = Members(("plant", *CRAFT, "reference_governor", "recorder"), craft=craft)
    place = members.place(f"{root}/b", CONTROLLER)
    assert place == Place(root, "", "b")
    assert place.node(CONTROLLER) == f"{root}/b/nmpc_controller"
    assert place.topic(HILL_STATE) == f"{root}/hill_state"
    assert place.topic(COMMAND) == f"{root}/b/delta_v_command"
    assert place.topic(WALL_STATUS) == f"{root}/b/wall_status"
    assert place.topic(READY) == f"{root}/graph_ready"
    plant = members.place(root or "/", "plant")
    assert plant == Place(root)
    assert plant.of_space("c").topic(COMMAND) == f"{root}/c/delta_v_command"
    # three controllers, governor and recorder hear the state; a command goes to plant and recorder
    assert (members.subscribers(HILL_STATE, ""), members.publishers(HILL_STATE, "")) == (5, 1)
    assert [members.publishers(COMMAND, name) for name in craft] == [1, 1, 1]
    assert [members.subscribers(COMMAND, name) for name in craft] == [2, 2, 2]
    assert (members.publishers(READY, ""), members.subscribers(CLOCK, "")) == (5, 1)
    without = Members(("plant", *CRAFT[:2]), craft=craft)
    assert [without.publishers(COMMAND, name) for name in craft] == [1, 1, 0]
    assert without.place(f"{root}/c", CONTROLLER) == Place(root, "", "c")


def test_craft_of_one_agent_among_several() -> None:
    craft = {"one/a": "one", "one/b": "one"}
    names = ("plant", "one/a/nmpc_controller", "one/b/nmpc_controller", "one/reference_governor")
    members = Members((*names, "two/nmpc_controller"), craft=craft)
    place = members.place("/one/a", CONTROLLER)
    assert place == Place("", "one", "one/a")
    assert place.topic(HILL_STATE) == "/one/hill_state"
    assert place.topic(COMMAND) == "/one/a/delta_v_command"
    assert (members.subscribers(HILL_STATE, "one"), members.subscribers(HILL_STATE, "two")) == (
        3,
        1,
    )
    assert (members.publishers(COMMAND, "one/a"), members.subscribers(COMMAND, "one/a")) == (1, 1)


def test_the_signal_of_a_craft_is_one_signal() -> None:
    own = COMMAND.of("sc2")
    assert own is COMMAND.of("sc2")
    assert (own.name, own.of_craft, own.type) == ("sc2/delta_v_command", False, COMMAND.type)
    assert is_recorded_of(COMMAND, "sc2", ["delta_v_command"])
    assert is_recorded_of(COMMAND, "sc2", ["/sc2/delta_v_command"])
    assert not is_recorded_of(COMMAND, "sc2", ["sc1/delta_v_command"])


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
