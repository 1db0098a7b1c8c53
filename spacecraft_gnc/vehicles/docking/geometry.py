"""Cuboids of chief and deputy, and the two constraints between them."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import product
from typing import Final

import numpy as np

from spacecraft_gnc.arguments import as_real
from spacecraft_gnc.arrays import listed
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array, ArrayLike, Vector3, as_vector3, read_only

SURFACE_TOLERANCE: Final = 1e-9  # [m] of a port from the surface; rounding of what files hold
_CORNERS: Final = np.array(list(product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True, slots=True, eq=False)
class Cuboid:
    """A body: a cuboid about its center of mass, along its axes, with a docking port.

    Attributes
    ----------
    size : (3,) array
        Edges [m].
    port : (3,) array
        Docking port, body frame [m].

    Raises
    ------
    ShapeError, ParameterError
        If an edge is not positive, or an array is not three finite numbers.
    """

    size: Vector3
    port: Vector3
    vertices: Array = field(init=False, repr=False)
    """(8, 3) body frame [m]."""

    def __post_init__(self) -> None:
        size = as_vector3("size", self.size)
        if size.min() <= 0.0:
            raise ParameterError(
                f"size: received {listed(size)} m; required three positive edges; give the length "
                "of each"
            )
        object.__setattr__(self, "size", size)
        object.__setattr__(self, "port", as_vector3("port", self.port))
        object.__setattr__(self, "vertices", read_only(0.5 * size * _CORNERS))

    @property
    def port_depth(self) -> float:
        """How far the port lies below the surface [m]: zero on it, negative outside."""
        return float((0.5 * self.size - np.abs(self.port)).min())

    @property
    def has_port_on_surface(self) -> bool:
        """Whether the port lies on the surface, to `SURFACE_TOLERANCE`."""
        return abs(self.port_depth) <= SURFACE_TOLERANCE

    @property
    def has_port_on_front(self) -> bool:
        """Whether the port lies on the face +x, as that of the chief has to."""
        on_plane = abs(self.port[0] - 0.5 * self.size[0]) <= SURFACE_TOLERANCE
        return bool(on_plane and self.has_port_on_surface)

    def inertia(self, mass: float) -> Array:
        """Return the inertia (3, 3) of this cuboid with constant density [kg m^2]."""
        mass = as_real("mass", mass, lambda x: x > 0.0, "a positive mass [kg]", "give 130.0")
        squares = self.size**2
        return np.diag(mass / 12.0 * (squares.sum() - squares))


def deputy_center(
    chief_port: Array, deputy_port: Array, port_offset: Array, attitude: Array
) -> Array:
    """Return the center of mass (..., 3) of the deputy relative to the chief's, chief frame [m]."""
    return np.asarray(chief_port + port_offset - attitude @ deputy_port)


def line_of_sight_margin(port_offset: ArrayLike, tangent: float, slack: float) -> Array:
    """Return the distance of the deputy's port from the sides of the pyramid along y or z [m].

    The least of ``tangent rho_x + slack - abs(rho_y)`` and the same with z: positive inside.

    Parameters
    ----------
    port_offset : (..., 3) array
        Deputy port minus chief port, chief frame [m].
    tangent : float
        Of the half angle of the pyramid about +x.
    slack : float
        By how much it is wider on each side [m].

    Returns
    -------
    (...) array
    """
    rho = np.asarray(port_offset, dtype=np.float64)
    width = tangent * rho[..., 0] + slack
    return np.asarray(width - np.abs(rho[..., 1:]).max(axis=-1))


def clearance(port_offset: ArrayLike, attitude: ArrayLike, deputy: Cuboid, chief: Cuboid) -> Array:
    """Return the distance of the deputy from the plane of the chief's docking face [m].

    The least x of its eight vertices less that of the face +x of the chief, chief frame: negative
    where a vertex has passed the plane.

    Parameters
    ----------
    port_offset : (..., 3) array
        Deputy port minus chief port, chief frame [m].
    attitude : (..., 3, 3) array
        Rotation, deputy to chief.
    deputy, chief : Cuboid
        The two bodies.

    Returns
    -------
    (...) array
    """
    row = np.asarray(attitude, dtype=np.float64)[..., 0, :]
    center = np.asarray(port_offset, dtype=np.float64)[..., 0] - row @ deputy.port
    front = 0.5 * chief.size[0] - chief.port[0]  # of the face beyond the port
    return np.asarray(center - np.abs(row) @ (0.5 * deputy.size) - front)
