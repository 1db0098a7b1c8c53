"""Declaration of one parameter: type, unit, admissible values and description.

A parameter is a dataclass field whose metadata holds one `ParameterSpec`; a dataclass of them is a
section, and may hold groups of further ones. Nothing else in the package states a type, a unit, a
range or a description again: the YAML check, the ROS 2 declaration and the table in the
documentation are all derived from it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np

Value: TypeAlias = bool | int | float | str | list[Any]
"""A parameter value in its ROS 2 form: a scalar, or a flat list of scalars of one type."""

LARGEST: Final = 1e15
"""Of a momentum or a torque, in SI units: far more than any spacecraft has, and so little that
fourth powers, times the largest weight, stay numbers of double precision."""
LARGEST_WEIGHT: Final = 1e60
LONGEST: Final = 2**31 - 1.0
"""[s] of simulated time: ROS 2 counts its seconds in 32 bits."""
SHORTEST: Final = 1e-6
"""[s] between two steps: ROS 2 stamps count nanoseconds, of which a period is a whole number."""
WITHIN: Final = {"minimum": -LARGEST, "maximum": LARGEST}
"""Range of a component of a vector or of an actuator matrix."""
ANGLES: Final = {"minimum": -1e3, "maximum": 1e3}
"""[rad] of a component of a rotation vector: longer ones leave an attitude fewer digits."""

_METADATA_KEY: Final = "spacecraft_gnc.parameter"
_GROUP_KEY: Final = "spacecraft_gnc.group"


class Kind(Enum):
    """ROS 2 type of a parameter; the names are those of ``rclpy.Parameter.Type``, plus DYNAMIC."""

    BOOL = "BOOL"
    INTEGER = "INTEGER"
    DOUBLE = "DOUBLE"
    STRING = "STRING"
    BOOL_ARRAY = "BOOL_ARRAY"
    INTEGER_ARRAY = "INTEGER_ARRAY"
    DOUBLE_ARRAY = "DOUBLE_ARRAY"
    STRING_ARRAY = "STRING_ARRAY"
    DYNAMIC = "DYNAMIC"
    """A double or a double array: declare with dynamic typing."""


class MatrixRule(Enum):
    """What a 3x3 matrix has to be."""

    NONE = "any"
    INERTIA = "an inertia matrix"
    SEMIDEFINITE = "a symmetric positive semi-definite matrix"
    DEFINITE = "a symmetric positive definite matrix"


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class ParameterSpec:
    """Type, unit, admissible values and description of one parameter."""

    kind: Kind
    default: Value
    """Default in its ROS 2 form; the empty list stands for "not given"."""
    description: str
    unit: str = ""
    """SI unit; empty for a pure number or a word."""
    minimum: float | None = None
    maximum: float | None = None
    above: float | None = None
    """Exclusive lower bound."""
    below: float | None = None
    """Exclusive upper bound."""
    choices: tuple[str, ...] = ()
    """The only words allowed (for a string array: as elements)."""
    paths: bool = False
    """A namespace may stand before a choice: ``sc1/nmpc_controller``."""
    plugins: str = ""
    """Registry group that knows the names allowed (`vehicles.registry`); empty where none does."""
    shape: tuple[int, ...] = ()
    """(): scalar, (3,), (3, 3) given as 9 numbers row-major, (-1,): any length, (3, -1): 3 rows,
    (-1, 3): rows of 3 numbers."""
    may_be_empty: bool = False
    required: bool = False
    infinite: bool = False
    """Whether infinity is admitted, such as for no bound."""
    is_file: bool = False
    """A path of a file, relative to the folder of the scenario's own file."""
    nonzero: bool = False
    """A vector of length zero is refused."""
    unique: bool = False
    """No element may appear twice."""
    matrix: MatrixRule = MatrixRule.NONE
    formula: str = ""
    """How the default follows from other values, in words; `defaults` works it out in a scenario.
    Where there is none, ``default`` stands for it."""
    is_neutral: bool = False
    """Whether the default changes no flight: a fingerprint then leaves it out, and is what it was
    before the parameter existed."""
    otherwise: str = ""
    """Parameter, ``section.name``, whose value counts where this one has its default."""
    read_only: bool = True
    """The value is fixed once the node is configured."""

    @property
    def length(self) -> int:
        """Numbers in the flat array; -1 where any number is allowed."""
        return -1 if -1 in self.shape else math.prod(self.shape)

    @property
    def rows(self) -> int:
        """Number that the length of the flat array is a multiple of."""
        return abs(math.prod(self.shape)) if self.length == -1 else 1

    @property
    def range_text(self) -> str:
        """Admissible range in words, such as ``> 0``; empty where there is none."""
        if self.minimum is not None and self.maximum is not None:
            return f"{self.minimum:.12g} to {self.maximum:.12g}"
        bounds = {">": self.above, ">=": self.minimum, "<": self.below, "<=": self.maximum}
        return " and ".join(f"{sign} {b:.12g}" for sign, b in bounds.items() if b is not None)

    @property
    def lowest(self) -> float | None:
        """Smallest number admitted: what a ROS 2 range, which is closed, starts with."""
        return self.minimum if self.above is None else math.nextafter(self.above, math.inf)

    @property
    def highest(self) -> float | None:
        """Largest number admitted."""
        return self.maximum if self.below is None else math.nextafter(self.below, -math.inf)

    def is_too_low(self, number: float) -> bool:
        """Tell whether a number lies below the range."""
        return self.lowest is not None and number < self.lowest

    def is_too_high(self, number: float) -> bool:
        """Tell whether a number lies above the range."""
        return self.highest is not None and number > self.highest

    @property
    def type_text(self) -> str:
        """Type, size and unit in words, such as ``3 numbers [N m s]``."""
        text = _TYPE_TEXTS[self.kind]
        if self.kind is Kind.DOUBLE_ARRAY:
            text = _ARRAY_TEXTS.get(self.shape, text)
        return f"{text} [{self.unit}]" if self.unit else text

    @property
    def listed_choices(self) -> str:
        """The choices in words; the empty one in quotes."""
        return ", ".join(choice or "''" for choice in self.choices)

    @property
    def requirement(self) -> str:
        """Everything that is required of a value, in words."""
        parts = [self.type_text]
        if self.range_text:
            parts.append(self.range_text)
        if self.choices:
            parts.append(f"out of {self.listed_choices}")
        return ", ".join(parts)


_TYPE_TEXTS: Final = {
    Kind.BOOL: "true or false",
    Kind.INTEGER: "an integer",
    Kind.DOUBLE: "a number with a decimal point",
    Kind.STRING: "a string",
    Kind.BOOL_ARRAY: "a list of true and false",
    Kind.INTEGER_ARRAY: "a list of integers",
    Kind.DOUBLE_ARRAY: "a list of numbers with decimal points",
    Kind.STRING_ARRAY: "a list of strings",
    Kind.DYNAMIC: "a number with a decimal point, or 9 of them (3x3, row-major)",
}
_ARRAY_TEXTS: Final = {
    (3,): "3 numbers",
    (3, 3): "9 numbers (3x3, row-major)",
    (3, -1): "3 m numbers (3 x m, row-major)",
    (-1, 3): "3 n numbers (n x 3, row-major)",
}


def parameter(kind: Kind, default: Value, description: str, **options: Any) -> Any:
    """Return a dataclass field described by a `ParameterSpec` with these ``options``."""
    spec = ParameterSpec(kind=kind, default=default, description=description, **options)
    return dataclasses.field(default_factory=_default_factory(spec), metadata={_METADATA_KEY: spec})


@cache
def specs_of(section: type) -> tuple[tuple[str, ParameterSpec], ...]:
    """Return (name, spec) of the parameters that a section class declares itself."""
    return _described(section, _METADATA_KEY)


class Group(NamedTuple):
    """Parameters nested in a section, ``weights.<parameter>`` or ``zones.<name>.<parameter>``."""

    parameters: type
    """Dataclass of them; where there is one group for each name, it has a field ``name``."""
    names: str = ""
    """String array of the section that lists the names; empty where there is one group only."""
    noun: str = ""
    """What a name stands for, such as ``zone``."""


def group(parameters: type) -> Any:
    """Return a dataclass field that holds a group, ``<field>.<parameter>`` in a file."""
    return dataclasses.field(default_factory=parameters, metadata={_GROUP_KEY: Group(parameters)})


def named_groups(parameters: type, names: str, noun: str) -> Any:
    """Return a field that holds a tuple of groups, ``<field>.<name>.<parameter>`` in a file."""
    return dataclasses.field(default=(), metadata={_GROUP_KEY: Group(parameters, names, noun)})


@cache
def groups_of(section: type) -> tuple[tuple[str, Group], ...]:
    """Return (field, group) of the groups of a section class."""
    return _described(section, _GROUP_KEY)


def _described(section: type, key: str) -> tuple[tuple[str, Any], ...]:
    fields = dataclasses.fields(section)
    return tuple((field.name, field.metadata[key]) for field in fields if key in field.metadata)


@cache
def names_of(section: type) -> frozenset[str]:
    """Return the dotted names of a section class, without those of named groups."""
    nested = {
        f"{field}.{name}"
        for field, (parameters, names, _) in groups_of(section)
        if not names
        for name in names_of(parameters)
    }
    return frozenset(nested | {name for name, _ in specs_of(section)})


def typed_section(section: type, values: Mapping[str, Value], **further: Any) -> Any:
    """Return an instance of a section class from admissible values by dotted name."""
    fields = {name: typed(spec, values[name]) for name, spec in specs_of(section)}
    for field, (parameters, names, _) in groups_of(section):
        if names:
            fields[field] = tuple(
                typed_section(parameters, _beneath(f"{field}.{name}.", values), name=name)
                for name in fields[names]
            )
        else:
            fields[field] = typed_section(parameters, _beneath(f"{field}.", values))
    return section(**fields, **further)


def _beneath(prefix: str, values: Mapping[str, Value]) -> dict[str, Value]:
    return {n.removeprefix(prefix): v for n, v in values.items() if n.startswith(prefix)}


def typed(spec: ParameterSpec, value: Value) -> Any:
    """Return an admissible ROS 2 value as the core wants it.

    Numeric arrays become read-only float64 arrays of the shape of ``spec`` (a scalar weight s
    becomes s I), arrays of strings or integers become tuples, a numeric array that is not given
    becomes all NaN.
    """
    if spec.kind in (Kind.STRING_ARRAY, Kind.INTEGER_ARRAY):
        return tuple(value) if isinstance(value, list) else (value,)
    if spec.kind not in (Kind.DOUBLE_ARRAY, Kind.DYNAMIC):
        return value
    array = np.array(value, dtype=np.float64)
    if array.ndim == 0:
        array = float(array) * np.eye(3)
    if array.size == 0 and spec.length > 0:
        array = np.full(spec.length, np.nan)
    array = array.reshape(spec.shape)
    array.setflags(write=False)
    return array


def _default_factory(spec: ParameterSpec) -> Callable[[], Any]:
    return lambda: typed(spec, spec.default)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class NodeParameters:
    """What every node has."""

    autostart: bool = parameter(
        Kind.BOOL, True, "the node configures and activates itself; the launcher passes false"
    )
    plugin: Mapping[str, Value] = dataclasses.field(default_factory=dict)
    """Parameters ``plugin.<name>`` for a vehicle, method or governor of another package."""
