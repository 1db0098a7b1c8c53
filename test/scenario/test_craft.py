"""A vehicle of several craft in a file: one law for all, whatever section states it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from two_craft import announce

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.launcher import plan
from spacecraft_gnc.parameters.yaml_file import read
from spacecraft_gnc.scenario import InvalidScenario, load, load_fleet, read_sections
from spacecraft_gnc.scenario.agents import agents_in
from spacecraft_gnc.scenario.craft import craft_of
from spacecraft_gnc.scenario.recorded import parse_scenario
from spacecraft_gnc.scenario.schema import ROLES
from spacecraft_gnc.scenario.template import Template

LAW = "{gain: 0.25}"
WAYS = {
    "for every craft": {"/**/nmpc_controller": LAW},
    "for each craft by a wildcard": {"/*/nmpc_controller": LAW},
    "for each craft by its name": {"/port/nmpc_controller": LAW, "/starboard/nmpc_controller": LAW},
    "for the vehicle": {"nmpc_controller": LAW},
    "of one craft, equal to that of all": {
        "/**/nmpc_controller": LAW,
        "/port/nmpc_controller": LAW,
    },
}
NODES = (
    "plant", "port/nmpc_controller", "starboard/nmpc_controller", "reference_governor", "recorder"
)  # fmt: skip


@pytest.fixture(autouse=True)
def _vehicle(monkeypatch: pytest.MonkeyPatch) -> None:
    announce(monkeypatch)


def written(folder: Path, sections: dict[str, str], plant: str = "vehicle: pair") -> Path:
    """Write a file of the pair; the sections of its controllers can be chosen."""
    path = folder / "pair.yaml"
    known = {"plant": f"{{{plant}}}", **sections}
    lines = (f"{name}: {{ros__parameters: {text}}}" for name, text in known.items())
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def run(*words: object) -> int:
    with pytest.raises(SystemExit) as ended:
        main([*map(str, words)])
    return int(ended.value.code or 0)


@pytest.mark.parametrize("sections", WAYS.values(), ids=WAYS)
def test_every_way_to_state_the_law_is_one_scenario(
    sections: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, sections)
    fleet = load_fleet(path)
    assert list(fleet.agents) == [""]
    assert fleet.leading.controller.gain == 0.25
    assert fleet.leading.values == load(path).values == Template(path).scenario().values
    assert fleet.warnings == ()
    assert fleet.nodes == NODES
    assert set(fleet.peers) == set(NODES) - {"plant"}
    assert fleet.craft == {"port": "", "starboard": ""}
    assert read_sections(path)["nmpc_controller"] == {"gain": 0.25}
    assert agents_in(read(path, ROLES)[0]) == ()
    assert plan._is_read_as(fleet, path)
    assert run("check", path) == 0
    assert ", ".join(NODES) in capsys.readouterr().out


@pytest.mark.parametrize("sections", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("name", ["port", "/starboard", "/", ""])
def test_the_namespace_of_a_craft_means_the_flight(
    sections: dict[str, str], name: str, tmp_path: Path
) -> None:
    path = written(tmp_path, sections)
    assert load(path, namespace=name).values == load(path).values
    assert list(load_fleet(path, namespace=name).agents) == [""]


def test_what_is_saved_loads_as_the_same(tmp_path: Path) -> None:
    fleet = load_fleet(written(tmp_path, WAYS["for the vehicle"]))
    for defaults in (False, True):
        again = tmp_path / "again.yaml"
        again.write_text(fleet.to_yaml(defaults), encoding="utf-8")
        assert "/**/nmpc_controller:" in again.read_text()
        assert load_fleet(again).leading.values == fleet.leading.values
    recorded, problem = parse_scenario(fleet.to_yaml(), tmp_path, "", fleet.stated_defaults())
    assert problem == ""
    assert recorded is not None
    assert recorded.values == fleet.leading.values


def test_the_craft_follow_from_the_plant(tmp_path: Path) -> None:
    path = written(tmp_path, {}, "vehicle: pair, spacecraft: [b, a]")
    assert craft_of(load(path)) == ("b", "a")
    assert load_fleet(path).nodes[1:3] == ("b/nmpc_controller", "a/nmpc_controller")
    assert craft_of(load("gupta2015_case1")) == ()


def test_overrides_of_all_craft_and_of_one(tmp_path: Path) -> None:
    path = written(tmp_path, WAYS["for every craft"])
    for words in (
        ["nmpc_controller.gain=0.75"],
        ["/port/nmpc_controller.gain=0.75", "/starboard/nmpc_controller.gain=0.75"],
        ["/port/nmpc_controller.gain=0.75", "nmpc_controller.gain=0.75"],
    ):
        assert load(path, words).controller.gain == 0.75
        assert Template(path).scenario(words).controller.gain == 0.75
    assert load(path, ["/port/nmpc_controller.gain=0.25"]).controller.gain == 0.25
    assert load(written(tmp_path, {}), ["/port/nmpc_controller.gain=0.5"]).controller.gain == 0.5


def test_several_agents_may_be_of_several_craft(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        {
            "/one/plant": "{spacecraft: [a, b]}",
            "/one/a/nmpc_controller": LAW,
            "/one/b/nmpc_controller": LAW,
            "/two/plant": "{spacecraft: [a, c]}",
            "/two/**/nmpc_controller": "{gain: 0.75}",
        },
    )
    fleet = load_fleet(path)
    assert list(fleet.agents) == ["one", "two"]
    assert fleet.craft == {"one/a": "one", "one/b": "one", "two/a": "two", "two/c": "two"}
    assert [one.controller.gain for one in fleet.agents.values()] == [0.25, 0.75]
    assert fleet.warnings == ()
    assert fleet.nodes == (
        "plant", "one/a/nmpc_controller", "one/b/nmpc_controller", "two/a/nmpc_controller",
        "two/c/nmpc_controller", "one/reference_governor", "two/reference_governor", "recorder",
    )  # fmt: skip
    assert load(path, namespace="two/c").controller.gain == 0.75
    again = tmp_path / "again.yaml"
    again.write_text(fleet.to_yaml(), encoding="utf-8")
    assert {name: one.values for name, one in load_fleet(again).agents.items()} == {
        name: one.values for name, one in fleet.agents.items()
    }


BAD: dict[str, tuple[dict[str, str], list[str], str]] = {
    "two laws": (
        {"/port/nmpc_controller": LAW, "/starboard/nmpc_controller": "{gain: 0.5}"}, [],
        "pair.yaml:3: /starboard/nmpc_controller.gain: received 0.5; required 0.25 as of /port,",
    ),
    "one craft alone": (
        {"/**/nmpc_controller": LAW, "/port/nmpc_controller": "{gain: 0.75}"}, [],
        "/starboard/nmpc_controller.gain: received 0.25; required 0.75 as of /port",
    ),
    "the other craft's default": (
        {"/port/nmpc_controller": LAW}, [],
        "/starboard/nmpc_controller.gain: received 0.5; required 0.25 as of /port",
    ),
    "a section of no craft": (
        {"/**/nmpc_controller": LAW, "/sc4/nmpc_controller": LAW}, [],
        "/sc4/nmpc_controller: received a controller of no craft; required one of the craft /port,",
    ),
    "an override of one": (
        WAYS["for every craft"], ["--set", "/starboard/nmpc_controller.gain=0.75"],
        "--set: /starboard/nmpc_controller.gain: received 0.75; required 0.25 as of /port",
    ),
    "an override of no craft": (
        WAYS["for every craft"], ["--set", "/sc4/nmpc_controller.gain=0.25"],
        "--set: /sc4/nmpc_controller: received a controller of no craft; required one of the craft",
    ),
    "an override of a craft's plant": (
        WAYS["for every craft"], ["--set", "/port/plant.duration=2.0"],
        "--set: /port/plant.duration: received 2.0; required NODE.PARAMETER with a node out of",
    ),
    "an unknown namespace": (
        WAYS["for every craft"], ["--namespace", "sc4"],
        "--namespace: received /sc4; required one of the craft /port, /starboard, or / for the",
    ),
    "a node of no craft": (
        WAYS["for every craft"], ["--set", "launcher.nodes=[plant, sc4/nmpc_controller]"],
        "launcher.nodes: received 'sc4/nmpc_controller'; required one of plant, nmpc_controller,",
    ),
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
    assert run(command, written(tmp_path, sections), *words) == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert line in told


def test_an_unknown_vehicle_beside_craft_is_still_named(tmp_path: Path) -> None:
    path = written(tmp_path, WAYS["for each craft by its name"], "vehicle: trio")
    with pytest.raises(InvalidScenario, match="received 'trio'; required one of"):
        load_fleet(path)


def test_the_whole_law_flies_what_its_parts_command(tmp_path: Path) -> None:
    path = written(tmp_path, WAYS["for every craft"])
    flight = load(path, namespace="port").build().run()
    assert flight.n_steps == 5
    np.testing.assert_array_equal(flight.push[0], [[-0.25], [0.5]])
    np.testing.assert_array_equal(flight.position[1], [0.75, -1.5])
