"""Parameters by their ROS 2 names: what a node declares, what a file may hold.

Nested maps are flattened with dots as ROS 2 does: ``weights.stage_attitude``,
``zones.<name>.half_angle_deg``, ``plugin.<name>``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

from spacecraft_gnc.parameters.parameter import Kind, ParameterSpec, Value, specs_of
from spacecraft_gnc.scenario.schema import SECTIONS, WeightParameters, ZoneParameters

PLUGIN_PREFIX: Final = "plugin."
ZONE_PREFIX: Final = "zones."
_WEIGHT_PREFIX: Final = "weights."
_WITH_WEIGHTS_AND_ZONES: Final = "nmpc_controller"
_WITHOUT_PLUGIN: Final = "launcher"
_ROS_OWN: Final = ("use_sim_time", "start_type_description_service")
_ROS_OWN_PREFIX: Final = "qos_overrides."


class Declaration(NamedTuple):
    """A parameter as a node declares it."""

    name: str
    """Dotted ROS 2 name, without the node."""
    spec: ParameterSpec


def declarations(
    section: str, zone_names: Iterable[str] = (), plugin: Mapping[str, Value] | None = None
) -> tuple[Declaration, ...]:
    """Return every parameter of a node, in the order of the schema.

    Parameters
    ----------
    section : str
        Node name, a key of `schema.SECTIONS`.
    zone_names : iterable of str
        Zones to declare; known once ``zone_names`` itself is read.
    plugin : mapping, optional
        Parameters of another package's vehicle, method or governor, without ``plugin.``.
    """
    found = [Declaration(name, spec) for name, spec in specs_of(SECTIONS[section])]
    if section == _WITH_WEIGHTS_AND_ZONES:
        found += [Declaration(_WEIGHT_PREFIX + n, s) for n, s in specs_of(WeightParameters)]
        for zone in zone_names:
            prefix = f"{ZONE_PREFIX}{zone}."
            found += [Declaration(prefix + n, s) for n, s in specs_of(ZoneParameters)]
    for name, value in (plugin or {}).items():
        found.append(Declaration(PLUGIN_PREFIX + name, plugin_spec(value)))
    return tuple(found)


def spec_of(section: str, name: str, value: Value | None) -> ParameterSpec | None:
    """Return the spec of a dotted name, or None where the section has no such parameter."""
    if name.startswith(PLUGIN_PREFIX) and section != _WITHOUT_PLUGIN:
        return plugin_spec("" if value is None else value)
    zone = zone_of(name)
    zones = () if zone is None else (zone,)
    return dict(declarations(section, zones)).get(name)


def known_names(section: str, zone: str | None = None) -> tuple[str, ...]:
    """Return the names to suggest for an unknown one."""
    return tuple(d.name for d in declarations(section, () if zone is None else (zone,)))


def zone_of(name: str) -> str | None:
    """Return the zone that ``zones.<zone>.<field>`` is about, else None."""
    parts = name.split(".")
    return parts[1] if len(parts) == 3 and parts[0] == "zones" and parts[1] else None


def is_ros_own(section: str, name: str) -> bool:
    """Tell whether every ROS 2 node has this parameter without our doing."""
    if section == "launcher":
        return False
    return name in _ROS_OWN or name.startswith(_ROS_OWN_PREFIX)


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
