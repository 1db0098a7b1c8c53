"""Two spacecraft in one graph: one plant and clock, two controllers, each in its namespace."""

from __future__ import annotations

import contextlib
import json
import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graph.comparison import CASE1, assert_equals_simulation, compared
from graph.test_view import PATIENCE, Watcher, free_domain, gnc

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.launcher.launcher import Launcher
from spacecraft_gnc.launcher.outcome import Interrupted
from spacecraft_gnc.scenario import load_fleet

pytestmark = pytest.mark.graph

TWO = CASE1.parent / "two_spacecraft.yaml"


def kill(name: str) -> Any:
    return lambda launcher: os.kill(launcher._processes[name].pid, signal.SIGKILL)


def same_as_simulated(bag: Path, agent: str, *overrides: str) -> bool:
    simulated = load_fleet(TWO, overrides).agents[agent].build().run()
    flown = read_flight(bag, namespace=agent).trajectory
    pairs = ((getattr(flown, name), getattr(simulated, name)) for name in compared(simulated))
    return all(np.array_equal(ours, theirs, equal_nan=True) for ours, theirs in pairs)


def test_processes_fly_what_is_simulated(graph: Any) -> None:
    changes = ("plant.duration=20.0", "/sc1/nmpc_controller.horizon=8")
    out = graph.fly(*changes, scenario=TWO)
    assert set(graph.exit_codes) == set(load_fleet(TWO).nodes)
    assert set(graph.exit_codes.values()) == {0}
    assert_equals_simulation(out / "bag", *changes, scenario=TWO)
    for agent in ("sc1", "sc2"):
        audit = audit_bag(out, namespace=agent)
        assert audit.passed, audit.first
        assert audit.steps == 50


def test_one_controller_is_restarted_and_the_other_flies_on(graph: Any, at: Any) -> None:
    patient = "plant.command_timeout=120.0"  # a busy machine may take long to start a process
    changes = ("plant.duration=400.0", "launcher.on_node_death=restart", patient)
    display = at(20, kill("sc2/nmpc_controller"))
    out = graph.fly(*changes, scenario=TWO, display=display)
    assert graph.outcome.restarts == ("sc2/nmpc_controller",)
    assert graph.exit_codes == dict.fromkeys(graph.exit_codes, 0)
    assert "flew 1000 steps: 0 deadlines missed" in (out / "logs" / "plant.log").read_text()
    assert same_as_simulated(out / "bag", "sc1", *changes)
    assert len(read_flight(out / "bag", namespace="sc2").trajectory.time) == 1000
    assert audit_bag(out, namespace="sc1").passed


@pytest.mark.long
def test_an_agent_without_a_controller_node_drifts_alone(graph: Any) -> None:
    nodes = "launcher.nodes=[plant, sc1/nmpc_controller, reference_governor, recorder]"
    changes = ("plant.duration=1.2", "plant.command_timeout=0.3", nodes)
    out = graph.fly(*changes, scenario=TWO)
    log = (out / "logs" / "plant.log").read_text()
    assert "no command of sc2 for step 0 within 0.3 s; idle control applied" in log
    assert graph.outcome.missed_deadlines == 3
    assert not read_flight(out / "bag", namespace="sc2").trajectory.torque.any()
    assert same_as_simulated(out / "bag", "sc1", "plant.duration=1.2")
    for agent in ("sc1", "sc2"):
        audit = audit_bag(out, namespace=agent)
        assert audit.passed, audit.first


@pytest.mark.long
def test_in_free_run_each_agent_holds_its_own_command(graph: Any) -> None:
    changes = ("plant.mode=free_run", "plant.real_time_factor=20.0", "plant.duration=40.0")
    out = graph.fly(*changes, scenario=TWO)
    for agent in ("sc1", "sc2"):
        flown = read_flight(out / "bag", namespace=agent).trajectory
        assert len(flown.time) == 100
        assert flown.torque.any()


@pytest.mark.long
@pytest.mark.parametrize(("words", "shown"), [((), "sc1"), (("--namespace", "sc2"), "sc2")])
def test_a_page_shows_one_of_them(graph: Any, words: tuple[str, ...], shown: str) -> None:
    chosen = free_domain()
    with gnc("view", "--domain-id", chosen, "--no-browser", "--json", *words) as view:
        about = json.loads("".join(iter(view.stdout.readline, "}\n")) + "}")
        watcher = Watcher(about["port"])
        watcher.start()
        assert watcher.waiting.wait(PATIENCE)
        graph.fly(
            "plant.mode=free_run",
            "plant.real_time_factor=12",
            "plant.duration=24.0",
            f"launcher.domain_id={chosen}",
            scenario=TWO,
            record=False,
        )
        watcher.join(PATIENCE)
        assert not watcher.is_alive(), watcher.last
        view.send_signal(signal.SIGINT)
        _, err = view.communicate(timeout=PATIENCE)
    assert view.returncode == 0
    assert ("holds several spacecraft (/sc1, /sc2); shows the first" in err) == (not words)
    assert watcher.setup["title"] == f"two_spacecraft /{shown}"
    assert watcher.setup["n_steps"] == 60
    assert watcher.setup["method"] == load_fleet(TWO).agents[shown].controller.method
    assert watcher.last["step"] == 60


def test_one_of_them_is_slewed_and_watched(graph: Any, at: Any) -> None:
    chosen = free_domain()
    told: dict[str, Any] = {}
    turn = ("slew", "--domain-id", chosen, "--axis", "0", "0", "1", "--angle-deg", "15")

    def ask(launcher: Launcher) -> None:
        """Run the commands at once, then end the flight."""
        with contextlib.ExitStack() as stack:
            started = {
                name: stack.enter_context(gnc(*words))
                for name, words in {
                    "unnamed": turn,
                    "named": (*turn, "--namespace", "sc2", "--json"),
                    "watched": ("inspect", "watch", "--once", "--domain-id", chosen),
                }.items()
            }
            for name, command in started.items():
                told[name] = (*command.communicate(timeout=PATIENCE), command.returncode)
        launcher._signal = signal.SIGINT

    with pytest.raises(Interrupted):
        graph.fly(
            "plant.mode=free_run",
            "plant.real_time_factor=10.0",
            "plant.duration=4000.0",
            f"launcher.domain_id={chosen}",
            scenario=TWO,
            record=False,
            display=at(5, ask),
        )
    assert told["unnamed"][2] == 2
    assert "several spacecraft fly (/sc1, /sc2); required the one to slew" in told["unnamed"][1]
    assert json.loads(told["named"][0])["reached"]
    assert "several spacecraft (/sc1, /sc2); shows the first" in told["watched"][1]
    assert told["watched"][2] == 0


@pytest.mark.long
def test_agents_of_different_vehicles(graph: Any, tmp_path: Path) -> None:
    """A rigid body beside a spacecraft with wheels, in one graph and in one bag."""
    wheels = (CASE1.parent / "three_wheel_slew.yaml").read_text(encoding="utf-8")
    for role in ("plant", "nmpc_controller", "reference_governor"):
        wheels = wheels.replace(f"\n{role}:", f"\n/wheels/{role}:")
    body = """
/body/plant:
  ros__parameters:
    inertia: [430.0, 0.0, 0.0, 0.0, 1210.0, 0.0, 0.0, 0.0, 1300.0]
    time_step: 10.0
    duration: 1000.0
    initial_rotation_vector: [0.3, 0.2, -0.4]
/body/nmpc_controller: {ros__parameters: {method: shooting, max_torque: 0.5}}
"""
    path = tmp_path / "mixed.yaml"
    path.write_text(wheels + body, encoding="utf-8")
    out = graph.fly("launcher.composed=true", scenario=path, out=tmp_path / "run")
    agents = load_fleet(path).agents
    assert {name: one.vehicle.name for name, one in agents.items()} == {
        "wheels": "two_wheel", "body": "rigid_body"
    }  # fmt: skip
    for name, one in agents.items():
        audit = audit_bag(out, namespace=name)
        assert audit.passed, audit.first
        flown = read_flight(out / "bag", namespace=name).trajectory
        np.testing.assert_array_equal(flown.attitude, one.build().run().attitude)
