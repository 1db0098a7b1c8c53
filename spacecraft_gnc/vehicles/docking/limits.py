"""Constraints that a docking flight broke, and by how much."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc.audit.limits import Exceedance, beyond
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.docking.flight import DockingFlight
    from spacecraft_gnc.vehicles.docking.scenario import Scenario

_SCALE = 1.0  # [m] of a depth in a factor


class Intrusion(Exceedance):
    """A least distance that was not kept.

    ``value`` is how deep beyond it [m], ``bound`` the distance [m], ``factor`` 1 + depth / 1 m.
    """

    __slots__ = ()

    def __str__(self) -> str:
        """Return which distance, and by how much it was missed."""
        return f"{self.limit} by {self.value:.4g} m"


def limits_exceeded(flight: DockingFlight, scenario: Scenario) -> tuple[Exceedance, ...]:
    """Return the constraints that a flight broke: by more than 0.1 % of a limit, or by 1 mm.

    Force and moment are the commands, by component; the distances those between the steps too.
    """
    return beyond(_exceedances(flight, scenario))


def _exceedances(flight: DockingFlight, scenario: Scenario) -> Iterator[Exceedance]:
    p = scenario.plant
    for name, values, bound, unit in (
        ("force", flight.force, p.max_force, "N"),
        ("moment", flight.moment, p.max_moment, "N m"),
    ):
        most = float(np.nanmax(np.abs(values), initial=0.0))
        yield Exceedance(name, most / bound if bound else 1.0, most, bound, unit)
    for name, distances, bound in (
        ("line of sight", margins(flight), 0.0),
        ("clearance", clearances(flight), -p.clearance_tolerance),
    ):
        depth = bound - float(np.nanmin(distances, initial=bound))
        yield Intrusion(name, 1.0 + depth / _SCALE, depth, bound, "m")


def margins(flight: DockingFlight) -> Array:
    """Return the line-of-sight margins (n + 1,) [m]: row k of the step that ended at state k."""
    return np.append(flight.line_of_sight_margin, flight.final_line_of_sight_margin)


def clearances(flight: DockingFlight) -> Array:
    """Return the clearances (n + 1,) [m], likewise."""
    return np.append(flight.clearance, flight.final_clearance)
