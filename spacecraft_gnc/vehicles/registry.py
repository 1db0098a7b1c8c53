"""Vehicles, methods and governor laws by name.

Every folder of `vehicles` is a vehicle, whose module ``descriptor`` lists its methods and laws.
Another package adds its own by an entry point in one of three groups:

- ``spacecraft_gnc.vehicles``: a `Vehicle`;
- ``spacecraft_gnc.controllers``: a `Method`, or a class with a class method
  ``from_scenario(scenario)`` that returns the `Controller` and, if it likes, the attribute
  ``traits`` (`MethodTraits`);
- ``spacecraft_gnc.governors``: a `GovernorLaw`, or a class with such a class method.

A class says by its attribute ``vehicle`` which vehicle it is for; by default `DEFAULT_VEHICLE`. Its
parameters stand in the scenario as ``plugin.<name>``. A name of this package wins over an entry
point of the same name.
"""

from __future__ import annotations

import pkgutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields, replace
from functools import cache, lru_cache
from importlib import metadata
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

from spacecraft_gnc import __version__, vehicles
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, shown, suggestion
from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE
from spacecraft_gnc.vehicles.vehicle import GovernorLaw, Method, MethodTraits, Vehicle

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight

VEHICLES: Final = "vehicles"
CONTROLLERS: Final = "controllers"
GOVERNORS: Final = "governors"
KEYS: Final = {
    VEHICLES: "plant.vehicle",
    CONTROLLERS: "nmpc_controller.method",
    GOVERNORS: "reference_governor.governor",
}
_PACKAGE: Final = "spacecraft_gnc"
_Law = TypeVar("_Law", Method, GovernorLaw)
_Search = Callable[..., metadata.EntryPoints]


def own_names(group: str, vehicle: Vehicle | None = None) -> tuple[str, ...]:
    """Return the names of a group that are ours: vehicles, or a vehicle's own methods or laws."""
    if group == VEHICLES:
        return _rooms()
    if vehicle is None:
        return ()
    laws = vehicle.methods if group == CONTROLLERS else vehicle.governors
    return tuple(law.name for law in laws)


@cache
def _rooms() -> tuple[str, ...]:
    """Return the folders that hold a vehicle."""
    rooms = (room.name for room in pkgutil.iter_modules(vehicles.__path__) if room.ispkg)
    return tuple(name for name in rooms if find_spec(_descriptor(name)))


def _descriptor(vehicle: str) -> str:
    return f"{vehicles.__name__}.{vehicle}.descriptor"


def names(group: str, vehicle: Vehicle | None = None) -> tuple[str, ...]:
    """Return the names known in a group, those of other packages included."""
    plugins = sorted(entry.name for entry in _entries(group))
    return tuple(dict.fromkeys([*own_names(group, vehicle), *plugins]))


def is_known(group: str, name: str, vehicle: Vehicle | None = None) -> bool:
    """Tell whether ``name`` is known, without importing anything behind it."""
    return is_built_in(group, name, vehicle) or name in names(group, vehicle)


def is_built_in(group: str, name: str, vehicle: Vehicle | None = None) -> bool:
    """Tell whether ``name`` is a vehicle of this package, or a method or law of its vehicle."""
    return name in own_names(group, vehicle)


def provider(group: str, name: str, vehicle: Vehicle | None = None) -> str:
    """Return the distribution behind a name and its version; empty where nothing tells."""
    if vehicle is not None and group != VEHICLES and is_built_in(group, name, vehicle):
        return provider(VEHICLES, vehicle.name)
    if group == VEHICLES and is_built_in(group, name):
        return f"{_PACKAGE} {__version__}"
    entry = _entry(group, name)
    return "" if entry is None or entry.dist is None else f"{entry.dist.name} {entry.dist.version}"


def vehicle_of(name: str, path: str = "", line: int | None = None) -> Vehicle:
    """Return the vehicle of a name.

    Parameters
    ----------
    name : str
    path, line
        To blame in a problem.

    Raises
    ------
    InvalidScenario
        If the name is unknown, or the plug-in behind it is broken.
    """
    if is_built_in(VEHICLES, name):
        return require_vehicle(Lazy(f"{_descriptor(name)}:VEHICLE").load())
    found: Vehicle = _Problems(path, line, VEHICLES, name, None).loaded(_as_vehicle)
    return found


def flight_of(vehicle: Vehicle | None = None) -> type[Flight]:
    """Return the class of a vehicle's flights; the default vehicle's where it is not known."""
    flight = (vehicle or vehicle_of(DEFAULT_VEHICLE)).flight
    kind: type[Flight] = (flight or Lazy("spacecraft_gnc.loop.flight:Flight")).load()
    return kind


def method_of(vehicle: Vehicle, name: str, path: str = "") -> Method:
    """Return the method of a name, of the vehicle itself or of another package for it.

    Raises
    ------
    InvalidScenario
        If the name is unknown, the plug-in behind it is broken, or is for another vehicle.
    """
    own = vehicle.method(name)
    problem = _Problems(path, None, CONTROLLERS, name, vehicle)
    return own or problem.loaded(lambda entry, found: _as_law(Method, entry, found))


def known_method(vehicle: Vehicle, name: str) -> Method:
    """Return the method of a name; one that declares nothing where it is not here or broken."""
    try:
        return method_of(vehicle, name)
    except InvalidScenario:  # whoever builds the method says so
        return Method(name=name, build=Lazy(""), vehicle=vehicle.name)


def governor_of(vehicle: Vehicle, name: str, path: str = "") -> GovernorLaw:
    """Return the governor law of a name, likewise."""
    own = vehicle.governor(name)
    problem = _Problems(path, None, GOVERNORS, name, vehicle)
    return own or problem.loaded(lambda entry, found: _as_law(GovernorLaw, entry, found))


def create(group: str, build: Lazy, scenario: Any) -> Any:
    """Return the core that a function builds from a scenario.

    Raises
    ------
    InvalidScenario
        If the plug-in that it comes from is broken.
    GncError
        If the core refuses the scenario.
    """
    return _guarded(group, build, scenario, lambda: build.load()(scenario))


def require(group: str, build: Lazy, scenario: Any) -> None:
    """Import what is behind the name of a plug-in, as `create` does before it builds the core.

    Raises
    ------
    InvalidScenario
        If the plug-in is broken.
    """
    if not _is_ours(build):
        _guarded(group, build, scenario, build.load)


def _is_ours(build: Lazy) -> bool:
    return build.target.startswith(f"{_PACKAGE}.")


def _guarded(group: str, build: Lazy, scenario: Any, work: Callable[[], Any]) -> Any:
    try:
        return work()
    except GncError:
        raise
    except Exception as error:
        if _is_ours(build):  # a defect of ours: keep the traceback
            raise
        section, _, key = KEYS[group].partition(".")
        name = scenario.values[section][key]
        problem = _Problems(scenario.path, None, group, name, scenario.vehicle)
        target = build.target.removesuffix(_FACTORY)
        raise problem.broken(target, f"{type(error).__name__}: {error}") from error


_FACTORY: Final = ".from_scenario"


class _Broken(Exception):
    """Why a plug-in is of no use."""


class _Problems(NamedTuple):
    """What can be wrong with one name."""

    file: str
    line: int | None
    group: str
    name: str
    vehicle: Vehicle | None

    def loaded(self, made: Callable[[metadata.EntryPoint, Any], Any]) -> Any:
        """Return what an entry point of that name stands for."""
        entry = _entry(self.group, self.name)
        if entry is None:
            raise self.unknown()
        try:
            found = made(entry, entry.load())
        except _Broken as error:
            raise self.broken(entry.value, str(error)) from error
        except Exception as error:  # a plug-in's import may raise anything
            raise self.broken(entry.value, f"{type(error).__name__}: {error}") from error
        if self.vehicle is not None and found.vehicle != self.vehicle.name:
            raise self.foreign(found.vehicle)
        return found

    def unknown(self) -> InvalidScenario:
        known = names(self.group, self.vehicle)
        need = f"one of {', '.join(known)}"
        return self._invalid(shown(self.name), need, suggestion(self.name, known))

    def broken(self, target: str, reason: str) -> InvalidScenario:
        reason = " ".join(reason.split())  # one line, whatever the plug-in raised
        received = f"{shown(self.name)}, a plug-in ({target}) that fails with {reason}"
        need = "a class that can be imported and built"
        return self._invalid(received, need, "mend or reinstall its package")

    def foreign(self, other: str) -> InvalidScenario:
        known = ", ".join(own_names(self.group, self.vehicle))
        need = f"one for the scenario's vehicle ({known})"
        return self._invalid(f"{shown(self.name)}, which is for vehicle {other}", need, "change it")

    def _invalid(self, received: str, requirement: str, remedy: str) -> InvalidScenario:
        key = KEYS[self.group]
        return InvalidScenario([Problem(self.file, self.line, key, received, requirement, remedy)])


def _entry(group: str, name: str) -> metadata.EntryPoint | None:
    return next((entry for entry in _entries(group) if entry.name == name), None)


def _entries(group: str) -> Iterator[metadata.EntryPoint]:
    """Yield the entry points of other packages; ours are found in our folders."""
    for entry in _installed(metadata.entry_points, f"{_PACKAGE}.{group}", tuple(sys.path)):
        if not entry.value.startswith(f"{_PACKAGE}."):
            yield entry


@lru_cache(maxsize=16)
def _installed(search: _Search, group: str, _path: tuple[str, ...]) -> metadata.EntryPoints:
    """Return the entry points of a group; a new path has them looked for again."""
    return search(group=group)


def require_vehicle(found: Any) -> Vehicle:
    """Return a vehicle; raise for anything else."""
    if not isinstance(found, Vehicle):
        raise _Broken(f"a {type(found).__name__}, which is no {Vehicle.__module__}.Vehicle")
    return found


def _as_vehicle(entry: metadata.EntryPoint, found: Any) -> Vehicle:
    return replace(require_vehicle(found), name=entry.name)


def _as_law(kind: type[_Law], entry: metadata.EntryPoint, found: Any) -> _Law:
    """Return a method or law of another package; a class is one of which less is known."""
    if isinstance(found, kind):
        return replace(found, name=entry.name)
    if not hasattr(found, "from_scenario"):
        raise _Broken("no class method from_scenario(scenario)")
    traits = getattr(found, "traits", None)
    declared = {}
    if kind is Method and isinstance(traits, MethodTraits):
        declared = {field.name: getattr(traits, field.name) for field in fields(MethodTraits)}
    return kind(
        name=entry.name,
        build=Lazy(entry.value + _FACTORY),
        vehicle=getattr(found, "vehicle", DEFAULT_VEHICLE),
        **declared,
    )
