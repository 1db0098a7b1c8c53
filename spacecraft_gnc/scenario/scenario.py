"""A checked scenario: typed parameters of every node, and the cores built from them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, cast

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.declare import Declaration, Schema, flatten, unflatten
from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.parameters.problems import InvalidScenario, problem_of
from spacecraft_gnc.parameters.sections import LauncherParameters, RecorderParameters
from spacecraft_gnc.parameters.yaml_file import PARAMETERS_KEY
from spacecraft_gnc.parameters.yaml_scalar import emit
from spacecraft_gnc.scenario.schema import schema_of
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.vehicle import GovernorLaw, Method, Vehicle

if TYPE_CHECKING:  # the cores need numba, a check of a file does not
    from spacecraft_gnc.loop.closed_loop import ClosedLoop
    from spacecraft_gnc.loop.protocols import Controller, Governor, Plant


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Scenario:
    """One scenario, checked; build it with `load` or `from_sections`.

    Attributes
    ----------
    vehicle : Vehicle
        Named by ``plant.vehicle``.
    plant, controller, governor, recorder, launcher
        Typed parameters, the first three of the vehicle's own classes. What the file leaves open
        for another parameter to say, such as ``controller.time_step``, is filled in.
    path : str
        Where it comes from.
    sections : mapping
        What was given, by section, nested as in the file, with overrides and wildcards merged in.
    values : mapping
        Every parameter by section and dotted name in its ROS 2 form, defaults included.
    defaults : mapping
        The defaults that follow from other values, likewise, also of those that were given.
    warnings : tuple of str
        What to know before it flies, one line each.
    """

    vehicle: Vehicle
    plant: Any
    controller: Any
    governor: Any
    recorder: RecorderParameters
    launcher: LauncherParameters
    path: str
    sections: Mapping[str, Mapping[str, Any]]
    values: Mapping[str, Mapping[str, Value]]
    defaults: Mapping[str, Mapping[str, Value]]
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return what would fly, in one line."""
        reads, parts = self.method.reads, [self.vehicle.name, self.controller.method]
        if "horizon" in reads:
            parts.append(f"horizon {self.controller.horizon}")
        parts.append(f"governor {self.governor.governor}")
        duration = f"{self.n_steps} steps of {self.period:g} s, {self.n_steps * self.period:g} s"
        return f"Scenario({self.path!r}: {', '.join(parts)}, {duration} in all)"

    @property
    def period(self) -> float:
        """Control period [s]."""
        return float(self.controller.time_step)

    @property
    def substeps(self) -> int:
        """Integrator steps in one control period."""
        return round(self.period / float(self.plant.time_step))

    @property
    def n_steps(self) -> int:
        """Whole control steps in the duration."""
        period = self.substeps * float(self.plant.time_step)
        return math.floor(float(self.plant.duration) / period * (1.0 + 1e-12))  # 150 / 0.4 is 375

    @property
    def schema(self) -> Schema:
        """The sections of the vehicle's scenarios."""
        return schema_of(self.vehicle)

    @property
    def method(self) -> Method:
        """The method of the controller, one that declares nothing where it is not here."""
        return registry.known_method(self.vehicle, self.controller.method)

    @property
    def law(self) -> GovernorLaw:
        """The law of the governor.

        Raises
        ------
        InvalidScenario
            If the plug-in behind it is broken.
        """
        return registry.governor_of(self.vehicle, self.governor.governor, self.path)

    def declarations(self, section: str) -> tuple[Declaration, ...]:
        """Return the parameters of a node, in the order of its section class."""
        own = getattr(self, _ATTRIBUTES[section])
        elements = {
            field: [element.name for element in getattr(own, field)]
            for field, _ in self.schema.named_groups(section)
        }
        return self.schema.declarations(section, elements, getattr(own, "plugin", None))

    def named_files(self) -> Iterator[tuple[str, str, str]]:
        """Yield (section, dotted name, path as given) of the files that the scenario names."""
        for section, values in self.values.items():
            for name, value in values.items():
                spec = self.schema.spec_of(section, name, value)
                if value and spec is not None and spec.is_file:
                    yield section, name, str(value)

    def build(self) -> ClosedLoop:
        """Return the closed loop of this scenario, ready to run.

        Raises
        ------
        GncError
            If a core refuses its parameters, or a plug-in is broken.
        """
        from spacecraft_gnc.loop.closed_loop import ClosedLoop

        return ClosedLoop(self.build_plant(), self.build_controller(), self.build_governor())

    def build_plant(self) -> Plant[Any, Any]:
        """Return the vehicle named by ``plant.vehicle``.

        Raises
        ------
        InvalidScenario
            With what the plant refuses, such as a disturbance that is not installed.
        """
        return cast("Plant[Any, Any]", self._create(registry.VEHICLES, self.vehicle.plant))

    def build_controller(self) -> Controller[Any, Any]:
        """Return the controller named by ``nmpc_controller.method``.

        Raises
        ------
        InvalidScenario
            With what the controller refuses, such as a start from which it has no solution.
        """
        method = registry.method_of(self.vehicle, self.controller.method, self.path)
        return cast("Controller[Any, Any]", self._create(registry.CONTROLLERS, method.build))

    def build_governor(self) -> Governor[Any, Any]:
        """Return the governor named by ``reference_governor.governor``.

        Raises
        ------
        InvalidScenario
            With what the governor refuses, such as a start from which its prediction violates a
            limit.
        """
        return cast("Governor[Any, Any]", self._create(registry.GOVERNORS, self.law.build))

    def check_cores(self) -> None:
        """Have the cores that look ahead refuse what no value shows by itself.

        Raises
        ------
        GncError
            As `build_controller` and `build_governor` do.
        """
        registry.require(registry.VEHICLES, self.vehicle.plant, self)
        method = registry.method_of(self.vehicle, self.controller.method, self.path)
        if method.refuses_starts:
            self.build_controller()
        if self.law.looks_ahead:
            self.build_governor()

    def to_yaml(self, defaults: bool = False) -> str:
        """Return a ROS 2 parameter file that loads as this scenario.

        Parameters
        ----------
        defaults : bool
            Whether to write every parameter, or only what was given.
        """
        return sections_to_yaml(self.nested(defaults))

    def nested(self, defaults: bool = False) -> Mapping[str, Mapping[str, Any]]:
        """Return the sections, nested as in a file: what was given, or every parameter."""
        if not defaults:
            return self.sections
        return {s: unflatten(values) for s, values in self.values.items()}

    def stated_defaults(self) -> str:
        """Return, likewise, the defaults that formulas gave for what was not given."""
        return STATED + sections_to_yaml(self.nested_defaults())

    def nested_defaults(self) -> dict[str, Mapping[str, Any]]:
        """Return these defaults by section, nested as in a file."""
        given = {section: flatten(values) for section, values in self.sections.items()}
        taken = {
            section: {n: v for n, v in defaults.items() if not given.get(section, {}).get(n, [])}
            for section, defaults in self.defaults.items()
        }
        return {s: unflatten(values) for s, values in taken.items()}

    def _create(self, group: str, build: Lazy) -> Any:
        try:
            return registry.create(group, build, self)
        except InvalidScenario:
            raise
        except GncError as error:
            section = registry.KEYS[group].partition(".")[0]
            problem = problem_of(error, self.path, section, self.schema.known_names(section))
            if problem is None:
                raise
            raise InvalidScenario([problem]) from error


STATED: Final = "# Defaults that formulas gave (docs/scenario.md).\n"
"""First line of the text of such defaults."""
_ATTRIBUTES: Final = {
    "plant": "plant",
    "nmpc_controller": "controller",
    "reference_governor": "governor",
    "recorder": "recorder",
    "launcher": "launcher",
}


def sections_to_yaml(sections: Mapping[str, Mapping[str, Any]]) -> str:
    """Return nested sections as the text of a ROS 2 parameter file."""
    lines: list[str] = []
    for section, values in sections.items():
        if flatten(values):  # ROS 2 refuses an empty mapping here
            lines += [f"{section}:", f"  {PARAMETERS_KEY}:"]
            _emit_mapping(values, "    ", lines)
    return "".join(f"{line}\n" for line in lines)


def _emit_mapping(values: Mapping[str, Any], indent: str, lines: list[str]) -> None:
    for key, value in values.items():
        if not isinstance(value, Mapping):
            lines.append(f"{indent}{key}: {emit(value)}")
        elif value:
            lines.append(f"{indent}{key}:")
            _emit_mapping(value, f"{indent}  ", lines)
