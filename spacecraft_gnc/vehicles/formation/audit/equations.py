"""Equations of the formation for an audit, independent of the code that flies.

Hill's equations x' = F x,

    x'' = 3 n^2 x + 2 n y',   y'' = -2 n x',   z'' = -n^2 z,

are solved by the matrix exponential; the gain follows from SciPy's Riccati solution. The exact
motion of two bodies, with J2 where the scenario has it, is integrated by DOP853 in an inertial
frame, z along the axis of the Earth: the chief's state beside the differences of the craft to it,
for all recorded steps at once. Hill's frame is attached to the chief, which feels J2 itself: x
along its radius, z along its momentary angular momentum h; it turns at (r g_z / h, 0, h / r^2),
where g_z is the part along z of the acceleration beside that of a point mass.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm, solve_discrete_are

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.parameters.controller import WeightParameters
from spacecraft_gnc.vehicles.formation.parameters.plant import PlantParameters

EARTH: Final = 3.986004418e14
"""Gravitational parameter [m^3/s^2] (WGS 84)."""
RADIUS: Final = 6378137.0
"""Of the Earth at the equator [m] (WGS 84)."""
J2: Final = 1.08262668e-3
"""Second zonal harmonic of the Earth, unnormalized."""
_RELATIVE: Final = 1e-13


def mean_motion(plant: PlantParameters) -> float:
    """Return the rate of the reference orbit [rad/s]."""
    return math.sqrt(EARTH / (RADIUS + plant.altitude) ** 3)


def samples(plant: PlantParameters, period: float) -> int:
    """Return the control steps of one orbit."""
    return round(2.0 * math.pi / (mean_motion(plant) * period))


def hill_map(n: float, time: float) -> Array:
    """Return exp(F t) (6, 6)."""
    F = np.zeros((6, 6))
    F[:3, 3:] = np.eye(3)
    F[3, 0], F[3, 4], F[4, 3], F[5, 2] = 3.0 * n**2, 2.0 * n, -2.0 * n, -(n**2)
    return np.asarray(expm(F * time))


def ellipse(plant: PlantParameters, angles: Array) -> Array:
    """Return the states (..., 6) of the natural ellipse at angles (...) from its highest point."""
    a, n = plant.radial_semi_axis, mean_motion(plant)
    s, c, none = np.sin(angles), np.cos(angles), np.zeros_like(angles)
    parts = [a * c, -2.0 * a * s, none, -n * a * s, -2.0 * n * a * c, none]
    return np.stack(parts, axis=-1)


def start(plant: PlantParameters, period: float) -> Array:
    """Return the states (n, 6) of the craft at the start."""
    if len(plant.initial_position):
        rows = [np.reshape(v, (-1, 3)) for v in (plant.initial_position, plant.initial_velocity)]
        return np.hstack(rows)
    phase = np.asarray(plant.initial_phase, dtype=np.float64)
    states = ellipse(plant, 2.0 * math.pi / samples(plant, period) * phase)
    states *= np.asarray(plant.initial_amplitude)[:, None]
    states[:, 1] += plant.initial_along_track_offset
    return states


def weights(w: WeightParameters) -> tuple[Array, Array]:
    """Return Q (6, 6) and R (3, 3)."""
    return np.diag(np.repeat([w.position, w.velocity], 3)), w.delta_v * np.eye(3)


def gain(transition: Array, w: WeightParameters) -> Array:
    """Return K (3, 6) of dv = K (x - x_d), with an impulse before the drift of each step."""
    A, B, (Q, R) = transition, transition[:, 3:], weights(w)
    size = R[0, 0]  # the gain depends on ratios alone, and the solver is exact near 1
    P = solve_discrete_are(A, B, Q / size, R / size)
    return np.asarray(-np.linalg.solve(R / size + B.T @ P @ B, B.T @ P @ A))


class Earth:
    """Motion about the Earth in an inertial frame, of the chief and relative to it.

    Parameters
    ----------
    plant : PlantParameters
        With ``motion`` two_body or two_body_j2.
    """

    def __init__(self, plant: PlantParameters) -> None:
        self._j2 = J2 if plant.motion == "two_body_j2" else 0.0
        i, u = np.radians([plant.inclination_deg, plant.argument_of_latitude_deg])
        node = np.array([1.0, 0.0, 0.0])
        across = np.array([0.0, math.cos(i), math.sin(i)])
        radius = RADIUS + plant.altitude
        outward = math.cos(u) * node + math.sin(u) * across
        forward = math.cos(u) * across - math.sin(u) * node
        speed = math.sqrt(EARTH / radius)
        self._start = np.concatenate([radius * outward, speed * forward])

    def _oblateness(self, r: Array) -> Array:
        """Return the acceleration (..., 3) beside that of a point mass."""
        size = np.linalg.norm(r, axis=-1, keepdims=True)
        up = 5.0 * (r[..., 2:] / size) ** 2
        share = np.concatenate([1.0 - up, 1.0 - up, 3.0 - up], axis=-1)
        return np.asarray(-1.5 * self._j2 * EARTH * RADIUS**2 / size**5 * share * r)

    def _acceleration(self, r: Array) -> Array:
        size = np.linalg.norm(r, axis=-1, keepdims=True)
        return np.asarray(-EARTH * r / size**3 + self._oblateness(r))

    def chiefs(self, times: Array) -> Array:
        """Return the states of the chief (m, 6) at ascending times (m,)."""

        def slope(_: float, y: Array) -> Array:
            return np.concatenate([y[3:], self._acceleration(y[:3])])

        if times[-1] == 0.0:
            return np.tile(self._start, (len(times), 1))
        span = (0.0, float(times[-1]))
        options = {"method": "DOP853", "rtol": _RELATIVE, "atol": 1e-9}
        found = solve_ivp(slope, span, self._start, t_eval=times, **options)
        return np.asarray(found.y.T)

    def advanced(self, chiefs: Array, states: Array, time: float) -> Array:
        """Return states (m, n, 6) in Hill's frame a time later, of craft beside chiefs (m, 6)."""
        rows = np.concatenate([chiefs[:, None], self._to_inertial(chiefs, states)], axis=1)
        shape = rows.shape

        def slope(_: float, y: Array) -> Array:
            now = y.reshape(shape)
            pull = self._acceleration(now[:, :1, :3])
            apart = self._acceleration(now[:, :1, :3] + now[:, 1:, :3]) - pull
            bend = np.concatenate([pull, apart], axis=1)
            return np.concatenate([now[..., 3:], bend], axis=-1).ravel()

        sizes = np.broadcast_to(np.where(np.arange(shape[1]) == 0, 1e-7, 1e-12)[:, None], shape)
        options = {"method": "DOP853", "rtol": _RELATIVE, "atol": sizes.ravel()}
        end = solve_ivp(slope, (0.0, time), rows.ravel(), **options).y[:, -1].reshape(shape)
        return self._to_hill(end[:, 0], end[:, 1:])

    def _frame(self, chiefs: Array) -> tuple[Array, Array]:
        """Return the axes of Hill's frame (m, 3, 3) as rows, and its rate (m, 1, 3) in it."""
        R, V = chiefs[:, :3], chiefs[:, 3:]
        h = np.cross(R, V)
        r, turn = np.linalg.norm(R, axis=1), np.linalg.norm(h, axis=1)
        x, z = R / r[:, None], h / turn[:, None]
        axes = np.stack([x, np.cross(z, x), z], axis=1)
        pull = np.sum(z * self._oblateness(R), axis=1)
        rate = np.stack([r * pull / turn, np.zeros_like(r), turn / r**2], axis=1)
        return axes, rate[:, None]

    def _to_inertial(self, chiefs: Array, states: Array) -> Array:
        axes, rate = self._frame(chiefs)
        place, drift = states[..., :3], states[..., 3:]
        drift = drift + np.cross(rate, place)
        return np.concatenate([place @ axes, drift @ axes], axis=-1)

    def _to_hill(self, chiefs: Array, states: Array) -> Array:
        axes, rate = self._frame(chiefs)
        back = axes.transpose(0, 2, 1)
        place, drift = states[..., :3] @ back, states[..., 3:] @ back
        return np.concatenate([place, drift - np.cross(rate, place)], axis=-1)
