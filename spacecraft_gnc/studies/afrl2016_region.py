"""Region of attraction from a campaign of random starts: Fig. 5."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.campaign.results import Campaign
from spacecraft_gnc.studies.campaigns import column
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.euler import from_euler_321

NEAR: Final = 1.0  # rad: Euler angles of starts that count as near
_START: Final = "plant.initial_euler_321"


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """Starts of a campaign, and what became of them.

    Attributes
    ----------
    euler : (n, 3) array
        Roll, pitch, yaw at the start [rad].
    settled_at : (n,) array
        Time from which on it is at rest at the target for good [s]; NaN: never.
    error_deg : (n,) array
        Angle to the target at the end [deg]; NaN: not flown.
    status : list of str
        Of each row.
    """

    euler: Array
    settled_at: Array
    error_deg: Array
    status: list[str]

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(n,) whether it settled."""
        return np.isfinite(self.settled_at)

    @property
    def near(self) -> NDArray[np.bool_]:
        """(n,) whether no Euler angle of the start is larger than `NEAR`."""
        return np.asarray((np.abs(self.euler) <= NEAR).all(axis=1))

    @property
    def angle_deg(self) -> Array:
        """(n,) angle of the turn from the start to the target [deg]."""
        attitudes = np.array([from_euler_321(angles) for angles in self.euler])
        return np.degrees(lie.angles_between(attitudes, np.eye(3)))

    @property
    def share(self) -> float:
        """Share that converged; NaN of none."""
        return float(self.converged.mean()) if self.converged.size else math.nan

    def of(self, chosen: NDArray[np.bool_]) -> Region:
        """Return the part with the starts (n,) that are chosen."""
        status = [each for each, take in zip(self.status, chosen, strict=True) if take]
        return Region(self.euler[chosen], self.settled_at[chosen], self.error_deg[chosen], status)

    def values(self) -> dict[str, Any]:
        """Return the numbers, ready for JSON."""
        return {
            "starts": len(self.status),
            "converged": int(self.converged.sum()),
            "settle_time_median": _quantile(self.settled_at, 0.5),
            "settle_time_max": _quantile(self.settled_at, 1.0),
        }


def region_of(campaign: Campaign) -> Region:
    """Return the region of attraction that a campaign shows."""
    status = campaign.table(["status"])["status"].to_pylist()
    settled, error = (column(campaign, name) for name in ("settle_time", "final_error_deg"))
    return Region(column(campaign, _START), settled, error, status)


def _quantile(values: Array, share: float) -> float:
    known = values[np.isfinite(values)]
    return float(np.quantile(known, share)) if known.size else math.nan
