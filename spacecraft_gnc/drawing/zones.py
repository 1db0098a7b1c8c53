"""Pointing zones as pictures and metrics read them."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array


class Zone(Protocol):
    """A cone of the inertial frame about which a body axis is told."""

    @property
    def name(self) -> str:
        """Of the zone."""

    @property
    def kind(self) -> str:
        """``exclusion`` or ``inclusion``."""

    @property
    def body_axis(self) -> Array:
        """(3,), of any length."""

    @property
    def inertial_axis(self) -> Array:
        """(3,), of any length."""

    @property
    def half_angle_deg(self) -> float:
        """Of the cone [deg]."""


def unit(axis: Array) -> Array:
    """Return the unit vector (3,) along an axis."""
    return np.asarray(axis / np.linalg.norm(axis))


def pointing_margin_deg(attitudes: Array, zone: Zone) -> Array:
    """Return the (n,) angles left to the border of a pointing zone at (n, 3, 3) attitudes [deg]."""
    pointing = attitudes @ unit(zone.body_axis)
    angle = np.degrees(lie.vector_angle(pointing, unit(zone.inertial_axis)))
    beyond = angle - zone.half_angle_deg
    return np.asarray(beyond if zone.kind == "exclusion" else -beyond)
