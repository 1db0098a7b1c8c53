"""Pointing zones as markers for 3-D viewers."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from spacecraft_gnc.ros.cdr import encode
from spacecraft_gnc.ros.topics import INERTIAL_FRAME
from spacecraft_gnc.types import Vector3
from spacecraft_gnc.vehicles.rigid_body.parameters.zones import ZoneParameters

_EDGES = 36  # of the circle at the mouth of a cone
_RADIUS = 1.0  # [m] length of a cone's side
_LINE_WIDTH = 0.01  # [m]
_COLORS = {
    "exclusion": ColorRGBA(r=0.9, g=0.2, b=0.1, a=1.0),
    "inclusion": ColorRGBA(r=0.1, g=0.7, b=0.3, a=1.0),
}


def encode_zone_markers(zones: Sequence[ZoneParameters]) -> bytes:
    """Serialize a MarkerArray with the cone of each zone: its rim and its sides."""
    markers = [_cone(i, zone) for i, zone in enumerate(zones)]
    return encode(MarkerArray(markers=markers))


def _cone(number: int, zone: ZoneParameters) -> Marker:
    marker = Marker(
        header=Header(frame_id=INERTIAL_FRAME),
        ns=f"zone/{zone.name}",
        id=number,
        type=Marker.LINE_LIST,
        action=Marker.ADD,
        color=_COLORS[zone.kind],
        frame_locked=True,
    )
    marker.scale.x = _LINE_WIDTH
    rim = [_point(v) for v in _rim(zone.inertial_axis, math.radians(zone.half_angle_deg))]
    for i, point in enumerate(rim):
        marker.points += [point, rim[(i + 1) % _EDGES], Point(), point]
    return marker


def _rim(axis: Vector3, half_angle: float) -> np.ndarray:
    """Points (n, 3) at ``half_angle`` from ``axis``, at distance `_RADIUS` of the origin."""
    axis = axis / np.linalg.norm(axis)
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    turn = np.linspace(0.0, 2.0 * math.pi, _EDGES, endpoint=False)[:, None]
    circle = np.cos(turn) * first + np.sin(turn) * second
    return np.asarray(_RADIUS * (math.cos(half_angle) * axis + math.sin(half_angle) * circle))


def _point(vector: Vector3) -> Point:
    x, y, z = vector.tolist()
    return Point(x=x, y=y, z=z)
