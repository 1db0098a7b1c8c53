"""Vehicles, methods and governors by name.

Another package adds its own by an entry point in one of the groups ``spacecraft_gnc.plants``,
``spacecraft_gnc.controllers`` and ``spacecraft_gnc.governors``. The entry point names a class with
a class method ``from_scenario(scenario)`` that returns the core (a `Plant`, `Controller` or
`Governor` of `loop.protocols`). Its own parameters stand in the scenario as ``plugin.<name>``.

The built-in ones are listed here too, so that a plain source tree works, and win over an entry
point of the same name.
"""

from __future__ import annotations

import importlib
from importlib import metadata
from typing import Any, Final, NamedTuple

from spacecraft_gnc import __version__
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop import traits as methods
from spacecraft_gnc.loop.traits import MethodTraits
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, shown, suggestion

_RIGID_BODY: Final = "spacecraft_gnc.vehicles.rigid_body"


class BuiltIn(NamedTuple):
    """A class of this package, imported when it is first needed."""

    target: str
    """``module:class``"""
    traits: MethodTraits = MethodTraits()
    """Of a method; its class says the same."""


BUILT_IN: Final[dict[str, dict[str, BuiltIn]]] = {
    "plants": {"rigid_body": BuiltIn(f"{_RIGID_BODY}.plant:RigidBodyPlant")},
    "controllers": {
        "shooting": BuiltIn(
            f"{_RIGID_BODY}.controllers.solvers:ShootingController",
            methods.SHOOTING,
        ),
        "neighboring_extremal": BuiltIn(
            f"{_RIGID_BODY}.controllers.neighboring:NeighboringExtremalController",
            methods.NEIGHBORING_EXTREMAL,
        ),
        "slsqp": BuiltIn(f"{_RIGID_BODY}.controllers.solvers:SlsqpController", methods.SLSQP),
        "fsolve": BuiltIn(
            f"{_RIGID_BODY}.controllers.solvers:FsolveController",
            methods.FSOLVE,
        ),
        "terminal_set": BuiltIn(
            f"{_RIGID_BODY}.controllers.terminal_set:TerminalSetController",
            methods.TERMINAL_SET,
        ),
        "feedback": BuiltIn(
            f"{_RIGID_BODY}.controllers.feedback:FeedbackController",
            methods.FEEDBACK,
        ),
    },
    "governors": {
        "none": BuiltIn("spacecraft_gnc.governors.pass_through:PassThroughGovernor"),
        "attitude": BuiltIn("spacecraft_gnc.governors.attitude:AttitudeGovernor"),
    },
}
KEYS: Final = {
    "plants": "plant.vehicle",
    "controllers": "nmpc_controller.method",
    "governors": "reference_governor.governor",
}


def names(group: str) -> tuple[str, ...]:
    """Return the names known in ``plants``, ``controllers`` or ``governors``."""
    plugins = (entry.name for entry in metadata.entry_points(group=f"spacecraft_gnc.{group}"))
    return tuple(dict.fromkeys([*BUILT_IN[group], *sorted(plugins)]))


def is_known(group: str, name: str) -> bool:
    """Tell whether ``name`` is known, without importing anything behind it."""
    return name in BUILT_IN[group] or name in names(group)


def provider(group: str, name: str) -> str:
    """Return the distribution behind a name and its version; empty where nothing tells."""
    if name in BUILT_IN[group]:
        return f"spacecraft_gnc {__version__}"
    for entry in metadata.entry_points(group=f"spacecraft_gnc.{group}"):
        if entry.name == name and entry.dist is not None:
            return f"{entry.dist.name} {entry.dist.version}"
    return ""


def traits(method: str) -> MethodTraits:
    """Return the traits of a method; those of one that declares nothing where it is not here."""
    if method in BUILT_IN["controllers"]:
        return BUILT_IN["controllers"][method].traits
    try:
        _, factory = _load("controllers", method, _Problems("", "controllers", method))
    except InvalidScenario:  # whoever builds the method says so
        return MethodTraits()
    declared = getattr(factory, "traits", None)
    return declared if isinstance(declared, MethodTraits) else MethodTraits()


def create(group: str, name: str, scenario: Any) -> Any:
    """Return the core called ``name``, built from ``scenario``.

    Raises
    ------
    InvalidScenario
        If the name is unknown, or the plug-in behind it is broken.
    GncError
        If the core refuses the scenario.
    """
    problem = _Problems(scenario.path, group, name)
    target, build = _factory(group, name, problem)
    try:
        return build(scenario)
    except GncError:
        raise
    except Exception as error:
        if name in BUILT_IN[group]:  # a defect of ours: keep the traceback
            raise
        raise problem.broken(target, f"{type(error).__name__}: {error}") from error


def require_plugin(group: str, name: str, path: str) -> None:
    """Import what is behind the name of a plug-in, as `create` does before it builds the core.

    Raises
    ------
    InvalidScenario
        If the plug-in is broken.
    """
    if name not in BUILT_IN[group]:
        _factory(group, name, _Problems(path, group, name))


def _factory(group: str, name: str, problem: _Problems) -> tuple[str, Any]:
    target, factory = _load(group, name, problem)
    build = getattr(factory, "from_scenario", None)
    if build is None:
        raise problem.broken(target, "no class method from_scenario(scenario)")
    return target, build


class _Problems(NamedTuple):
    """What can be wrong with one name."""

    file: str
    group: str
    name: str

    def unknown(self) -> InvalidScenario:
        known = names(self.group)
        need = f"one of {', '.join(known)}"
        return self._invalid(shown(self.name), need, suggestion(self.name, known))

    def broken(self, target: str, reason: str) -> InvalidScenario:
        reason = " ".join(reason.split())  # one line, whatever the plug-in raised
        received = f"{shown(self.name)}, a plug-in ({target}) that fails with {reason}"
        need = "a class that can be imported and built"
        return self._invalid(received, need, "mend or reinstall its package")

    def _invalid(self, received: str, requirement: str, remedy: str) -> InvalidScenario:
        key = KEYS[self.group]
        return InvalidScenario([Problem(self.file, None, key, received, requirement, remedy)])


def _load(group: str, name: str, problem: _Problems) -> tuple[str, Any]:
    if name in BUILT_IN[group]:
        target = BUILT_IN[group][name].target
        module, _, attribute = target.partition(":")
        return target, getattr(importlib.import_module(module), attribute)
    for entry in metadata.entry_points(group=f"spacecraft_gnc.{group}"):
        if entry.name == name:
            try:
                return entry.value, entry.load()
            except Exception as error:  # a plug-in's import may raise anything
                raise problem.broken(entry.value, f"{type(error).__name__}: {error}") from error
    raise problem.unknown()
