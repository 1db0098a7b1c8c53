"""A method of another package is told by what it declares, and by nothing of ours."""

from __future__ import annotations

import json
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer.testing

from spacecraft_gnc import lie
from spacecraft_gnc.cli.main import app, main
from spacecraft_gnc.loop import Command, Reference, State
from spacecraft_gnc.scenario import Scenario
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE
from spacecraft_gnc.vehicles.vehicle import MethodTraits

CASE = str(shipped("gupta2015_case1"))


class Damped:
    """A PD law that declares nothing."""

    name = "damped"
    slow = False

    def __init__(self, period: float) -> None:
        self.period = period

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> Damped:
        return cls(scenario.period)

    def warm_up(self) -> None:
        pass

    def reset(self) -> None:
        pass

    def command(self, state: State, reference: Reference) -> Command:
        error = lie.log(reference.attitude.T @ state.attitude)
        return Command(np.clip(-0.01 * error - 0.2 * state.momentum, -0.01, 0.01))


class Declaring(Damped):
    """The same, which says what it reads."""

    traits = MethodTraits(
        reads=frozenset({"horizon", "weights.stage_attitude"}), variants=("exact",), memoryless=True
    )


@pytest.fixture(autouse=True)
def _plugins(monkeypatch: pytest.MonkeyPatch) -> None:
    targets = {
        "damped": f"{__name__}:Damped",
        "declaring": f"{__name__}:Declaring",
        "gone": "no_such_module_here:Gone",
    }
    installed = metadata.entry_points

    def entry_points(**selection: str) -> Any:
        group = "spacecraft_gnc.controllers"
        if selection.get("group") != group:
            return installed(**selection)
        return [metadata.EntryPoint(name, target, group) for name, target in targets.items()]

    monkeypatch.setattr(metadata, "entry_points", entry_points)


def gnc(*arguments: str) -> str:
    result = typer.testing.CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.stdout


def fly(method: str, *arguments: str) -> str:
    short = ("--set", f"nmpc_controller.method={method}", "--set", "plant.duration=8.0")
    return gnc("simulate", CASE, *short, *arguments)


def test_a_command_is_the_methods_own_unless_it_says_otherwise() -> None:
    text = fly("damped")
    assert "METHOD 20" in text
    for word in ("fallback", "not solved", "cost", "iterations"):
        assert word not in text
    found = json.loads(fly("damped", "--json"))
    assert (found["sources"], found["fallback_steps"], found["cost"]) == ({"METHOD": 20}, 0, None)


def test_what_a_method_does_not_read_is_not_told_of_it() -> None:
    chosen = ("--set", "nmpc_controller.method=damped")
    assert "controller    damped\n" in gnc("check", CASE, *chosen)
    found = json.loads(gnc("check", CASE, "--json", *chosen))
    assert (found["horizon"], found["variant"]) == (None, None)


def test_what_a_method_declares_is_told() -> None:
    chosen = ("--set", "nmpc_controller.method=declaring")
    assert "controller    declaring (exact), horizon 5 steps\n" in gnc("check", CASE, *chosen)
    assert json.loads(fly("declaring", "--json"))["cost"] > 0.0


def test_a_method_that_is_not_here_declares_nothing() -> None:
    for name in ("gone", "never_heard_of"):
        method = registry.known_method(VEHICLE, name)
        assert (method.name, method.reads, method.variants) == (name, frozenset(), ())
        assert not method.memoryless


def test_a_check_refuses_one_that_cannot_be_imported(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["check", CASE, "--set", "nmpc_controller.method=gone"])
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    assert "a plug-in (no_such_module_here:Gone) that fails with ModuleNotFoundError" in line


def test_a_report_tells_no_horizon_of_it(tmp_path: Path) -> None:
    fly("damped", "--out", str(tmp_path / "flight.npz"))
    page = tmp_path / "page.html"
    gnc("report", str(tmp_path / "flight.npz"), "-o", str(page))
    text = page.read_text(encoding="utf-8")
    assert "<th scope=row>Flown by</th><td>damped</td>" in text
    assert "<th scope=row>Torque from</th><td>method 20</td>" in text
