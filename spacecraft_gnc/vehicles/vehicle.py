"""Descriptors of a vehicle, its methods and its governor laws.

A descriptor says everything that the rest of the package has to know, and names what is heavy as
`Lazy`, so that a scenario is checked without a kernel.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import names_of
from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE
from spacecraft_gnc.status import Source

if TYPE_CHECKING:
    from spacecraft_gnc.loop.protocols import Controller

_Number = TypeVar("_Number", np.int64, np.float64)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MethodTraits:
    """What is to be known of a method without building it.

    The controller class of another package declares them as its attribute ``traits``; one that
    declares nothing has those of ``MethodTraits()``.
    """

    reads: frozenset[str] = frozenset()
    """Parameters of ``nmpc_controller`` that it reads beside those that every method reads, such as
    ``horizon`` and ``weights.stage_attitude``; what is not read is neither shown nor priced."""
    variants: tuple[str, ...] = ()
    """Words that ``variant`` may be; empty where the method has no variants."""
    memoryless: bool = False
    """Whether a command without a solve follows from state and reference alone, so that an audit
    may ask for it once more."""
    refuses_starts: bool = False
    """Whether it refuses some starts when it is built."""
    hard_limits: bool = False
    """Whether its limits are constraints of its solve: its cost then leaves the penalties out."""
    former_source: Source | None = None
    """What `Source.METHOD` was called in its flights before that source existed."""

    def current_sources(self, sources: NDArray[_Number]) -> NDArray[_Number]:
        """Return the sources (n,) of a flight as this version numbers them."""
        current = sources.copy()
        if self.former_source is not None:
            current[sources == self.former_source] = Source.METHOD
        return current


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Method(MethodTraits):
    """A method of ``nmpc_controller.method``."""

    name: str
    build: Lazy
    """Function of a scenario that returns the `Controller`."""
    parameters: type | None = None
    """Dataclass of the parameters it reads, part of the vehicle's section; None: not known, as of
    another package's, which may read anything."""
    certifier: Lazy | None = None
    """Certifier of its solves in an audit; None: they cannot be certified."""
    vehicle: str = DEFAULT_VEHICLE
    """Of another package's: the vehicle that it is for."""

    def __post_init__(self) -> None:
        if self.parameters is not None:
            object.__setattr__(self, "reads", names_of(self.parameters))


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class GovernorLaw:
    """A law of ``reference_governor.governor``."""

    name: str
    build: Lazy
    """Function of a scenario that returns the `Governor`."""
    parameters: type | None = None
    """Dataclass of the parameters it reads beside those that every law reads; None: not known."""
    looks_ahead: bool = True
    """Whether it predicts the loop, so that it may refuse a start when it is built."""
    moves: bool = False
    """Whether its reference moves by itself, by the number of the step alone: it is then what the
    governor is asked for, and a governor that starts anew announces no target."""
    vehicle: str = DEFAULT_VEHICLE
    """Of another package's: the vehicle that it is for."""

    @property
    def reads(self) -> frozenset[str]:
        """Parameters of ``reference_governor`` that it reads beside those that every law reads."""
        return frozenset() if self.parameters is None else names_of(self.parameters)


class VehicleScenario(Protocol):
    """What a room reads of a checked scenario (`scenario.Scenario`), beside its typed sections."""

    @property
    def path(self) -> str:
        """Where it comes from."""

    @property
    def method(self) -> Method:
        """Method of the controller."""

    @property
    def period(self) -> float:
        """Control period [s]."""

    @property
    def substeps(self) -> int:
        """Integrator steps in one control period."""

    @property
    def n_steps(self) -> int:
        """Whole control steps in the duration."""

    def build_controller(self) -> Controller[Any, Any]:
        """Return a controller of the scenario."""


class Outlook(NamedTuple):
    """What a scenario that can fly is to expect, foretold without flying it."""

    settling: str = "not predicted"
    """In words."""
    numbers: Mapping[str, Any] = MappingProxyType({})
    """For JSON; None for what is not predicted, or never."""
    warnings: tuple[str, ...] = ()


class Facts(NamedTuple):
    """What ``gnc check`` says of a scenario beside what it says of every vehicle's."""

    body: str = ""
    """Of the vehicle, after its name."""
    start: str = ""
    controller: str = ""
    """Of the method, after its name and variant."""
    rows: tuple[tuple[str, str], ...] = ()
    """Further ones, label and text."""
    governor: str = ""
    """Of the law, after its name."""
    numbers: Mapping[str, Any] = MappingProxyType({})
    """For JSON."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Vehicle:
    """A vehicle of ``plant.vehicle``: one room of `vehicles`, or another package's.

    What is None does not apply to the vehicle, and the command that would need it says so.
    """

    name: str
    description: str
    sections: Mapping[str, type]
    """Section of a scenario file -> dataclass of its parameters (`parameters.sections`)."""
    plant: Lazy
    """Function of a scenario that returns the `Plant`."""
    methods: tuple[Method, ...] = ()
    governors: tuple[GovernorLaw, ...] = ()
    checks: Lazy | None = None
    """Function of a `Checked`: adds a problem for values that do not fit together."""
    defaults: Lazy | None = None
    """Function of a `Checked`: the formulas of defaults that follow from other values, as
    (section, name, function without arguments), in the order of their dependence."""
    former_defaults: Lazy | None = None
    """Function of the values of a recorded scenario without stated defaults: those that it took."""
    revision: Lazy | None = None
    """Function of a scenario and of its given values, by section and dotted name: takes out of them
    what another controller along the flight need not meet."""
    warmup: Lazy | None = None
    """Pair of functions: one yields short flights, by section, that compile the vehicle's kernels;
    one takes the first of these scenarios, and compiles what no flight needs."""
    planner: Lazy | None = None
    """Planner of its transfers for ``gnc plan``, and reader of plans
    (`drawing.vehicle.VehiclePlanner`)."""
    outlook: Lazy | None = None
    """Function of a scenario and of whether it is cut short on purpose: the `Outlook`."""
    facts: Lazy | None = None
    """Function of a scenario and its `Outlook`: the `Facts`."""
    craft: Lazy | None = None
    """Function of a scenario: the namespaces of its craft, relative to the agent's, where the
    vehicle is several craft with a controller node each (`scenario.craft`). None: it is one."""
    signals: Lazy | None = None
    """Tuple of the signals that its nodes exchange (`signals.Signal`)."""
    flight: Lazy | None = None
    """Class of its flights (`loop.flight.Flight`)."""
    columns: Lazy | None = None
    """Function of a bag that reads such a flight from it."""
    outputs: Lazy | None = None
    """Function of a scenario: what its controller and governor publish at each step."""
    audit: Lazy | None = None
    """Audit of a bag (`audit.vehicle.VehicleAudit`)."""
    metrics: Lazy | None = None
    """Function of a flight and its scenario: the summary in numbers, by name."""
    summary: Lazy | None = None
    """Function of the metrics of a flight: what to say of it, (label, text) by line."""
    figures: Lazy | None = None
    """Figures for print (`drawing.vehicle.VehicleFigures`)."""
    report: Lazy | None = None
    """Page of one flight or several (`drawing.vehicle.VehicleReport`)."""
    scene: Lazy | None = None
    live: Lazy | None = None
    """What the live page and the dashboard show (`drawing.live.VehicleLive`)."""
    resolve: Lazy | None = None

    def method(self, name: str) -> Method | None:
        """Return the vehicle's own method of that name."""
        return next((method for method in self.methods if method.name == name), None)

    def governor(self, name: str) -> GovernorLaw | None:
        """Return the vehicle's own governor law of that name."""
        return next((law for law in self.governors if law.name == name), None)
