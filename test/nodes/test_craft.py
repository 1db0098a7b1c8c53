"""Nodes of a vehicle of several craft: what the plant gathers, and which controller is whose."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nodes.test_parameter_files import ask
from two_craft import announce

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.nodes._agent import Agent
from spacecraft_gnc.nodes._pace import Applied, FreeRun, Lockstep
from spacecraft_gnc.scenario import from_sections, load
from spacecraft_gnc.scenario.shipped import find

FORMATION = find("afrl_formation_ungoverned")
LOAD = """
import json, sys
import rclpy
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ros.graph_of import members_of
from spacecraft_gnc.ros.parameters import load_graph
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode
told = []
for sys.argv in json.loads(sys.argv[1]):
    rclpy.init(args=sys.argv)
    try:
        for kind in (PlantNode, GovernorNode) if "__ns" not in str(sys.argv) else (ControllerNode,):
            node = kind()
            try:
                fleet = load_graph(node, node.ROLE)
            except GncError as error:
                told.append(str(error))
            else:
                place = members_of(fleet).place(node.get_namespace(), node.ROLE)
                told.append([fleet.leading.values["nmpc_controller"], list(fleet.craft), place])
            node.destroy_node()
    finally:
        rclpy.try_shutdown()
print(json.dumps(told))
"""


class Vehicles:
    """A vehicle of two craft as a pace drives it."""

    def __init__(self, agent: Agent) -> None:
        self.agent, self.step, self.finished = agent, 0, False
        self.events: list[str] = []

    def begin(self) -> None:
        pass

    def idle(self, space: str) -> Any:
        return self.agent.idle(space)

    def advance(self, applied: Any) -> None:
        self.agent.step(applied)
        self.step += 1

    def repeat(self) -> None:
        pass

    def event(self, text: str) -> None:
        self.events.append(text)


@pytest.fixture
def vehicles(monkeypatch: pytest.MonkeyPatch) -> Vehicles:
    announce(monkeypatch)
    scenario = from_sections({"plant": {"vehicle": "pair"}, "nmpc_controller": {"gain": 0.5}})
    return Vehicles(Agent("", scenario, ("port", "starboard")))


def push(value: float) -> Applied:
    return Applied(np.array([value]), Source.METHOD)


def test_a_step_waits_for_all_craft_and_stacks_in_their_order(vehicles: Vehicles) -> None:
    pace = Lockstep(vehicles, vehicles.agent.commanded, 1.0, 0)
    assert pace.command("starboard", 0, push(1.0), 0.1) is None
    assert vehicles.step == 0
    assert pace.command("port", 0, push(-0.5), 0.2) is None
    assert vehicles.step == 1
    np.testing.assert_array_equal(vehicles.agent.applied.control, [[-0.5], [1.0]])
    assert vehicles.agent.applied.source == (Source.METHOD, Source.METHOD)
    np.testing.assert_array_equal(vehicles.agent.core.state.position, [0.5, -1.0])


def test_in_lockstep_a_silent_craft_rests_and_is_named(vehicles: Vehicles) -> None:
    pace = Lockstep(vehicles, vehicles.agent.commanded, 1.0, 0)
    pace.begin(0.0)
    pace.command("port", 0, push(-0.5), 0.1)
    pace.tick(1.5)
    assert vehicles.events == [
        "no command of starboard for step 0 within 1.5 s; idle control applied"
    ]
    np.testing.assert_array_equal(vehicles.agent.applied.control, [[-0.5], [0.0]])
    assert vehicles.agent.applied.source == (Source.METHOD, Source.ZERO)
    assert (pace.tally.missed, pace.tally.held) == (1, 1)


def test_in_free_run_a_late_craft_holds_its_command_and_then_rests(vehicles: Vehicles) -> None:
    pace = FreeRun(vehicles, vehicles.agent.commanded, 1.0, 1)
    pace.begin(0.0)
    pace.command("port", 0, push(-0.5), 0.1)
    pace.command("starboard", 0, push(1.0), 0.2)
    controls = []
    for now in (1.0, 2.0, 3.0):
        pace.tick(now)
        controls.append(vehicles.agent.applied.control.ravel().tolist())
        pace.command("port", vehicles.step, push(-0.5), now + 0.1)
    assert controls == [[-0.5, 1.0], [-0.5, 1.0], [-0.5, 0.0]]
    assert vehicles.agent.applied.source == (Source.METHOD, Source.ZERO)


def written(folder: Path, name: str, *controllers: str) -> Path:
    """Write the shipped formation with other sections of its controllers."""
    path = folder / f"{name}.yaml"
    plant = "plant: {ros__parameters: {vehicle: formation}}"
    path.write_text("\n".join([plant, *controllers]) + "\n", encoding="utf-8")
    return path


def test_every_node_of_a_formation_reads_one_scenario(tmp_path: Path) -> None:
    law = "nmpc_controller: {ros__parameters: {weights: {delta_v: 50.0}}}"
    each = [f"/{name}/{law}" for name in ("sc1", "sc2", "sc3")]
    files = [
        FORMATION,
        written(tmp_path, "all", f"/**/{law}"),
        written(tmp_path, "each", *each),
        written(tmp_path, "whole", law),
    ]
    words = [["node", "--ros-args", "--params-file", str(file)] for file in files]
    commands = [[*w, "-r", f"__ns:=/{name}"] for w in words for name in ("sc1", "sc3")]
    told = ask(LOAD, [*words, *commands], folder=tmp_path)
    wanted = [json.loads(json.dumps(dict(load(file).values["nmpc_controller"]))) for file in files]
    assert [one[0] for one in told[:8]] == [values for values in wanted for _ in range(2)]
    assert [one[0] for one in told[8:]] == [values for values in wanted for _ in range(2)]
    assert all(one[1] == ["sc1", "sc2", "sc3"] for one in told)
    assert [one[2] for one in told[8:]] == [["", "", "sc1"], ["", "", "sc3"]] * 4


REFUSED = "required one of the craft /sc1, /sc2, /sc3; name one of these"


def test_a_controller_of_no_craft_is_refused_in_one_line(tmp_path: Path) -> None:
    file = ["--params-file", str(FORMATION)]
    commands = [["node", "--ros-args", *file, "-r", f"__ns:={n}"] for n in ("/sc4", "/", "/x/sc1")]
    for namespace, told in zip(
        ("/sc4", "/", "/x/sc1"), ask(LOAD, commands, folder=tmp_path), strict=True
    ):
        (line,) = told.splitlines()
        assert f"nmpc_controller: __ns: received {namespace}; {REFUSED}" in line


def test_a_formation_stands_in_any_namespace(tmp_path: Path) -> None:
    path = tmp_path / "anywhere.yaml"
    text = FORMATION.read_text().replace("\nplant:", "\n/**/plant:")
    path.write_text(text, encoding="utf-8")
    commands = [
        ["node", "--ros-args", "--params-file", str(path), "-r", f"__ns:={n}"]
        for n in ("/sc2", "/fleet/sc2")
    ]
    told = ask(LOAD, commands, folder=tmp_path)
    assert [one[2] for one in told] == [["", "", "sc2"], ["/fleet", "", "sc2"]]
