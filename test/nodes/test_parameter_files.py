"""Every form of a parameter file gives the nodes what `check` and `simulate` read of it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from parameter_forms import FORMS, SCENARIOS, WILDCARD_LAST

from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.launcher import domain, environment
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.plan import make_plan, node_options
from spacecraft_gnc.launcher.progress import Display
from spacecraft_gnc.parameters.checked import plain_values
from spacecraft_gnc.parameters.sections import NODE_NAMES
from spacecraft_gnc.ros.parameters import command_line
from spacecraft_gnc.scenario import load
from spacecraft_gnc.scenario.node_sections import given_to, node_names

PATIENCE = 120.0  # [s] wall
NAMESPACES = ("/", "/sat1", "/a/b")
ASK_NODES = """
import json, sys
import rclpy
from rclpy.node import Node
told = []
for arguments in json.loads(sys.argv[1]):
    rclpy.init(args=arguments)
    try:
        names = json.loads(sys.argv[2])
        nodes = [Node(name, namespace=n, start_parameter_services=False) for n, name in names]
        told.append([{k: p.value for k, p in n._parameter_overrides.items()} for n in nodes])
    finally:
        rclpy.try_shutdown()
print(json.dumps(told, default=list))
"""
CHECK_NODES = """
import json, sys
import rclpy
from spacecraft_gnc.ros.parameters import load_graph
from spacecraft_gnc.nodes.nmpc_controller import ControllerNode
from spacecraft_gnc.nodes.plant import PlantNode
from spacecraft_gnc.nodes.recorder import RecorderNode
from spacecraft_gnc.nodes.reference_governor import GovernorNode
told = []
for sys.argv in json.loads(sys.argv[1]):
    rclpy.init(args=sys.argv)
    try:
        nodes = [PlantNode(), ControllerNode(), GovernorNode(), RecorderNode()]
        told.append([dict(load_graph(node, node.ROLE).leading.values[node.ROLE]) for node in nodes])
    finally:
        rclpy.try_shutdown()
print(json.dumps(told))
"""


def run(*words: str, folder: Path, supervised: bool = True) -> str:
    """Run a Python process on a domain of its own; return what it printed."""
    lock = domain.claim_free({"test": "parameter files"})
    made = environment.for_node(os.environ, lock.domain_id)
    if not supervised:
        del made[environment.SUPERVISED]
    try:
        result = subprocess.run(
            [sys.executable, *words],
            env=made,
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
    finally:
        lock.release()
    assert result.returncode == 0, result.stderr
    return result.stdout


def ask(script: str, *words: Any, folder: Path) -> Any:
    return json.loads(run("-c", script, *map(json.dumps, words), folder=folder).splitlines()[-1])


def command(form: list[str], folder: Path) -> list[str]:
    """Return the command line of a form, its files written."""
    folder.mkdir()
    words = ["node", "--ros-args"]
    for number, text in enumerate(form):
        if text.startswith("-"):
            words += text.split(" ", 1)
        else:
            path = folder / f"{number}.yaml"
            path.write_text(text)
            words += ["--params-file", str(path)]
    return words


def test_live_nodes_are_given_what_is_read(tmp_path: Path) -> None:
    commands = [command(form, tmp_path / str(i)) for i, form in enumerate(FORMS.values())]
    names = [(namespace, name) for namespace in NAMESPACES for name in NODE_NAMES]
    told = ask(ASK_NODES, commands, names, folder=tmp_path)
    assert sum(map(any, told)) == len(FORMS) - 2  # two forms match none of these nodes
    for form, words, by_node in zip(FORMS, commands, told, strict=True):
        sections = command_line(words)
        read = []
        for namespace in NAMESPACES:
            given = plain_values(given_to(sections, node_names(namespace)))
            read += [given.get(name, {}) for name in NODE_NAMES]
        assert read == by_node, form


def written(name: str, folder: Path) -> Path:
    path = folder / f"{name.replace(' ', '_')}.yaml"
    path.write_text(SCENARIOS[name].text)
    return path


def test_nodes_read_what_check_reads(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Started by hand in the namespace that the file is for, and as `gnc launch` starts them."""
    monkeypatch.chdir(tmp_path)
    commands, wanted = [], []
    for name, (_, namespace, horizon) in SCENARIOS.items():
        path = written(name, tmp_path)
        checked = load(path, namespace=namespace).values
        assert checked["nmpc_controller"]["horizon"] == horizon, name
        remap = ["-r", f"__ns:={namespace}"]
        commands.append(["node", "--ros-args", "--params-file", str(path), *remap])
        wanted.append(checked)

        plan = make_plan(path, namespace=namespace)
        options = [word for text in node_options(False, plan.bag) for word in ("-p", text)]
        commands.append(["node", "--ros-args", "--params-file", str(plan.parameter_file), *options])
        flies = plan.scenario.values
        assert flies["nmpc_controller"]["horizon"] == horizon, name
        launched = {role: {**values, "autostart": False} for role, values in flies.items()}
        launched["recorder"]["storage_folder"] = str(plan.bag)
        wanted.append(launched)
    told = ask(CHECK_NODES, commands, folder=tmp_path)
    for words, by_node, values in zip(commands, told, wanted, strict=True):
        assert by_node == [values[role] for role in NODE_NAMES], words


def test_by_hand_and_by_launch_they_fly_what_is_simulated(tmp_path: Path) -> None:
    path = written(WILDCARD_LAST, tmp_path)
    simulated = load(path).build().run()
    Launcher(make_plan(path, out=tmp_path / "run"), Display(), 0.0).run()
    words = ["-m", "spacecraft_gnc.nodes.composed", "--ros-args", "--params-file", str(path)]
    run(*words, folder=tmp_path, supervised=False)
    for bag in (tmp_path / "run" / "bag", tmp_path / "elsewhere"):
        flown = read_flight(bag)
        np.testing.assert_array_equal(flown.trajectory.torque, simulated.torque)
        assert flown.info.scenario is not None
        assert flown.info.scenario.controller.horizon == 9
