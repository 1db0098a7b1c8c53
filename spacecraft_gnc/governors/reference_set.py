"""Set V of admissible references: attitudes with a margin to every pointing zone at rest.

Source: Kalabic et al. 2014, (7) and section V-A, for zones of any kind and number. A set with an
exclusion zone has not the convexity-like property (12): a geodesic may leave it on the way, so
membership is checked for each reference, and a way round is the business of `prediction.Planner`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from spacecraft_gnc.arguments import as_real, as_tuple, require_members
from spacecraft_gnc.arrays import as_shaped, as_stack
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors._zone_kernels import ZONE_SIZE, nearest_zone
from spacecraft_gnc.types import Array, Matrix3, read_only

if TYPE_CHECKING:
    from spacecraft_gnc.ocp.zones import PointingZone

_OF_A_ZONE: Final = ("body_axis", "inertial_axis", "half_angle", "sign", "margin")


class ReferenceSet:
    """Attitudes whose angle to every zone's border is at least ``steady_margin``.

    Parameters
    ----------
    zones : sequence of PointingZone
        None: every attitude belongs to the set.
    steady_margin : float
        [rad]
    names : sequence of str, optional
        Names of the zones, for messages; "zone 1", "zone 2"... if absent.

    Raises
    ------
    ParameterError
        If the margin is not positive, or there is not one name for each zone.
    """

    def __init__(
        self,
        zones: tuple[PointingZone, ...] = (),
        steady_margin: float = math.radians(0.1),
        names: tuple[str, ...] | None = None,
    ) -> None:
        self.zones = as_tuple("zones", zones, "PointingZone")
        for i, zone in enumerate(self.zones):
            require_members(f"zones[{i}]", zone, _OF_A_ZONE, "PointingZone")
        self.steady_margin = as_real(
            "steady_margin", steady_margin, lambda x: 0.0 < x < math.pi,
            "a number between 0 and pi [rad]: a reference on the border of a zone would leave no "
            "room for any motion", "give for example 0.002",
        )  # fmt: skip
        known = [f"zone {i + 1}" for i in range(len(self.zones))]
        self.names = tuple(known) if names is None else as_tuple("names", names, "str")
        if len(self.names) != len(self.zones):
            raise ParameterError(
                f"names: received {len(self.names)} for {len(self.zones)} zones; required one for "
                "each zone; leave them out for numbers"
            )
        self.rows = _rows(self.zones)

    def margin(self, attitude: Matrix3) -> tuple[float, str]:
        """Return the smallest angle [rad] to a zone's border, and that zone's name.

        Negative inside a forbidden region; infinite, with an empty name, without zones.
        """
        angle, i = nearest_zone(self.rows, as_shaped("attitude", attitude, (3, 3)))
        return angle, self.names[i] if i >= 0 else ""

    def margins(self, attitudes: Array) -> Array:
        """Return the smallest angle (n,) [rad] to a zone's border at attitudes (n, 3, 3)."""
        attitudes = as_stack("attitudes", attitudes)
        if not self.zones:
            return np.full(len(attitudes), math.inf)
        return np.asarray(np.min([zone.margin(attitudes) for zone in self.zones], axis=0))

    def contains(self, attitude: Matrix3) -> bool:
        """Tell whether an attitude (3, 3) belongs to the set."""
        return self.margin(attitude)[0] >= self.steady_margin

    def require(self, name: str, attitude: Matrix3) -> None:
        """Refuse an attitude (3, 3) outside the set.

        Raises
        ------
        ParameterError
            With the zone, the margin there is and the margin required.
        """
        angle, zone = self.margin(attitude)
        if not angle >= self.steady_margin:
            raise ParameterError(
                f"{name}: received an attitude with a margin of {math.degrees(angle):.6g} deg to "
                f"zone {zone!r}; required at least {math.degrees(self.steady_margin):g} deg at "
                "rest (steady_margin_deg); choose an attitude further from the zone's border"
            )


def _rows(zones: tuple[PointingZone, ...]) -> Array:
    rows = np.zeros((len(zones), ZONE_SIZE))
    for row, zone in zip(rows, zones, strict=True):
        row[0:3], row[3:6] = zone.body_axis, zone.inertial_axis
        row[6:8] = zone.half_angle, zone.sign
    return read_only(rows)
