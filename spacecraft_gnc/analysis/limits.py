"""Limits of a scenario that its flight exceeded, and by what factor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.analysis.series import pointing_margin_deg
from spacecraft_gnc.types import Array, as_actuators

if TYPE_CHECKING:
    from spacecraft_gnc.scenario import Scenario

TOLERATED: Final = 1e-3
"""Share of a limit by which a flight may exceed it: penalties let a little through."""


class Exceedance(NamedTuple):
    """A limit that a flight exceeded."""

    limit: str
    """Which one: ``torque``, ``momentum`` or ``zone NAME``."""
    factor: float
    """Largest value as a multiple of the limit; of a zone, 1 + depth / half-angle."""
    value: float
    """Largest value in the limit's unit; of a zone, how deep the axis was beyond its border."""
    bound: float
    """The limit; of a zone, its half-angle."""
    unit: str

    def __str__(self) -> str:
        """Return which limit, the factor and the numbers behind it."""
        if self.unit == "deg":
            numbers = f"{self.value:.4g} deg beyond the border of a cone of {self.bound:g} deg"
        else:
            numbers = f"{self.value:.4g} {self.unit}, limit {self.bound:g} {self.unit}"
        return f"{self.limit} {self.factor:.4g} times ({numbers})"


def limits_exceeded(
    scenario: Scenario, attitudes: Array, momenta: Array, torques: Array
) -> tuple[Exceedance, ...]:
    """Return the limits that a flight exceeded by more than 0.1 %.

    Those of the controller on the norm of its controls, of a governor on torque and momentum, and
    of the pointing zones.

    Parameters
    ----------
    scenario : Scenario
        What flew.
    attitudes, momenta : (n, 3, 3), (n, 3) arrays
        States, body to inertial and body frame [N m s]; rows that are not known are NaN.
    torques : (m, 3) array
        Body torques [N m].
    """
    found = _exceedances(scenario, attitudes, momenta, torques)
    return tuple(each for each in found if each.factor > 1.0 + TOLERATED)


def as_dicts(exceeded: Sequence[Exceedance]) -> list[dict[str, Any]]:
    """Return the exceeded limits, each with its line of text, ready for JSON."""
    return [{**each._asdict(), "text": str(each)} for each in exceeded]


def _exceedances(
    scenario: Scenario, attitudes: Array, momenta: Array, torques: Array
) -> Iterator[Exceedance]:
    controller, governor = scenario.controller, scenario.governor
    actuators = as_actuators(controller.actuators if controller.actuators.size else None)
    controls = torques @ np.linalg.pinv(actuators).T
    is_governed = governor.governor != "none"
    for name, vectors, bound, unit in (
        ("torque", controls, controller.max_torque, "N m"),
        ("governed torque", torques, governor.max_torque if is_governed else 0.0, "N m"),
        ("momentum", momenta, governor.max_momentum if is_governed else 0.0, "N m s"),
    ):
        value = _largest(np.linalg.norm(vectors, axis=1))
        if bound > 0.0:
            yield Exceedance(name, value / bound, value, bound, unit)
    for zone in controller.zones:
        depth = _largest(-pointing_margin_deg(attitudes, zone))
        half_angle = zone.half_angle_deg
        yield Exceedance(f"zone {zone.name}", 1.0 + depth / half_angle, depth, half_angle, "deg")


def _largest(values: Array) -> float:
    """Return the largest value that is known; 0 where none is."""
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else 0.0
