"""Namespaces of the craft of a formation."""

from __future__ import annotations

from spacecraft_gnc.vehicles.formation.scenario import Scenario


def craft(scenario: Scenario) -> tuple[str, ...]:
    """Return the namespace of each craft's controller, in the order of the arrays."""
    return tuple(name.strip("/") for name in scenario.plant.spacecraft)
