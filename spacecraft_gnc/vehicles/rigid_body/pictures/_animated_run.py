"""Data of one animated flight."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import style
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body import series

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.parameters.zones import ZoneParameters
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

DASHES = ("-", (0, (4.0, 1.5)), (0, (1.5, 1.0)))


class AnimatedRun(NamedTuple):
    """One flight with n + 1 states."""

    name: str
    line: dict[str, Any]
    """Color and line style of its curves."""
    times: Array
    """(n + 1,) of the states [s]."""
    attitudes: Array
    """(n + 1, 3, 3), body to inertial."""
    targets: Array
    """(n + 1, 3, 3)."""
    references: Array | None
    """(n + 1, 3, 3) of the governor; None where there is none."""
    instruments: Array
    """(m, 3) unit vectors, body frame: the axes that zones bar; body x without zones."""
    zones: tuple[ZoneParameters, ...]
    error: Array
    """(n + 1,) angles to the target [deg]."""
    margins: Array
    """(zones, n + 1) angles to the zones, negative inside [deg]."""
    violated: NDArray[np.bool_]
    """(m, n + 1): at which states a zone of each instrument was violated."""
    torque: Array
    """(n,) norms [N m]."""
    limit: float
    """On the norm of the torque [N m]; 0: none."""

    def row(self, time: float) -> int:
        """Return the row of the last state at a time [s]."""
        return max(int(np.searchsorted(self.times, time + 1e-9, side="right")) - 1, 0)

    def worst(self, row: int) -> tuple[float, str] | None:
        """Return the least margin up to a row [deg], and the zone; None without one."""
        flown = self.margins[:, : row + 1]
        if not np.isfinite(flown).any():
            return None
        zone, _ = np.unravel_index(int(np.nanargmin(flown)), flown.shape)
        return float(np.nanmin(flown)), self.zones[int(zone)].name


def animated_run(name: str, flight: Flight, scenario: Scenario | None, index: int) -> AnimatedRun:
    """Return what is shown of the flight that stands at a place, from 0."""
    zones = scenario.controller.zones if scenario is not None else ()
    times = series.state_times(flight)
    margins = np.array([series.zone_margin_deg(flight, zone) for zone in zones])
    margins = margins.reshape(len(zones), len(times))
    instruments, of_zone = _instruments(zones)
    violated = [(margins[of_zone == i] < 0.0).any(axis=0) for i in range(len(instruments))]
    return AnimatedRun(
        name=name,
        line={"color": style.RUN_COLORS[index], "linestyle": DASHES[index]},
        times=times,
        attitudes=series.attitudes(flight),
        targets=np.concatenate([flight.target, flight.target[-1:]]),
        references=series.references(flight) if series.is_governed(flight) else None,
        instruments=instruments,
        zones=zones,
        error=series.settling_error_deg(flight),
        margins=margins,
        violated=np.array(violated),
        torque=series.torque_norm(flight),
        limit=series.torque_limit(flight, scenario),
    )


def _instruments(zones: tuple[ZoneParameters, ...]) -> tuple[Array, NDArray[np.intp]]:
    """Return the (m, 3) different body axes of zones, as unit vectors, and the one of each zone."""
    if not zones:
        return np.eye(3)[:1], np.zeros(0, dtype=np.intp)
    axes = np.array([zone.body_axis / np.linalg.norm(zone.body_axis) for zone in zones])
    _, first, of_zone = np.unique(axes.round(9), axis=0, return_index=True, return_inverse=True)
    return axes[first], of_zone.ravel()
