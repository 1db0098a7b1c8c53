"""The unit sphere in orthographic projection, with traces of axes and pointing cones.

Drawn by hand on ordinary axes: what lies on the far side is known exactly and is drawn faint, which
a 3-D plotting toolkit that sorts whole objects by depth cannot do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from spacecraft_gnc.drawing.geometry import circle, graticule
from spacecraft_gnc.drawing.style import GRID_COLOR, INK, MUTED
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FAR_ALPHA: Final = 0.28
_POINTS: Final = 240  # of a circle


@dataclass(frozen=True, slots=True)
class View:
    """Direction from which the sphere is seen.

    Parameters
    ----------
    azimuth_deg
        Of the observer, about the inertial z axis from x [deg].
    elevation_deg
        Of the observer above the x-y plane [deg].
    """

    azimuth_deg: float = 35.0
    elevation_deg: float = 24.0

    def project(self, points: Array) -> tuple[Array, Array]:
        """Project (n, 3) inertial points: (n, 2) picture coordinates and (n,) depth.

        The depth is positive on the near side of the sphere.
        """
        azimuth, elevation = math.radians(self.azimuth_deg), math.radians(self.elevation_deg)
        toward = np.array(
            [
                math.cos(elevation) * math.cos(azimuth),
                math.cos(elevation) * math.sin(azimuth),
                math.sin(elevation),
            ]
        )
        right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
        picture = points @ np.column_stack([right, np.cross(toward, right)])
        return picture, points @ toward


def draw_sphere(axes: Axes, view: View) -> None:
    """Draw the outline, a graticule every 30 degrees, and the inertial axes."""
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.set(xlim=(-1.28, 1.28), ylim=(-1.12, 1.24))
    disc = Circle((0.0, 0.0), 1.0, facecolor="#F7F7F7", edgecolor="none", zorder=0.5)
    limb = Circle((0.0, 0.0), 1.0, fill=False, edgecolor=MUTED, linewidth=0.9, zorder=3.2)
    axes.add_patch(disc)
    axes.add_patch(limb)
    for line in graticule(_POINTS):
        draw_curve(axes, view, line, color=GRID_COLOR, linewidth=0.6)
    for axis, name in zip(np.eye(3), "XYZ", strict=True):
        _draw_inertial_axis(axes, view, axis, name)


def _draw_inertial_axis(axes: Axes, view: View, axis: Array, name: str) -> None:
    """Draw the stub of an inertial axis outside the sphere, with its name."""
    (foot, tip, label), depth = view.project(np.outer([1.0, 1.12, 1.23], axis))
    alpha = 1.0 if depth[0] >= 0.0 else 2.0 * FAR_ALPHA
    axes.plot(*zip(foot, tip, strict=True), color=INK, linewidth=0.9, alpha=alpha)
    axes.text(
        label[0], label[1], name, ha="center", va="center", fontsize=9, color=INK, alpha=alpha
    )


def draw_curve(axes: Axes, view: View, points: Array, *, color: str, **style: Any) -> None:
    """Draw a curve on the sphere through (n, 3) points; its far side is faint."""
    picture, depth = view.project(points)
    near = depth >= 0.0
    # Each side keeps the first point beyond the limb, so that the two halves meet.
    beside = np.zeros_like(near)
    beside[1:] |= near[1:] != near[:-1]
    beside[:-1] |= near[1:] != near[:-1]
    for mask, alpha, order in ((~near | beside, FAR_ALPHA, 1.5), (near | beside, 1.0, 3.0)):
        shown = np.where(mask[:, None], picture, math.nan)
        axes.plot(*shown.T, color=color, alpha=alpha, zorder=order, solid_capstyle="round", **style)


def draw_arrow(axes: Axes, view: View, tip: Array, *, color: str, dashed: bool) -> None:
    """Draw an arrow from the center to a point (3,) of the sphere."""
    (picture,), (depth,) = view.project(tip[None])
    axes.annotate(
        "",
        xy=picture,
        xytext=(0.0, 0.0),
        arrowprops={
            "arrowstyle": "-|>,head_width=0.22,head_length=0.42",
            "color": color,
            "linewidth": 1.3,
            "linestyle": (0, (3.5, 2.0)) if dashed else "-",
            "shrinkA": 0.0,
            "shrinkB": 0.0,
            "alpha": 1.0 if depth >= 0.0 else 2.0 * FAR_ALPHA,
        },
        zorder=4.0 if depth >= 0.0 else 1.8,
    )


def draw_cap(axes: Axes, view: View, axis: Array, half_angle: float, *, color: str) -> None:
    """Fill the cap of the sphere within ``half_angle`` [rad] of a unit ``axis`` (3,)."""
    for side, alpha in ((1.0, 0.45), (-1.0, 0.45 * FAR_ALPHA)):
        loops = _cap_outline(view, axis, half_angle, side)
        if loops:
            # Loops of opposite sense leave a hole: the path is filled by its winding number.
            path = Path.make_compound_path(*(Path(loop, closed=True) for loop in loops))
            axes.add_patch(PathPatch(path, facecolor=color, edgecolor="none", alpha=alpha))
    draw_curve(axes, view, circle(axis, half_angle, _POINTS), color=color, linewidth=1.3)


def _cap_outline(view: View, axis: Array, half_angle: float, side: float) -> list[Array]:
    """Return closed loops (m, 2) round a cap's part on one side of the limb.

    Parameters
    ----------
    side
        1 for the near side of the sphere, -1 for the far side.
    """
    border, depth = view.project(circle(axis, half_angle, _POINTS))
    axis_picture = view.project(axis[None])[0][0]
    turn = np.linspace(0.0, 2.0 * math.pi, _POINTS + 1)
    limb = np.column_stack([np.cos(turn), np.sin(turn)])
    inside = limb @ axis_picture >= math.cos(half_angle)
    shown = side * depth >= 0.0
    if shown.all():
        return [limb, _clockwise(border)] if inside.all() else [border]
    if not shown.any():
        return [limb] if inside.all() else []
    arc, edge = _run(border, shown), _run(limb, inside)
    if not len(edge):
        return [arc]
    if np.linalg.norm(arc[-1] - edge[0]) > np.linalg.norm(arc[-1] - edge[-1]):
        edge = edge[::-1]
    return [np.concatenate([arc, edge])]


def _clockwise(loop: Array) -> Array:
    """Return a closed loop (m, 2) in the sense opposite to the limb's."""
    x, y = loop.T
    doubled_area = float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    return loop[::-1] if doubled_area > 0.0 else loop


def _run(loop: Array, mask: NDArray[np.bool_]) -> Array:
    """Return the marked stretch of a closed loop (its last point equals the first), in order."""
    loop, mask = loop[:-1], mask[:-1]
    starts = np.flatnonzero(mask & ~np.roll(mask, 1))
    shift = -int(starts[0]) if starts.size else 0
    return np.asarray(np.roll(loop, shift, axis=0)[np.roll(mask, shift)])
