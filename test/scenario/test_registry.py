"""Vehicles, methods and governors by name, ours and those of other packages."""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib import metadata
from typing import Any

import pytest

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.loop import ClosedLoop
from spacecraft_gnc.parameters.parameter import Kind, names_of, parameter
from spacecraft_gnc.parameters.sections import (
    ControllerHost,
    GovernorHost,
    PlantHost,
    method_named,
)
from spacecraft_gnc.scenario import InvalidScenario, Scenario, from_sections
from spacecraft_gnc.scenario.shipped import shipped
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE as RIGID_BODY
from spacecraft_gnc.vehicles.vehicle import GovernorLaw, Method, Vehicle

INERTIA = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]
HERE = __name__


class Cart:
    """A plant of another package."""

    def __init__(self, gain: float) -> None:
        self.gain = gain

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> Cart:
        gain = scenario.plant.plugin["gain"]
        assert isinstance(gain, float)
        return cls(gain)

    @classmethod
    def refused(cls, _scenario: Scenario) -> None:
        raise ParameterError("gain: received 2.0; required at most 1.0; lower it")

    @classmethod
    def broken(cls, _scenario: Scenario) -> None:
        raise ZeroDivisionError("by\nzero")


@dataclass(frozen=True, kw_only=True, eq=False)
class RailParameters(PlantHost):
    time_step: float = parameter(Kind.DOUBLE, 0.5, "step of the cart", unit="s", above=0.0)
    duration: float = parameter(Kind.DOUBLE, 5.0, "time on the rail", unit="s", above=0.0)
    rail_length: float = parameter(Kind.DOUBLE, 1.0, "length of the rail", unit="m", above=0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class RailControl(ControllerHost):
    method: str = method_named("shooting")


def vehicle(plant: str) -> Vehicle:
    return replace(RIGID_BODY, plant=Lazy(f"{HERE}:{plant}"))


GOOD = vehicle("Cart.from_scenario")
REFUSING = vehicle("Cart.refused")
FAILING = vehicle("Cart.broken")
NO_MODULE_OF_A_PLANT = replace(RIGID_BODY, plant=Lazy("no_such_module_here:Cart"))
RAIL = Vehicle(
    name="rail",
    description="cart on a rail",
    sections={
        "plant": RailParameters,
        "nmpc_controller": RailControl,
        "reference_governor": GovernorHost,
    },
    plant=Lazy(f"{HERE}:Cart.from_scenario"),
    methods=(Method(name="shooting", build=Lazy(f"{HERE}:Cart.from_scenario")),),
    governors=(GovernorLaw(name="none", build=Lazy(f"{HERE}:Cart.from_scenario")),),
)
OF_THE_RAIL = Method(name="", build=Lazy(f"{HERE}:Cart.from_scenario"), vehicle="rail")


class OfTheRail(Cart):
    vehicle = "rail"


class WithoutFactory:
    pass


@pytest.fixture
def plugins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Entry points of a package that is not there, one good and the others broken."""
    groups = {
        "spacecraft_gnc.vehicles": {
            "good": f"{HERE}:GOOD",
            "refusing": f"{HERE}:REFUSING",
            "failing": f"{HERE}:FAILING",
            "no_vehicle": f"{HERE}:WithoutFactory",
            "no_module": "no_such_module_here:Vehicle",
            "no_plant": f"{HERE}:NO_MODULE_OF_A_PLANT",
            "no_name": f"{HERE}:NO_SUCH_NAME",
            "rail": f"{HERE}:RAIL",
            "rigid_body": f"{HERE}:GOOD",
        },
        "spacecraft_gnc.controllers": {
            "on_the_rail": f"{HERE}:OF_THE_RAIL",
            "no_factory": f"{HERE}:WithoutFactory",
        },
        "spacecraft_gnc.governors": {"along": f"{HERE}:OfTheRail"},
    }
    installed = metadata.entry_points

    def entry_points(**selection: str) -> Any:
        group = selection.get("group", "")
        if group not in groups:
            return installed(**selection)
        return [metadata.EntryPoint(name, where, group) for name, where in groups[group].items()]

    monkeypatch.setattr(metadata, "entry_points", entry_points)


def scenario(name: str, **controller: Any) -> Scenario:
    plant: dict[str, Any] = {"inertia": INERTIA, "vehicle": name, "plugin": {"gain": 2.0}}
    return from_sections({"plant": plant, "nmpc_controller": controller}, "here")


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Return the one line with which ``gnc check`` refuses a scenario."""
    options = [part for word in words for part in ("--set", word)]
    with pytest.raises(SystemExit, match="2"):
        main(["check", str(shipped("gupta2015_case1")), *options])
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = err.splitlines()
    return line


@pytest.mark.usefixtures("plugins")
def test_a_plug_in_is_found_and_built() -> None:
    built: Any = scenario("good").build_plant()
    assert isinstance(built, Cart)
    assert built.gain == 2.0
    assert scenario("good").vehicle.name == "good"


@pytest.mark.usefixtures("plugins")
def test_a_vehicle_has_its_own_sections() -> None:
    rail = from_sections({"plant": {"vehicle": "rail", "duration": 7.0}})
    assert (rail.n_steps, rail.period, rail.plant.rail_length) == (14, 0.5, 1.0)
    assert not hasattr(rail.controller, "horizon")
    assert rail.to_yaml() == "plant:\n  ros__parameters:\n    vehicle: rail\n    duration: 7.0\n"
    with pytest.raises(InvalidScenario, match=r"rail_length: received -1\.0; required .* > 0"):
        from_sections({"plant": {"vehicle": "rail", "rail_length": -1.0}})


@pytest.mark.usefixtures("plugins")
def test_a_plug_in_is_listed() -> None:
    assert "good" in registry.names(registry.VEHICLES)
    with pytest.raises(InvalidScenario, match="did you mean 'good'"):
        scenario("goood")


@pytest.mark.usefixtures("plugins")
def test_a_built_in_name_stays_ours() -> None:
    assert not isinstance(scenario("rigid_body").build_plant(), Cart)


@pytest.mark.usefixtures("plugins")
@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("no_vehicle", "fails with a type, which is no spacecraft_gnc.vehicles.vehicle.Vehicle"),
        ("no_module", "ModuleNotFoundError: No module named 'no_such_module_here'"),
        ("no_name", "AttributeError: .*NO_SUCH_NAME"),
        ("no_plant", "ModuleNotFoundError: No module named 'no_such_module_here'"),
        ("failing", "ZeroDivisionError: by zero"),
    ],
)
def test_a_broken_plug_in_gives_one_line(name: str, reason: str) -> None:
    with pytest.raises(InvalidScenario, match=reason) as error:
        scenario(name).build_plant()
    message = str(error.value)
    assert message.startswith(f"here: plant.vehicle: received '{name}', a plug-in (")
    assert message.endswith("mend or reinstall its package")
    assert "\n" not in message


@pytest.mark.usefixtures("plugins")
@pytest.mark.parametrize("name", ["no_vehicle", "no_module", "no_plant"])
def test_a_check_refuses_a_broken_vehicle(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(capsys, f"plant.vehicle={name}")
    assert f"plant.vehicle: received '{name}', a plug-in (" in line


@pytest.mark.usefixtures("plugins")
def test_a_check_refuses_an_unknown_vehicle(capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(capsys, "plant.vehicle=rigid_bod")
    assert (
        "plant.vehicle: received 'rigid_bod'; required one of docking, formation, rigid_body"
        in line
    )
    assert line.endswith("did you mean 'rigid_body'?")


@pytest.mark.usefixtures("plugins")
def test_a_check_refuses_the_sections_of_another_vehicle(
    capsys: pytest.CaptureFixture[str],
) -> None:
    line = refused(capsys, "plant.vehicle=rail")
    assert "plant.vehicle: received 'rail' beside parameters of vehicle" in line
    assert "(plant.inertia, plant.initial_rotation_vector, " in line
    assert line.endswith("remove them")
    line = refused(capsys, "plant.rail_length=2.0")
    assert "received 'rigid_body' beside parameters of vehicle rail (plant.rail_length)" in line
    assert line.endswith("required sections of one vehicle; set vehicle: rail, or remove them")


@pytest.mark.usefixtures("plugins")
def test_a_check_refuses_what_is_for_another_vehicle(capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(capsys, "nmpc_controller.method=on_the_rail")
    assert "nmpc_controller.method: received 'on_the_rail', which is for vehicle rail" in line
    assert "required one for the scenario's vehicle (shooting, neighboring_extremal, " in line
    line = refused(capsys, "reference_governor.governor=along")
    assert "reference_governor.governor: received 'along', which is for vehicle rail" in line


@pytest.mark.usefixtures("plugins")
def test_a_check_refuses_a_method_without_a_factory(capsys: pytest.CaptureFixture[str]) -> None:
    line = refused(capsys, "nmpc_controller.method=no_factory")
    assert "fails with no class method from_scenario(scenario)" in line


@pytest.mark.usefixtures("plugins")
def test_what_a_plug_in_refuses_is_passed_on() -> None:
    with pytest.raises(InvalidScenario, match=r"plant \(gain\): received 2.0; required at most"):
        scenario("refusing").build_plant()


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(InvalidScenario, match=r"required one of .*rigid_body.*'rigid_body'\?"):
        registry.vehicle_of("rigid_bod")


def test_the_built_in_ones_exist() -> None:
    built = from_sections({"plant": {"inertia": INERTIA}}).build()
    assert isinstance(built, ClosedLoop)
    assert built.controller.name == "shooting"
    assert built.governor.name == "none"


def test_the_variants_are_those_of_the_solver() -> None:
    from spacecraft_gnc.ocp import shooting

    method = RIGID_BODY.method("shooting")
    assert method is not None
    assert method.variants == shooting.VARIANTS


@pytest.mark.parametrize("method", RIGID_BODY.methods, ids=lambda method: method.name)
def test_a_method_reads_parameters_of_the_section(method: Method) -> None:
    assert method.reads <= names_of(RIGID_BODY.sections["nmpc_controller"])
    assert callable(method.build.load())


@pytest.mark.parametrize("law", RIGID_BODY.governors, ids=lambda law: law.name)
def test_a_law_reads_parameters_of_the_section(law: GovernorLaw) -> None:
    assert law.reads <= names_of(RIGID_BODY.sections["reference_governor"])
    assert callable(law.build.load())
