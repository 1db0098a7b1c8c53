"""Equations of motion for many steps at once, in the chief frame, independent of the plant's code.

With r = c + rho - R p the position of the deputy's center of mass, Omega the inertial rate of the
chief and W = w + Omega that of the deputy, all in the chief frame C,

    r'' = g(r) + F/m - 2 Omega x r' - Omega' x r - Omega x (Omega x r),
    rho'' = r'' + w' x R p + w x (w x R p),   R' = hat(w) R,
    w' = J_C^-1 (M - W x J_C W) - Omega' - Omega x w,   J_C = R J R^T,

integrated by DOP853. The plant integrates in a frame that stands still, by another method. Every
function takes complex numbers, too, so that derivatives follow from imaginary steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array, Matrix3, Vector3
from spacecraft_gnc.vehicles.docking.parameters.plant import PlantParameters

EARTH: Final = 3.986004418e14
"""Gravitational parameter [m^3/s^2] (IERS Conventions 2010)."""
OFFSET, VELOCITY, ATTITUDE, RATE = slice(0, 3), slice(3, 6), slice(6, 15), slice(15, 18)
"""Columns of a row of states."""
_RELATIVE, _ABSOLUTE = 1e-12, 1e-14
_NODES, _SHARES = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Equations:
    """Bodies and orbit of a scenario."""

    mass: float
    inertia: Matrix3
    deputy_port: Vector3
    chief_port: Vector3
    mean_motion: float
    spin: Vector3
    """Angular velocity of the chief in Hill's frame [rad/s]."""
    first: Matrix3
    """Attitude of the chief at time zero, chief to Hill."""
    two_body: bool
    gravity_gradient: bool

    @classmethod
    def of(
        cls, plant: PlantParameters, mass: float | None = None, inertia: Matrix3 | None = None
    ) -> Equations:
        """Return those of a section ``plant``, maybe with what a law believes of the deputy."""
        axis = np.asarray(plant.chief_spin_axis, dtype=np.float64)
        first = plant.chief_initial_rotation_vector
        angle = np.linalg.norm(first)
        return cls(
            mass=plant.mass if mass is None else mass,
            inertia=np.reshape(plant.inertia if inertia is None else inertia, (3, 3)),
            deputy_port=plant.deputy_port,
            chief_port=plant.chief_port,
            mean_motion=plant.mean_motion,
            spin=plant.chief_spin_rate * axis / np.linalg.norm(axis),
            first=turns(first / (angle or 1.0), np.array([angle]))[0],
            two_body=plant.two_body,
            gravity_gradient=plant.gravity_gradient,
        )

    def chief_attitudes(self, times: Array) -> Array:
        """Return the attitudes (n, 3, 3) of the chief, chief to Hill."""
        rate = float(np.linalg.norm(self.spin))
        return np.asarray(turns(self.spin / (rate or 1.0), rate * times) @ self.first)

    def chief_rates(self, times: Array) -> tuple[Array, Array, Array]:
        """Return Omega, Omega' and the direction away from the Earth (n, 3), chief frame."""
        to_chief = self.chief_attitudes(times).transpose(0, 2, 1)
        orbit = np.array([0.0, 0.0, self.mean_motion])
        turning = -(to_chief @ np.cross(self.spin, orbit))
        return to_chief @ (self.spin + orbit), turning, to_chief[..., 0]

    def gravity(self, outward: Array, r: Any) -> Any:
        """Return the attraction (n, 3) at r less that at the chief [m/s^2]."""
        n = self.mean_motion
        if not self.two_body:
            return n**2 * (3.0 * np.sum(outward * r, axis=1, keepdims=True) * outward - r)
        radius = (EARTH / n**2) ** (1.0 / 3.0)
        there = radius * outward + r
        distance = np.sqrt(np.sum(there * there, axis=1, keepdims=True))
        return n**2 * (radius * outward - there * (radius / distance) ** 3)

    def gradient(self, outward: Array, inertia: Any) -> Any:
        """Return the torque (n, 3) of the gravity gradient, with inertias in the chief frame."""
        along = np.einsum("nij,nj->ni", inertia, outward)
        return 3.0 * self.mean_motion**2 * cross(outward, along)

    def slopes(
        self, times: Array, y: Any, wrench: Any, thrusters: NDArray[np.bool_] | None = None
    ) -> Any:
        """Return the rates of change of rows (n, 18) under wrenches (n, 6), chief frame."""
        omega, turning, outward = self.chief_rates(times)
        rho, velocity, w = y[:, OFFSET], y[:, VELOCITY], y[:, RATE]
        R = y[:, ATTITUDE].reshape(-1, 3, 3)
        force = wrench[:, :3] if thrusters is None else left(wrench[:, :3], R, thrusters)
        inertia = R @ self.inertia @ R.transpose(0, 2, 1)
        arm = R @ self.deputy_port
        r, drift = self.chief_port + rho - arm, velocity - cross(w, arm)
        total = w + omega
        moment = wrench[:, 3:] + (self.gradient(outward, inertia) if self.gravity_gradient else 0.0)
        moment = moment - cross(total, np.einsum("nij,nj->ni", inertia, total))
        spun = np.linalg.solve(inertia, moment[..., None])[..., 0] - turning - cross(omega, w)
        pull = self.gravity(outward, r) + force / self.mass - 2.0 * cross(omega, drift)
        pull = pull - cross(turning, r) - cross(omega, cross(omega, r))
        out = np.empty_like(y)
        out[:, OFFSET] = velocity
        out[:, VELOCITY] = pull + cross(spun, arm) + cross(w, cross(w, arm))
        turned = cross(w[:, None, :], R.transpose(0, 2, 1))
        out[:, ATTITUDE] = turned.transpose(0, 2, 1).reshape(-1, 9)
        out[:, RATE] = spun
        return out

    def advanced(
        self,
        times: Array,
        y: Any,
        wrench: Any,
        period: float,
        thrusters: NDArray[np.bool_] | None = None,
    ) -> Any:
        """Return the rows (n, 18) a period later, with wrenches (n, 6) held in the chief frame.

        ``wrench`` may be a function of the time since then, too.
        """
        from scipy.integrate import solve_ivp

        held = wrench if callable(wrench) else lambda _: wrench

        def slope(s: float, flat: Any) -> Any:
            rows = flat.reshape(-1, 18)
            return self.slopes(times + s, rows, held(s), thrusters).ravel()

        found = solve_ivp(
            slope, (0.0, period), np.ravel(y), "DOP853", t_eval=[period], first_step=period,
            rtol=_RELATIVE, atol=_ABSOLUTE,
        )  # fmt: skip
        return found.y[:, -1].reshape(-1, 18)

    def holding(self, times: Array, v: Any) -> Any:
        """Return the wrenches (n, 6) that hold port offsets and rotation vectors v (n, 6)."""
        y = at_rest(v)
        zero = np.zeros_like(v)
        push = -self.slopes(times, y, zero)
        R = y[:, ATTITUDE].reshape(-1, 3, 3)
        inertia = R @ self.inertia @ R.transpose(0, 2, 1)
        # A moment turns the port about the center of mass, too: that acceleration is no force's.
        push[:, VELOCITY] = push[:, VELOCITY] - cross(push[:, RATE], R @ self.deputy_port)
        moment = np.einsum("nij,nj->ni", inertia, push[:, RATE])
        return np.concatenate([self.mass * push[:, VELOCITY], moment], axis=1)

    def mean_holding(self, times: Array, v: Any, period: float) -> Any:
        """Return their means (n, 6) over the period that starts at each time."""
        return sum(
            0.5 * share * self.holding(times + 0.5 * period * (1.0 + node), v)
            for node, share in zip(_NODES, _SHARES, strict=True)
        )


def cross(a: Any, b: Any) -> Any:
    """Return the vector products (..., 3): NumPy's own spends its time on the shapes."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)


def at_rest(v: Any) -> Any:
    """Return rows (n, 18) at rest at port offsets and rotation vectors v (n, 6)."""
    rows = np.zeros((len(v), 18), dtype=np.result_type(v, float))
    rows[:, OFFSET] = v[:, :3]
    rows[:, ATTITUDE] = rotations(v[:, 3:]).reshape(-1, 9)
    return rows


def left(force: Any, R: Any, thrusters: NDArray[np.bool_]) -> Any:
    """Return forces (n, 3) without their components in lost directions (n, 6) of the deputy."""
    components = np.einsum("nji,nj->ni", R, force)
    lost = np.where(components > 0.0, ~thrusters[:, :3], ~thrusters[:, 3:])
    return np.einsum("nij,nj->ni", R, np.where(lost, 0.0, components))


def turns(axis: Array, angles: Array) -> Array:
    """Return the rotations (n, 3, 3) by angles (n,) about a unit vector, or about none."""
    hat = np.cross(np.eye(3), axis)
    sine, cosine = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.asarray(np.eye(3) + sine * hat + (1.0 - cosine) * (hat @ hat))


def rotations(u: Any) -> Any:
    """Return the rotations exp(hat(u)) (n, 3, 3) of vectors (n, 3), complex ones included."""
    squared = np.sum(u * u, axis=1)[:, None, None]
    is_small = np.abs(squared) < 1e-4
    angle = np.sqrt(np.where(is_small, 1.0, squared))
    series = 1.0 - squared / 6.0 + squared**2 / 120.0 - squared**3 / 5040.0
    first = np.where(is_small, series, np.sin(angle) / angle)
    series = 0.5 - squared / 24.0 + squared**2 / 720.0 - squared**3 / 40320.0
    second = np.where(is_small, series, (1.0 - np.cos(angle)) / angle**2)
    hat = np.cross(u[:, None, :], np.eye(3)).transpose(0, 2, 1)
    return np.eye(3) + first * hat + second * (hat @ hat)


def small_vectors(R: Any) -> Any:
    """Return the vectors (n, 3) of rotations (n, 3, 3) of a few degrees, complex ones included."""
    sine = 0.5 * np.stack(
        [R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1
    )
    squared = np.sum(sine * sine, axis=1, keepdims=True)
    return sine * (1.0 + squared / 6.0 + 3.0 / 40.0 * squared**2 + 5.0 / 112.0 * squared**3)
