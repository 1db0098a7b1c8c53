"""Constraints that a flight in formation broke, and by how much."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from spacecraft_gnc.audit.limits import Exceedance, beyond
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.geometry import separations
from spacecraft_gnc.vehicles.formation.metrics import delta_v_norms, healthy_pairs

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.formation.flight import FormationFlight
    from spacecraft_gnc.vehicles.formation.scenario import Scenario


class Shortfall(Exceedance):
    """A least distance that was not kept.

    ``value`` is the least distance [m], ``bound`` what was to be kept, ``factor`` 1 + what is
    missing as a share of it.
    """

    __slots__ = ()

    def __str__(self) -> str:
        """Return which distance, how small it was, and how large it was to be."""
        return f"{self.limit} {self.value:.4g} {self.unit}, at least {self.bound:g} {self.unit}"


class Angle(Exceedance):
    """A largest angle that was exceeded, in degrees."""

    __slots__ = ()

    def __str__(self) -> str:
        """Return which angle, and both numbers."""
        return f"{self.limit} {self.value:.4g} {self.unit}, limit {self.bound:g} {self.unit}"


def limits_exceeded(flight: FormationFlight, scenario: Scenario) -> tuple[Exceedance, ...]:
    """Return the constraints that a flight broke at the steps, by more than 0.1 % of a limit.

    Delta-v is what was commanded. A lost craft makes none, and talks to nobody; the distance to it
    counts.
    """
    return beyond(_exceedances(flight, scenario))


def _exceedances(flight: FormationFlight, scenario: Scenario) -> Iterator[Exceedance]:
    p = scenario.plant
    most = float(np.nanmax(delta_v_norms(flight.delta_v, flight.healthy), initial=0.0))
    yield Exceedance("delta-v", most / p.max_delta_v, most, p.max_delta_v, "m/s")
    least = float(np.nanmin(all_separations(flight), initial=np.inf))
    short = 1.0 - least / p.min_separation
    yield Shortfall("separation", 1.0 + short, least, p.min_separation, "m")
    widest = float(np.nanmax(communication_angles(flight), initial=0.0))
    bound = p.max_communication_angle_deg
    yield Angle("communication angle", widest / bound, widest, bound, "deg")


def all_separations(flight: FormationFlight) -> Array:
    """Return the distance of each pair (n + 1, pairs) [m], the end of the flight included."""
    return np.vstack([flight.separation, separations(flight.final_position)])


def communication_angles(flight: FormationFlight) -> Array:
    """Return the angle of each pair (n, pairs) [deg]; NaN from the loss of one of the two on."""
    return np.where(healthy_pairs(flight.healthy), flight.communication_angle_deg, np.nan)
