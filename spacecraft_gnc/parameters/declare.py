"""Parameters by their ROS 2 names: what a node declares, what a file may hold.

Nested maps are flattened with dots as ROS 2 does: ``weights.stage_attitude``,
``zones.<name>.half_angle_deg``, ``plugin.<name>``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import starmap
from typing import Any, Final, NamedTuple, TypeAlias

from spacecraft_gnc.parameters.parameter import (
    Group,
    Kind,
    NodeParameters,
    ParameterSpec,
    Value,
    groups_of,
    specs_of,
)

PLUGIN_PREFIX: Final = "plugin."
_ROS_OWN: Final = ("use_sim_time", "start_type_description_service")
_ROS_OWN_PREFIX: Final = "qos_overrides."
_Elements: TypeAlias = tuple[tuple[str, tuple[str, ...]], ...]
_NO_ELEMENTS: Final[Mapping[str, Iterable[str]]] = {}


class Declaration(NamedTuple):
    """A parameter as a node declares it."""

    name: str
    """Dotted ROS 2 name, without the node."""
    spec: ParameterSpec


class Element(NamedTuple):
    """One of the named groups of a section, such as the zone ``sun`` of ``zones``."""

    field: str
    name: str


@dataclass(frozen=True, slots=True)
class Schema:
    """The sections of a scenario file, each a dataclass of parameters."""

    sections: Mapping[str, type]

    def declarations(
        self,
        section: str,
        elements: Mapping[str, Iterable[str]] = _NO_ELEMENTS,
        plugin: Mapping[str, Value] | None = None,
    ) -> tuple[Declaration, ...]:
        """Return every parameter of a section, in the order of its class.

        Parameters
        ----------
        section : str
            Key of ``sections``.
        elements : mapping
            Field of named groups -> the names to declare, such as ``{"zones": ["sun"]}``.
        plugin : mapping, optional
            Parameters of another package's vehicle, method or governor, without ``plugin.``.
        """
        given = tuple((field, tuple(names)) for field, names in elements.items())
        found = _declarations(self.sections[section], given)
        plugins = ((PLUGIN_PREFIX + name, plugin_spec(v)) for name, v in (plugin or {}).items())
        return (*found, *starmap(Declaration, plugins)) if plugin else found

    def spec_of(self, section: str, name: str, value: Value | None) -> ParameterSpec | None:
        """Return the spec of a dotted name, or None where the section has no such parameter."""
        if name.startswith(PLUGIN_PREFIX) and self.is_node(section):
            return plugin_spec("" if value is None else value)
        parameters = self.sections[section]
        found = _declared(parameters, ()).get(name)
        return found or _declared(parameters, self._elements(section, name)).get(name)

    def known_names(self, section: str, like: str = "") -> tuple[str, ...]:
        """Return the names to suggest for an unknown one."""
        return tuple(_declared(self.sections[section], self._elements(section, like)))

    def element_of(self, section: str, name: str) -> Element | None:
        """Return the element that ``zones.<element>.<parameter>`` is about, else None."""
        field, _, rest = name.partition(".")
        element, _, leaf = rest.partition(".")
        if not (element and leaf) or "." in leaf:
            return None
        known = field in _named_groups(self.sections[section])
        return Element(field, element) if known else None

    def named_groups(self, section: str) -> Iterable[tuple[str, Group]]:
        """Return (field, group) of the groups of which a section has one for each name."""
        return _named_groups(self.sections[section]).items()

    def is_node(self, section: str) -> bool:
        """Tell whether the section belongs to a ROS 2 node."""
        return issubclass(self.sections[section], NodeParameters)

    def is_ros_own(self, section: str, name: str) -> bool:
        """Tell whether every ROS 2 node has this parameter without our doing."""
        is_own = name in _ROS_OWN or name.startswith(_ROS_OWN_PREFIX)
        return is_own and self.is_node(section)

    def _elements(self, section: str, name: str) -> _Elements:
        element = self.element_of(section, name)
        return () if element is None else ((element.field, (element.name,)),)


@cache
def _named_groups(parameters: type) -> Mapping[str, Group]:
    """Return the groups of which a section class has one for each name, by field."""
    return {field: group for field, group in groups_of(parameters) if group.names}


@lru_cache(maxsize=256)
def _declared(parameters: type, elements: _Elements) -> Mapping[str, ParameterSpec]:
    """Return the parameters of a section class by dotted name, with those of named groups."""
    found = dict(specs_of(parameters))
    for field, group in groups_of(parameters):
        names = dict(elements).get(field, ()) if group.names else ("",)
        for name in names:
            prefix = f"{field}.{name}." if name else f"{field}."
            inner = _declared(group.parameters, ())
            found |= {prefix + parameter: spec for parameter, spec in inner.items()}
    return found


@lru_cache(maxsize=256)
def _declarations(parameters: type, elements: _Elements) -> tuple[Declaration, ...]:
    return tuple(starmap(Declaration, _declared(parameters, elements).items()))


def plugin_spec(value: Value) -> ParameterSpec:
    """Return the spec of a parameter whose type is known from its value only."""
    first = value[0] if isinstance(value, list) and value else value
    kind = _KIND_OF_TYPE.get(type(first), Kind.STRING)
    if isinstance(value, list):
        kind = Kind[f"{kind.name}_ARRAY"]
        return ParameterSpec(
            kind=kind, default=[], description=_PLUGIN, shape=(-1,), may_be_empty=True
        )
    return ParameterSpec(kind=kind, default=value, description=_PLUGIN)


def flatten(nested: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested mappings as one, with dotted names."""
    flat: dict[str, Any] = {}
    for key, value in nested.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            flat |= flatten(value, f"{name}.")
        else:
            flat[name] = value
    return flat


def unflatten(flat: Mapping[str, Any]) -> dict[str, Any]:
    """Return dotted names as nested mappings: the inverse of `flatten`."""
    nested: dict[str, Any] = {}
    for name, value in flat.items():
        *parents, leaf = name.split(".")
        place = nested
        for parent in parents:
            place = place.setdefault(parent, {})
        place[leaf] = value
    return nested


_PLUGIN: Final = "parameter of a plug-in"
_KIND_OF_TYPE: Final = {bool: Kind.BOOL, int: Kind.INTEGER, float: Kind.DOUBLE, str: Kind.STRING}
