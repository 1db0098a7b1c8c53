"""Distances of a pose, and the wrench that holds it on the rotating chief, without kernels.

Everything is in the chief frame, of which the chief's center of mass is the origin.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.docking import geometry
from spacecraft_gnc.vehicles.docking.chief import turns

PHASES: Final = 360
"""Attitudes of the chief in a rotation at which a hold is evaluated."""
_SCANNED: Final = 400
_HALVINGS: Final = 60


class Pose(NamedTuple):
    """Where the deputy is."""

    port_offset: Vector3
    """(3,) deputy port minus chief port [m]."""
    rotation_vector: Vector3
    """(3,) of its attitude, deputy to chief [rad]."""

    @property
    def attitude(self) -> Matrix3:
        """(3, 3) rotation, deputy to chief."""
        return lie.exp(self.rotation_vector)


DOCKED: Final = Pose(np.zeros(3), np.zeros(3))


class Limits(NamedTuple):
    """Bounds that a held deputy may use."""

    force: float
    """[N]"""
    moment: float
    """[N m]"""


def line_of_sight_margin(plant: Any, port_offset: Vector3) -> float:
    """Return by how much the deputy's port is within the line-of-sight pyramid [m]."""
    tangent = math.tan(math.radians(plant.line_of_sight_half_angle_deg))
    return float(geometry.line_of_sight_margin(port_offset, tangent, plant.line_of_sight_slack))


def clearance(plant: Any, pose: Pose) -> float:
    """Return how far the deputy's nearest vertex is from the plane of the docking face [m]."""
    deputy = geometry.Cuboid(plant.deputy_size, plant.deputy_port)
    chief = geometry.Cuboid(plant.chief_size, plant.chief_port)
    return float(geometry.clearance(pose.port_offset, pose.attitude, deputy, chief))


def hold_wrench(plant: Any, pose: Pose, spin_rate: float | None = None) -> Array:
    """Return force and moment (n, 6) that hold the deputy over a rotation of the chief.

    With Omega the inertial rate of the chief and G the gradient of relative gravity:
    F = m (Omega' x r + Omega x (Omega x r) - G r), M = J Omega' + Omega x J Omega.

    Parameters
    ----------
    plant : PlantParameters
    pose : Pose
        Which is held, at rest in the chief frame.
    spin_rate : float, optional
        Instead of the plant's [rad/s].

    Returns
    -------
    (n, 6) array
        About the center of mass [N], [N m], at `PHASES` attitudes, one of a chief that is at rest.

    **Assumptions**: relative gravity is linear (Clohessy and Wiltshire).
    """
    rate = plant.chief_spin_rate if spin_rate is None else spin_rate
    n = plant.mean_motion
    center = geometry.deputy_center(
        plant.chief_port, plant.deputy_port, pose.port_offset, pose.attitude
    )
    inertia = pose.attitude @ plant.inertia @ pose.attitude.T
    axis = plant.chief_spin_axis / np.linalg.norm(plant.chief_spin_axis)
    first = lie.exp(plant.chief_initial_rotation_vector)
    angles = np.linspace(0.0, 2.0 * math.pi, PHASES, endpoint=False) if rate else np.zeros(1)
    chief = turns(axis, angles) @ first
    radial, normal, spin = chief[:, 0], chief[:, 2], rate * (first.T @ axis)
    omega = spin + n * normal
    omega_dot = -np.cross(spin, n * normal)
    gravity = n**2 * (3.0 * (radial @ center)[:, None] * radial - center)
    force = np.cross(omega_dot, center) + np.cross(omega, np.cross(omega, center)) - gravity
    moment = omega_dot @ inertia + np.cross(omega, omega @ inertia)
    if plant.gravity_gradient:
        moment = moment - 3.0 * n**2 * np.cross(radial, radial @ inertia)
    return np.hstack([plant.mass * force, moment])


def use_of(limits: Limits, wrench: Array) -> tuple[float, float]:
    """Return the largest components of force and moment as shares of their limits."""
    largest = np.abs(wrench).max(axis=0)
    parts = (float(largest[:3].max()), limits.force), (float(largest[3:].max()), limits.moment)
    force, moment = (value / limit if limit > 0.0 else math.inf for value, limit in parts)
    return force, moment


def largest_spin_rate(plant: Any, pose: Pose, limits: Limits) -> float | None:
    """Return the largest rate, up to the plant's, at which a pose is held [rad/s].

    None: even a chief that does not rotate in Hill's frame takes more than the limits.
    """

    def holds(rate: float) -> bool:
        return max(use_of(limits, hold_wrench(plant, pose, rate))) <= 1.0

    top = float(plant.chief_spin_rate)
    if holds(top):
        return top
    fails = top
    for rate in np.append(np.geomspace(top, top * 1e-6, _SCANNED)[1:], 0.0).tolist():
        if holds(rate):
            break
        fails = rate
    else:
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (rate + fails)
        rate, fails = (middle, fails) if holds(middle) else (rate, middle)
    return float(rate)
