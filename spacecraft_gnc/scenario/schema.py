"""Sections of a scenario file: those of its vehicle, and those of every graph."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Final

from spacecraft_gnc.parameters.declare import Schema
from spacecraft_gnc.parameters.sections import DEFAULT_VEHICLE, NODE_NAMES, SHARED
from spacecraft_gnc.parameters.yaml_file import Entry, Sections
from spacecraft_gnc.vehicles import registry
from spacecraft_gnc.vehicles.vehicle import Vehicle

LAUNCHER: Final = "launcher"
ROLES: Final = (*NODE_NAMES, LAUNCHER)
"""Sections of every scenario file."""
OF_AGENT: Final = ("plant", "nmpc_controller", "reference_governor")
"""Those that each agent of a graph has; there, a plant in the root namespace states what all have
in common."""
OF_GRAPH: Final = ("recorder", LAUNCHER)
"""Those that a graph has once, however many agents."""
_KEY: Final = "vehicle"


@lru_cache(maxsize=64)
def schema_of(vehicle: Vehicle) -> Schema:
    """Return the sections of a vehicle's scenarios."""
    sections = {**vehicle.sections, **SHARED}
    return Schema({role: sections[role] for role in ROLES})


def vehicle_given(entries: Mapping[str, Entry], source: str) -> Vehicle:
    """Return the vehicle that a section ``plant`` names; the default one where it names none.

    Raises
    ------
    InvalidScenario
        If it is unknown, or the plug-in behind it is broken.
    """
    entry = entries.get(_KEY)
    if entry is None or not isinstance(entry.value, str):
        return registry.vehicle_of(DEFAULT_VEHICLE)
    return registry.vehicle_of(entry.value, entry.file or source, entry.line)


def vehicle_entries(sections: Sections, plants: Iterator[str]) -> dict[str, Entry]:
    """Return the entry ``vehicle`` of the sections of that name."""
    found = {}
    for pattern in plants:
        entry = sections[pattern].get(_KEY)
        if entry is not None:
            found[_KEY] = entry
    return found
