"""Pointing zones as markers for 3-D viewers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Final

import numpy as np

from spacecraft_gnc.signals.attitude import INERTIAL_FRAME
from spacecraft_gnc.types import Array, Vector3

_EDGES = 36  # of the circle at the mouth of a cone
_RADIUS = 1.0  # [m] length of a cone's side
_LINE_WIDTH = 0.01  # [m]
_LINE_LIST = 5  # Marker.LINE_LIST
_AT_ORIGIN: Final = {"orientation": (0.0, 0.0, 0.0, 1.0)}
_COLORS = {"exclusion": (0.9, 0.2, 0.1, 1.0), "inclusion": (0.1, 0.7, 0.3, 1.0)}


def zone_markers(zones: Iterable[Any]) -> list[dict[str, Any]]:
    """Return the fields of a Marker for the cone of each zone: its rim and its sides."""
    return [_cone(i, zone) for i, zone in enumerate(zones)]


def _cone(number: int, zone: Any) -> dict[str, Any]:
    rim = _rim(zone.inertial_axis, math.radians(zone.half_angle_deg)).tolist()
    points = []
    for i, point in enumerate(rim):
        points += [point, rim[(i + 1) % _EDGES], (0.0, 0.0, 0.0), point]
    return {
        "header": {"frame_id": INERTIAL_FRAME},
        "ns": f"zone/{zone.name}",
        "id": number,
        "type": _LINE_LIST,
        "pose": _AT_ORIGIN,
        "scale": (_LINE_WIDTH, 0.0, 0.0),
        "color": _COLORS[zone.kind],
        "frame_locked": True,
        "points": points,
    }


def _rim(axis: Vector3, half_angle: float) -> Array:
    """Points (n, 3) at ``half_angle`` from ``axis``, at distance `_RADIUS` of the origin."""
    axis = axis / np.linalg.norm(axis)
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    turn = np.linspace(0.0, 2.0 * math.pi, _EDGES, endpoint=False)[:, None]
    circle = np.cos(turn) * first + np.sin(turn) * second
    return np.asarray(_RADIUS * (math.cos(half_angle) * axis + math.sin(half_angle) * circle))
