"""Schematic spacecraft (body, telescope, two solar wings) for the center of the sphere."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.collections import PolyCollection

from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.drawing.sphere import View

_BODY = (0.13, 0.10, 0.10)  # half lengths, along the instrument axis first; radius of the sphere: 1
_TUBE = (0.06, 0.13, 0.27)  # radius, and from where to where along the instrument axis
_WING = (0.08, 0.13, 0.46)  # half width, and from where to where across the instrument axis
_SIDES: Final = 10  # of the tube
_BODY_COLOR: Final = (0.80, 0.80, 0.80)
_TUBE_COLOR: Final = (0.35, 0.35, 0.38)
_WING_COLOR: Final = (0.25, 0.36, 0.56)
_AMBIENT: Final = 0.65  # brightness of a face seen edge on
_EDGE: Final = (0.2, 0.2, 0.2)


def draw_spacecraft(axes: Axes, view: View, attitude: Array, instrument: Array) -> None:
    """Draw the spacecraft as it is seen with an attitude.

    Parameters
    ----------
    attitude
        (3, 3) rotation, body to inertial.
    instrument
        (3,) unit vector along which the telescope looks, body frame.
    """
    to_inertial = attitude @ _instrument_frame(instrument)
    shown: list[tuple[float, Array, tuple[float, ...]]] = []
    for corners, color, two_sided in _FACES:
        picture, depth = view.project(corners @ to_inertial.T)
        facing = _facing(picture)
        if facing > 0.0 or two_sided:
            brightness = _AMBIENT + (1.0 - _AMBIENT) * min(abs(facing), 1.0)
            shown.append((depth.mean(), picture, tuple(brightness * c for c in color)))
    shown.sort(key=lambda face: face[0])  # far faces first
    axes.add_collection(
        PolyCollection(
            [picture for _, picture, _ in shown],
            facecolors=[color for _, _, color in shown],
            edgecolors=_EDGE,
            linewidths=0.5,
            zorder=2.5,  # inside the sphere: before its far side, behind its near side
        ),
        autolim=False,
    )


def _instrument_frame(instrument: Array) -> Array:
    """Return (3, 3) axes of the model in the body frame, as columns: instrument, wings, rest."""
    helper = np.eye(3)[int(np.argmin(np.abs(instrument)))]
    wings = np.cross(np.cross(instrument, helper), instrument)
    wings /= np.linalg.norm(wings)
    return np.column_stack([instrument, wings, np.cross(instrument, wings)])


def _facing(picture: Array) -> float:
    """Return the share of a face's area that is seen; negative from behind."""
    (ax, ay), (bx, by) = picture[1] - picture[0], picture[2] - picture[1]
    return float(ax * by - ay * bx) / _FACE_SCALE


_FACE_SCALE: Final = 4.0 * _BODY[0] * _BODY[1]  # area of a side of the body


def _faces() -> list[tuple[Array, tuple[float, float, float], bool]]:
    """Return corners (m, 3), counterclockwise seen from outside, color, and if seen from both."""
    faces = [(corners, _BODY_COLOR, False) for corners in _box(*_BODY)]
    radius, near, far = _TUBE
    angles = np.linspace(0.0, 2.0 * math.pi, _SIDES + 1)
    ring = np.column_stack([np.zeros_like(angles), np.cos(angles), np.sin(angles)]) * radius
    base, rim = (ring + np.array([x, 0.0, 0.0]) for x in (near, far))
    sides = np.stack([base[:-1], base[1:], rim[1:], rim[:-1]], axis=1)
    faces += [(side, _TUBE_COLOR, False) for side in sides]
    faces.append((rim[:-1], (0.1, 0.1, 0.12), False))
    width, root, tip = _WING
    for side in (1.0, -1.0):
        wing = [(-width, root), (width, root), (width, tip), (-width, tip)]
        faces.append((np.array([[x, side * y, 0.0] for x, y in wing]), _WING_COLOR, True))
    return faces


def _box(*half: float) -> list[Array]:
    """Return the six faces (4, 3) of a box, counterclockwise seen from outside."""
    faces = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            second, third = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            square = [(-1, -1), (1, -1), (1, 1), (-1, 1)][:: int(sign)]
            corners = [sign * np.eye(3)[axis] + a * second + b * third for a, b in square]
            faces.append(np.array(corners) * half)
    return faces


_FACES: Final = _faces()
