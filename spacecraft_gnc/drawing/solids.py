"""Bodies as cuboids with ports, and regions with eight corners: geometry and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array, Matrix3, Vector3

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.drawing.sphere import View

CORNERS: Final = np.array(list(product((-1.0, 1.0), repeat=3)))
"""(8, 3) of a cuboid with half edges of 1; z changes fastest."""
FACES: Final = (
    (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3),
)  # fmt: skip
"""Corners of -x, +x, -y, +y, -z, +z, counterclockwise seen from outside."""
EDGES: Final = tuple((i, i | bit) for bit in (1, 2, 4) for i in range(8) if not i & bit)
_AMBIENT: Final = 0.62  # brightness of a face seen edge on
_EDGE: Final = "#333333"


@dataclass(frozen=True, slots=True)
class Body:
    """A body that moves.

    Attributes
    ----------
    name, color
        How it is called and drawn.
    size
        (3,) edges of the cuboid about its center, along its axes [m].
    port
        (3,) docking port, body frame [m].
    positions, attitudes
        (n + 1, 3) of the center [m] and (n + 1, 3, 3) body to the frame of the view; NaN: unknown.
    """

    name: str
    color: str
    size: Vector3
    port: Vector3
    positions: Array
    attitudes: Array

    def corners(self, row: int) -> Array:
        """Return the corners (8, 3) in a state [m]."""
        return cuboid(self.size, self.positions[row], self.attitudes[row])

    def port_at(self, row: int) -> Vector3:
        """Return the port (3,) in a state [m]."""
        return np.asarray(self.positions[row] + self.attitudes[row] @ self.port)

    def is_known(self, row: int) -> bool:
        """Tell whether a state is known."""
        known = (self.positions[row], self.attitudes[row])
        return all(bool(np.isfinite(part).all()) for part in known)


def cuboid(size: Vector3, center: Vector3, attitude: Matrix3) -> Array:
    """Return the corners (8, 3) of a cuboid about ``center``."""
    return np.asarray(center + 0.5 * size * CORNERS @ attitude.T)


def triangles() -> NDArray[np.int64]:
    """Return the corners (12, 3) of the triangles of the six faces."""
    return np.array([corners for a, b, c, d in FACES for corners in ((a, b, c), (a, c, d))])


def edge_lines(corners: Array) -> Array:
    """Return the twelve edges as one line (36, 3) with gaps, which are NaN."""
    rows = [(corners[a], corners[b], np.full(3, np.nan)) for a, b in EDGES]
    return np.array(rows).reshape(-1, 3)


def draw_bodies(
    axes: Axes, view: View, solids: Sequence[tuple[Array, str]], order: float = 2.5
) -> None:
    """Draw convex solids that do not meet, the far ones first.

    Parameters
    ----------
    solids
        Corners (8, 3) and color of each.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgb

    by_depth = sorted(solids, key=lambda solid: float(view.project(solid[0])[1].mean()))
    for i, (corners, color) in enumerate(by_depth):
        picture, _ = view.project(corners)
        shown, colors = [], []
        for face in FACES:
            facing = _facing(corners[list(face)], view)
            if facing > 0.0:
                brightness = _AMBIENT + (1.0 - _AMBIENT) * facing
                shown.append(picture[list(face)])
                colors.append([brightness * part for part in to_rgb(color)])
        axes.add_collection(
            PolyCollection(
                shown, facecolors=colors, edgecolors=_EDGE, linewidths=0.6, zorder=order + 0.01 * i
            ),
            autolim=False,
        )


def draw_edges(axes: Axes, view: View, corners: Array, **style: Any) -> None:
    """Draw the edges of a solid with corners (8, 3)."""
    picture, _ = view.project(edge_lines(corners))
    axes.plot(*picture.T, **style)


def _facing(face: Array, view: View) -> float:
    """Return the cosine between the normal of a face (4, 3) and the direction to the observer."""
    normal = np.cross(face[1] - face[0], face[2] - face[1])
    size = float(np.linalg.norm(normal))
    return float(view.project(normal[None])[1][0]) / size if size else 0.0


def outline(corners: Array, plane: tuple[int, int]) -> Array:
    """Return the outline (m, 2), closed, of a convex solid seen along the third axis.

    Source: the monotone chain of Andrew (1979).
    """
    points = sorted({(float(x), float(y)) for x, y in corners[:, plane]})
    if len(points) < 3 or not np.isfinite(corners).all():
        return np.empty((0, 2))
    lower, upper = _chain(points), _chain(points[::-1])
    return np.array([*lower[:-1], *upper[:-1], lower[0]])


def _chain(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    chain: list[tuple[float, float]] = []
    for x, y in points:
        while len(chain) >= 2:
            (ax, ay), (bx, by) = chain[-2:]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                break
            chain.pop()
        chain.append((x, y))
    return chain
