"""Vehicles, methods and governors by name, ours and those of other packages."""

from __future__ import annotations

import importlib
from importlib import metadata
from typing import Any

import pytest

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop import ClosedLoop
from spacecraft_gnc.scenario import InvalidScenario, Scenario, from_sections, registry

INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
HERE = __name__


class Vehicle:
    """A vehicle of another package."""

    def __init__(self, gain: float) -> None:
        self.gain = gain

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> Vehicle:
        gain = scenario.plant.plugin["gain"]
        assert isinstance(gain, float)
        return cls(gain)


class Refusing:
    @classmethod
    def from_scenario(cls, _scenario: Scenario) -> None:
        raise ParameterError("gain: received 2.0; required at most 1.0; lower it")


class Failing:
    @classmethod
    def from_scenario(cls, _scenario: Scenario) -> None:
        raise ZeroDivisionError("by\nzero")


class WithoutFactory:
    pass


@pytest.fixture
def plugins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Entry points of a package that is not there, one good and the others broken."""
    targets = {
        "good": f"{HERE}:Vehicle",
        "refusing": f"{HERE}:Refusing",
        "failing": f"{HERE}:Failing",
        "no_factory": f"{HERE}:WithoutFactory",
        "no_module": "no_such_module_here:Vehicle",
        "no_class": f"{HERE}:NoSuchClass",
        "rigid_body": f"{HERE}:Vehicle",
    }

    installed = metadata.entry_points

    def entry_points(**selection: str) -> Any:
        group = selection.get("group")
        if group != "spacecraft_gnc.plants":
            return installed(**selection)
        return [metadata.EntryPoint(name, target, group) for name, target in targets.items()]

    monkeypatch.setattr(metadata, "entry_points", entry_points)


def scenario(vehicle: str) -> Scenario:
    plant: dict[str, Any] = {"inertia": INERTIA, "vehicle": vehicle, "plugin": {"gain": 2.0}}
    return from_sections({"plant": plant}, "here")


@pytest.mark.usefixtures("plugins")
def test_a_plug_in_is_found_and_built() -> None:
    built = scenario("good").build_plant()
    assert isinstance(built, Vehicle)
    assert built.gain == 2.0


@pytest.mark.usefixtures("plugins")
def test_a_plug_in_is_listed() -> None:
    assert "good" in registry.names("plants")
    with pytest.raises(InvalidScenario, match="did you mean 'good'"):
        scenario("goood")


@pytest.mark.usefixtures("plugins")
def test_a_built_in_name_stays_ours() -> None:
    assert not isinstance(scenario("rigid_body").build_plant(), Vehicle)


@pytest.mark.usefixtures("plugins")
@pytest.mark.parametrize(
    ("vehicle", "reason"),
    [
        ("no_factory", r"no class method from_scenario\(scenario\)"),
        ("no_module", "ModuleNotFoundError: No module named 'no_such_module_here'"),
        ("no_class", "AttributeError: .*NoSuchClass"),
        ("failing", "ZeroDivisionError: by zero"),
    ],
)
def test_a_broken_plug_in_gives_one_line(vehicle: str, reason: str) -> None:
    with pytest.raises(InvalidScenario, match=reason) as error:
        scenario(vehicle).build_plant()
    message = str(error.value)
    assert message.startswith(f"here: plant.vehicle: received '{vehicle}', a plug-in (")
    assert message.endswith("mend or reinstall its package")
    assert "\n" not in message


@pytest.mark.usefixtures("plugins")
def test_what_a_plug_in_refuses_is_passed_on() -> None:
    with pytest.raises(ParameterError, match="required at most"):
        scenario("refusing").build_plant()


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(InvalidScenario, match=r"required one of rigid_body.*'rigid_body'\?"):
        registry.create("plants", "rigid_bod", scenario("rigid_body"))


def test_the_built_in_ones_exist() -> None:
    built = from_sections({"plant": {"inertia": INERTIA}}).build()
    assert isinstance(built, ClosedLoop)
    assert built.controller.name == "shooting"
    assert built.governor.name == "none"


def test_the_variants_are_those_of_the_solver() -> None:
    from spacecraft_gnc.ocp import shooting

    assert registry.traits("shooting").variants == shooting.VARIANTS


@pytest.mark.parametrize("name", registry.BUILT_IN["controllers"])
def test_a_method_declares_the_traits_by_which_it_is_listed(name: str) -> None:
    module, _, attribute = registry.BUILT_IN["controllers"][name].target.partition(":")
    assert getattr(importlib.import_module(module), attribute).traits == registry.traits(name)
