"""Several agents in one file: what each reads, what they share, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.loop.flight import agents_in
from spacecraft_gnc.scenario import InvalidScenario, from_sections, load, load_fleet, read_sections

TWO = Path(__file__).resolve().parents[2] / "config" / "two_spacecraft.yaml"
BODY = "inertia: [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8], time_step: 0.4"


def written(folder: Path, **sections: str) -> Path:
    """Write a file of two agents of which each section can be replaced, or left out."""
    known = {
        "plant": "duration: 8.0",
        "/sc1/plant": BODY,
        "/sc1/nmpc_controller": "horizon: 6",
        "/sc2/plant": BODY,
        "/sc2/nmpc_controller": "method: feedback",
    }
    known |= {name.replace("__", "/"): text for name, text in sections.items()}
    path = folder / "two.yaml"
    lines = (f"{name}: {{ros__parameters: {{{text}}}}}" for name, text in known.items() if text)
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([*map(str, words)])
    return int(ended.value.code or 0)


def test_each_agent_has_its_sections_and_what_all_share() -> None:
    fleet = load_fleet(TWO)
    assert list(fleet.agents) == ["sc1", "sc2"]
    assert [one.controller.method for one in fleet.agents.values()] == [
        "shooting", "neighboring_extremal"
    ]  # fmt: skip
    assert {one.plant.duration for one in fleet.agents.values()} == {80.0}
    assert fleet.warnings == ()
    assert fleet.nodes == (
        "plant", "sc1/nmpc_controller", "sc2/nmpc_controller", "sc1/reference_governor",
        "sc2/reference_governor", "recorder",
    )  # fmt: skip
    assert set(fleet.peers) == set(fleet.nodes) - {"plant"}


def test_one_is_picked_by_its_namespace() -> None:
    picked = load(TWO, namespace="sc2")
    assert picked.values == load_fleet(TWO).agents["sc2"].values
    assert from_sections(read_sections(TWO, "sc2")).values == picked.values
    with pytest.raises(InvalidScenario, match=r"\(/sc1, /sc2\); required one; name it with"):
        load(TWO)


def test_a_file_of_one_vehicle_is_a_fleet_of_one() -> None:
    fleet = load_fleet("gupta2015_case1")
    assert list(fleet.agents) == [""]
    assert fleet.nodes == fleet.launcher.nodes
    assert fleet.to_yaml() == load("gupta2015_case1").to_yaml()


def test_one_agent_beside_the_plant_of_the_root(tmp_path: Path) -> None:
    path = written(tmp_path, __sc2__plant="", __sc2__nmpc_controller="")
    (agent,) = load_fleet(path).agents
    assert agent == "sc1"


def test_controller_sections_by_wildcard(tmp_path: Path) -> None:
    path = written(tmp_path, __sc1__nmpc_controller="", __sc2__nmpc_controller="")
    path.write_text(path.read_text() + "\n/*/nmpc_controller: {ros__parameters: {horizon: 9}}\n")
    horizons = [one.controller.horizon for one in load_fleet(path).agents.values()]
    assert horizons == [9, 9]


def test_overrides_of_one_and_of_all(tmp_path: Path) -> None:
    words = ["nmpc_controller.horizon=8", "/sc1/nmpc_controller.horizon=9", "plant.duration=4"]
    path = written(tmp_path, __sc2__nmpc_controller="horizon: 5")
    fleet = load_fleet(path, words)
    assert [one.controller.horizon for one in fleet.agents.values()] == [9, 8]
    assert fleet.n_steps == 10
    (one,) = load_fleet(path, words[:2], "sc1").agents.values()
    assert one.controller.horizon == 9


def test_nodes_of_one_agent_only(tmp_path: Path) -> None:
    words = ["launcher.nodes=[plant, nmpc_controller, sc2/reference_governor]"]
    assert load_fleet(written(tmp_path), words).nodes == (
        "plant", "sc1/nmpc_controller", "sc2/nmpc_controller", "sc2/reference_governor"
    )  # fmt: skip


BAD: dict[str, tuple[dict[str, str], list[str], str]] = {
    "no controller": (
        {"__sc2__nmpc_controller": ""}, [],
        "two.yaml: /sc2: received an agent without a controller; required a section /sc2/nmpc_con",
    ),
    "no plant": (
        {"__sc3__nmpc_controller": "horizon: 5"}, [],
        "two.yaml: /sc3: received an agent without a plant; required a section /sc3/plant; add it",
    ),
    "two agents of one name": (
        {"sc1__plant": BODY}, [],
        "sc1/plant: received a second section for sc1/plant; required one section for a node",
    ),
    "no name of ROS": (
        {"__2nd__plant": BODY}, [], "/2nd/plant: received no name of a node; required words of",
    ),
    "periods": (
        {"__sc2__nmpc_controller": "time_step: 0.8"}, [],
        "two.yaml: /sc2/nmpc_controller.time_step: received 0.8 s; required 0.4 s as of /sc1",
    ),
    "durations": (
        {}, ["/sc2/plant.duration=4.0"],
        "/sc2/plant.duration: received 10 control steps; required 20 control steps as of /sc1",
    ),
    "pace": (
        {"__sc2__plant": f"{BODY}, mode: free_run"}, [],
        "/sc2/plant.mode: received 'free_run'; required 'lockstep' as of /sc1",
    ),
    "another vehicle's keys": (
        {"__sc2__plant": f"{BODY}, initial_wheel_speed: [1.0]"}, [],
        "/sc2/plant.",
    ),
    "an unknown vehicle": (
        {"__sc2__plant": f"{BODY}, vehicle: baloon"}, [],
        "/sc2/plant.vehicle: received 'baloon'; required one of",
    ),
    "override of no agent": (
        {}, ["/sc4/nmpc_controller.horizon=8"],
        "--set: /sc4/nmpc_controller.horizon: received 8; required NODE.PARAMETER with a node out",
    ),
    "override of a node that all share": (
        {}, ["/sc1/recorder.compression=none"],
        "--set: /sc1/recorder.compression: received 'none'; required NODE.PARAMETER with a node",
    ),
    "a node of no agent": (
        {}, ["launcher.nodes=[plant, sc4/nmpc_controller]"],
        "launcher.nodes: received 'sc4/nmpc_controller'; required one of plant, nmpc_controller,",
    ),
    "shared by all": ({"plant": "duration: -8.0"}, [], "two.yaml:1: plant.duration: received -8.0"),
}  # fmt: skip


@pytest.mark.parametrize(("sections", "words", "line"), BAD.values(), ids=BAD)
@pytest.mark.parametrize("command", ["check", "simulate"])
def test_bad_input_is_refused_in_one_line(
    sections: dict[str, str],
    words: list[str],
    line: str,
    command: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    options = [part for word in words for part in ("--set", word)]
    assert run(command, written(tmp_path, **sections), *options) == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert line in told


def test_every_agent_is_named_with_its_problems(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, __sc1__plant="time_step: 0.4", __sc2__nmpc_controller="horizon: 0")
    assert run("check", path, "--json") == 2
    problems = json.loads(capsys.readouterr().out)["problems"]
    assert [problem["key"] for problem in problems] == [
        "/sc1/plant.inertia", "/sc2/nmpc_controller.horizon"
    ]  # fmt: skip


def test_check_lists_every_agent(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("check", TWO, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert {name: one["method"] for name, one in told["agents"].items()} == {
        "sc1": "shooting", "sc2": "neighboring_extremal"
    }  # fmt: skip
    assert run("check", TWO) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1] == "/sc1"
    assert "/sc2" in lines


def test_agents_fly_in_one_file_what_each_flies_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "both.npz"
    assert run("simulate", TWO, "--out", out, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert list(told["agents"]) == ["sc1", "sc2"]
    assert agents_in(out) == ("sc1", "sc2")
    with np.load(out) as arrays:
        for agent, one in load_fleet(TWO).agents.items():
            alone = one.build().run()
            assert told["agents"][agent]["steps"] == alone.n_steps
            np.testing.assert_array_equal(arrays[f"{agent}.attitude"], alone.attitude)
            np.testing.assert_array_equal(arrays[f"{agent}.torque"], alone.torque)
            again = type(alone).load(out, agent)
            np.testing.assert_array_equal(again.momentum, alone.momentum)
            np.testing.assert_array_equal(again.time, alone.time)
