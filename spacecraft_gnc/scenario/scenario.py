"""A checked scenario: typed parameters of every node, and the cores built from them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.traits import MethodTraits
from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, problem_of
from spacecraft_gnc.parameters.yaml_file import PARAMETERS_KEY
from spacecraft_gnc.parameters.yaml_scalar import emit
from spacecraft_gnc.scenario import registry
from spacecraft_gnc.scenario.declare import flatten, known_names, unflatten
from spacecraft_gnc.scenario.schema import (
    ControllerParameters,
    GovernorParameters,
    LauncherParameters,
    PlantParameters,
    RecorderParameters,
)
from spacecraft_gnc.types import Matrix3

if TYPE_CHECKING:  # the cores need numba, a check of a file does not
    from spacecraft_gnc.loop.closed_loop import ClosedLoop
    from spacecraft_gnc.loop.protocols import Controller, Governor, Plant


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Scenario:
    """One scenario, checked; build it with `load` or `from_sections`.

    Attributes
    ----------
    plant, controller, governor, recorder, launcher
        Typed parameters. ``controller.inertia`` and ``controller.time_step`` are filled in from
        the plant where the file leaves them open.
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

    plant: PlantParameters
    controller: ControllerParameters
    governor: GovernorParameters
    recorder: RecorderParameters
    launcher: LauncherParameters
    path: str
    sections: Mapping[str, Mapping[str, Any]]
    values: Mapping[str, Mapping[str, Value]]
    defaults: Mapping[str, Mapping[str, Value]]
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return what would fly, in one line."""
        plant, controller = self.plant, self.controller
        return (
            f"Scenario({self.path!r}: {plant.vehicle}, {controller.method}, horizon "
            f"{controller.horizon}, governor {self.governor.governor}, {self.n_steps} steps of "
            f"{self.period:g} s, {self.n_steps * self.period:g} s in all)"
        )

    @property
    def period(self) -> float:
        """Control period [s]."""
        return self.controller.time_step

    @property
    def substeps(self) -> int:
        """Integrator steps in one control period."""
        return round(self.period / self.plant.time_step)

    @property
    def n_steps(self) -> int:
        """Whole control steps in the duration."""
        period = self.substeps * self.plant.time_step
        return math.floor(self.plant.duration / period * (1.0 + 1e-12))  # 150 / 0.4 is 375

    @property
    def traits(self) -> MethodTraits:
        """What the method declares of itself."""
        return registry.traits(self.controller.method)

    def build(self) -> ClosedLoop:
        """Return the closed loop of this scenario, ready to run.

        Raises
        ------
        GncError
            If a core refuses its parameters, or a plug-in is broken.
        """
        from spacecraft_gnc.loop.closed_loop import ClosedLoop

        return ClosedLoop(self.build_plant(), self.build_controller(), self.build_governor())

    def build_plant(self) -> Plant:
        """Return the vehicle named by ``plant.vehicle``."""
        self._require("plant.inertia", self.plant.inertia)
        return cast("Plant", registry.create("plants", self.plant.vehicle, self))

    def build_controller(self) -> Controller:
        """Return the controller named by ``nmpc_controller.method``.

        Raises
        ------
        InvalidScenario
            With what the controller refuses, such as a start from which it has no solution.
        """
        self._require("nmpc_controller.inertia", self.controller.inertia)
        return cast("Controller", self._create("controllers", self.controller.method))

    def build_governor(self) -> Governor:
        """Return the governor named by ``reference_governor.governor``.

        Raises
        ------
        InvalidScenario
            With what the governor refuses, such as a start from which its prediction violates a
            limit.
        """
        name = self.governor.governor
        if name == "attitude":
            self._require("nmpc_controller.inertia", self.controller.inertia)
        return cast("Governor", self._create("governors", name))

    def check_cores(self) -> None:
        """Have the cores that look ahead refuse what no value shows by itself.

        Raises
        ------
        GncError
            As `build_controller` and `build_governor` do.
        """
        registry.require_plugin("plants", self.plant.vehicle, self.path)
        registry.require_plugin("controllers", self.controller.method, self.path)
        if self.traits.refuses_starts:
            self.build_controller()
        if self.governor.governor != "none":
            self.build_governor()

    def to_yaml(self, defaults: bool = False) -> str:
        """Return a ROS 2 parameter file that loads as this scenario.

        Parameters
        ----------
        defaults : bool
            Whether to write every parameter, or only what was given.
        """
        if not defaults:
            return sections_to_yaml(self.sections)
        return sections_to_yaml({s: unflatten(values) for s, values in self.values.items()})

    def stated_defaults(self) -> str:
        """Return, likewise, the defaults that formulas gave for what was not given."""
        given = {section: flatten(values) for section, values in self.sections.items()}
        taken = {
            section: {n: v for n, v in defaults.items() if not given.get(section, {}).get(n, [])}
            for section, defaults in self.defaults.items()
        }
        told = sections_to_yaml({s: unflatten(values) for s, values in taken.items()})
        return f"# Defaults that formulas gave (docs/scenario.md).\n{told.lstrip()}"

    def _create(self, group: str, name: str) -> Any:
        try:
            return registry.create(group, name, self)
        except InvalidScenario:
            raise
        except GncError as error:
            section = registry.KEYS[group].partition(".")[0]
            problem = problem_of(error, self.path, section, known_names(section))
            if problem is None:
                raise
            raise InvalidScenario([problem]) from error

    def _require(self, key: str, inertia: Matrix3) -> None:
        if np.isnan(inertia).any():
            need = "9 numbers (3x3, row-major) [kg m^2]"
            raise InvalidScenario([Problem(self.path, None, key, "nothing", need, "add it")])


def sections_to_yaml(sections: Mapping[str, Mapping[str, Any]]) -> str:
    """Return nested sections as the text of a ROS 2 parameter file."""
    lines: list[str] = []
    for section, values in sections.items():
        if flatten(values):  # ROS 2 refuses an empty mapping here
            lines += [f"{section}:", f"  {PARAMETERS_KEY}:"]
            _emit_mapping(values, "    ", lines)
    return "\n".join(lines) + "\n"


def _emit_mapping(values: Mapping[str, Any], indent: str, lines: list[str]) -> None:
    for key, value in values.items():
        if not isinstance(value, Mapping):
            lines.append(f"{indent}{key}: {emit(value)}")
        elif value:
            lines.append(f"{indent}{key}:")
            _emit_mapping(value, f"{indent}  ", lines)
