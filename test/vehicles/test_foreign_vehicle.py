"""A vehicle of another package: found by its entry point, checked, flown and saved."""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.loop import Command, Source
from spacecraft_gnc.loop.flight import Flight, column, final
from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.formulas import Formula
from spacecraft_gnc.parameters.parameter import Kind, parameter
from spacecraft_gnc.parameters.sections import (
    ControllerHost,
    GovernorHost,
    PlantHost,
    method_named,
)
from spacecraft_gnc.scenario import from_sections, load
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.vehicle import Facts, GovernorLaw, Method, Vehicle

HERE = __name__
FILE = """\
plant:
  ros__parameters:
    vehicle: cart
    initial_position: 1.0
nmpc_controller:
  ros__parameters:
    gain: 1.0
"""


class Motion(NamedTuple):
    step: int
    position: float
    velocity: float


class Decision(NamedTuple):
    reference: float


@dataclass(frozen=True, kw_only=True, eq=False)
class PlantParameters(PlantHost):
    time_step: float = parameter(Kind.DOUBLE, 0.1, "step of the cart", unit="s", above=0.0)
    duration: float = parameter(
        Kind.DOUBLE, 1.0, "time on the rail", unit="s", above=0.0, formula="20 / gain"
    )
    initial_position: float = parameter(Kind.DOUBLE, 0.0, "start of the cart", unit="m")


@dataclass(frozen=True, kw_only=True, eq=False)
class DampedParameters:
    gain: float = parameter(Kind.DOUBLE, 1.0, "gain on the position", unit="1/s^2", above=0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class ControllerParameters(DampedParameters, ControllerHost):
    method: str = method_named("damped")


@dataclass(frozen=True, slots=True, kw_only=True)
class CartFlight(Flight):
    position: Array = column(lambda step: step.state.position, carried_by="cart_state/position")
    force: Array = column(lambda step: step.command.control, carried_by="cart_command/force")
    source: Array = column(lambda step: step.command.source, missing=-1)
    final_position: Array = final(lambda end: end.state.position)


class Cart:
    """A cart of 1 kg on a rail."""

    flight = CartFlight

    def __init__(self, scenario: Any) -> None:
        self.period, self.n_steps = scenario.period, scenario.n_steps
        self._start = Motion(0, scenario.plant.initial_position, 0.0)
        self.reset()

    def step(self, force: float) -> Motion:
        k, position, velocity = self.state
        velocity += self.period * force
        self.state = Motion(k + 1, position + self.period * velocity, velocity)
        return self.state

    def warm_up(self) -> None:
        pass

    def reset(self) -> None:
        self.state = self._start


class Damped:
    """A critically damped law."""

    name = "damped"
    slow = False

    def __init__(self, scenario: Any) -> None:
        self.period, self._gain = scenario.period, scenario.controller.gain

    def command(self, state: Motion, reference: float) -> Command:
        omega = np.sqrt(self._gain)
        off = state.position - reference
        return Command(-(omega**2) * off - 2.0 * omega * state.velocity)

    def warm_up(self) -> None:
        pass

    def reset(self) -> None:
        pass


class Resting:
    """A governor whose target is the origin."""

    name = "none"
    slow = False
    target = 0.0

    def __init__(self, _scenario: Any) -> None:
        pass

    def set_target(self, target: float) -> None:
        self.target = target

    def decide(self, _state: Motion) -> Decision:
        return Decision(self.target)

    def warm_up(self) -> None:
        pass

    def reset(self) -> None:
        pass


def check(checked: Checked) -> None:
    if checked.get("plant", "initial_position") == 0.0:
        checked.complain("plant", "initial_position", "0.0", "a way to go", "start elsewhere")


def formulas(checked: Checked) -> list[Formula]:
    return [Formula("plant", "duration", lambda: 20.0 / checked.number("nmpc_controller", "gain"))]


def facts(scenario: Any, _expected: Any) -> Facts:
    start = f"{scenario.plant.initial_position:g} m off"
    return Facts(body="1 kg", start=start, numbers={"gain": scenario.controller.gain})


def metrics(flight: CartFlight, _scenario: Any) -> dict[str, Any]:
    largest = float(np.abs(flight.force).max())
    return {"steps": flight.n_steps, "period": flight.period, "max_force": largest}


def summary(told: dict[str, Any]) -> list[tuple[str, str]]:
    return [("largest force", f"{told['max_force']:.3g} N")]


CART = Vehicle(
    name="cart",
    description="cart on a rail",
    sections={
        "plant": PlantParameters,
        "nmpc_controller": ControllerParameters,
        "reference_governor": GovernorHost,
    },
    plant=Lazy(f"{HERE}:Cart"),
    methods=(Method(name="damped", build=Lazy(f"{HERE}:Damped"), parameters=DampedParameters),),
    governors=(GovernorLaw(name="none", build=Lazy(f"{HERE}:Resting"), looks_ahead=False),),
    checks=Lazy(f"{HERE}:check"),
    defaults=Lazy(f"{HERE}:formulas"),
    facts=Lazy(f"{HERE}:facts"),
    flight=Lazy(f"{HERE}:CartFlight"),
    metrics=Lazy(f"{HERE}:metrics"),
    summary=Lazy(f"{HERE}:summary"),
)


@pytest.fixture
def file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Return a scenario of the cart, which its entry point announces."""
    installed = metadata.entry_points

    def entry_points(**selection: str) -> Any:
        group = "spacecraft_gnc.vehicles"
        if selection.get("group") != group:
            return installed(**selection)
        return [metadata.EntryPoint("cart", f"{HERE}:CART", group)]

    monkeypatch.setattr(metadata, "entry_points", entry_points)
    path = tmp_path / "cart.yaml"
    path.write_text(FILE, encoding="utf-8")
    return path


def gnc(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    return int(end.value.code or 0), out, err


def test_it_is_checked(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = gnc(capsys, "check", file)
    assert (code, err) == (0, "")
    for line in (
        "vehicle     cart, 1 kg",
        "flight      200 control steps of 0.1 s, 20 s in all, lockstep",
        "start       1 m off",
        "controller  damped",
    ):
        assert line in out
    told = json.loads(gnc(capsys, "check", file, "--json")[1])
    assert (told["vehicle"], told["steps"], told["gain"]) == ("cart", 200, 1.0)
    assert "horizon" not in told


def test_what_it_refuses_is_one_line(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for change, text in (
        ("plant.initial_position=0.0", "required a way to go; start elsewhere"),
        ("nmpc_controller.gain=-1.0", "> 0; raise it"),
        ("nmpc_controller.horizon=5", "received 'cart' beside parameters of vehicle rigid_body"),
        ("nmpc_controller.method=shooting", "required one of damped"),
        ("nmpc_controller.gian=1.0", "did you mean 'gain'?"),
    ):
        code, out, err = gnc(capsys, "check", file, "--set", change)
        assert (code, out) == (2, "")
        (line,) = err.splitlines()
        assert text in line


def test_it_is_flown_and_saved(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = gnc(capsys, "simulate", file, "--out", tmp_path / "cart.npz")
    assert (code, err) == (0, "")
    assert "control steps  200 of 0.1 s" in out
    assert "largest force  1 N" in out
    flight = CartFlight.load(tmp_path / "cart.npz")
    assert (flight.n_steps, flight.period) == (200, 0.1)
    assert set(flight.source) == {Source.METHOD}
    again = load(file).build().run()
    assert np.array_equal(again.position, flight.position)
    assert np.array_equal(again.force, flight.force)
    assert abs(flight.final_position) < 1e-5
    assert Flight.load_scenario(tmp_path / "cart.npz") == FILE


def test_a_part_that_it_does_not_have_is_named_in_one_line(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flown = tmp_path / "cart.npz"
    assert gnc(capsys, "simulate", file, "--out", flown, "--quiet") == (0, "", "")
    code, out, err = gnc(capsys, "report", flown, "-o", tmp_path / "page.html")
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert "vehicle cart" in line
    assert "'report'" in line


def test_its_defaults_follow_from_its_formulas(file: Path) -> None:
    assert load(file, ["nmpc_controller.gain=4.0"]).n_steps == 50
    node = from_sections(
        {"plant": {"vehicle": "cart", "initial_position": 1.0}, "nmpc_controller": {"gain": 2.0}},
        "node",
    )
    assert node.plant.duration == 10.0
    assert "vehicle: cart" in node.to_yaml()
