"""Problem of two wheels written out once more for the audit: roll-out, cost and derivatives.

Everything takes arrays (b, ...) of plans, which may be complex: derivatives come from imaginary
steps, exact to rounding. Nothing of ``ocp`` is used.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated import weights_of

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario

LARGEST_TURN: Final = 0.3
"""[rad] of the bus in a step by one wheel, beyond which nothing is planned."""
STEP: Final = 1e-20
"""Imaginary step."""
_SUBSTEPS: Final = 16  # of the Runge-Kutta method in a control step
_SERIES: Final = 1e-3  # squared angle below which sin(x)/x is summed as a series
_NODES, _SHARES = (0.5 * np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0]) + 0.5, np.array([5, 8, 5]) / 18)


@dataclass(frozen=True, slots=True, eq=False)
class WheelProblem:
    """Two wheels of a scenario, as its controller believes them."""

    frame: Matrix3
    """(3, 3) columns: along the rate that the first wheel gives, in the plane of both, normal."""
    rates: Array
    """(3, 2) rate in that frame per wheel speed."""
    period: float
    weights: Array
    """(3,) of the attitude."""
    speed_weight: float
    acceleration_weight: float
    terminal_weight: float
    max_speed: float
    """At most what turns the bus by `LARGEST_TURN` in a period."""
    max_acceleration: float
    """0: none."""

    @classmethod
    def of(cls, scenario: Scenario, planned: NDArray[np.bool_], model: str) -> WheelProblem:
        """Return that of a scenario's section ``nmpc_controller`` and two of its wheels."""
        c = scenario.controller
        axes = c.wheel_axes[:, planned]
        wheels = axes / np.linalg.norm(axes, axis=0) * c.wheel_inertias[planned]
        turned = np.linalg.inv(c.inertia) @ wheels
        normal = np.cross(turned[:, 0], turned[:, 1])
        e1, e3 = (v / np.linalg.norm(v) for v in (turned[:, 0], normal))
        frame = np.column_stack([e1, np.cross(e3, e1), e3])
        top = LARGEST_TURN / scenario.period / float(np.linalg.norm(turned, axis=0).max())
        return cls(
            frame,
            -frame.T @ turned,
            scenario.period,
            weights_of(model, c.attitude_weights),
            c.speed_weight,
            c.acceleration_weight,
            c.terminal_weight,
            min(c.max_wheel_speed or top, top),
            c.max_wheel_acceleration,
        )

    def speeds(self, start: Array, u: Any) -> Any:
        """Return wheel speeds (b, N+1, 2) under accelerations (b, N, 2)."""
        first = np.broadcast_to(start, (len(u), 1, 2))
        return np.concatenate([first, start + self.period * np.cumsum(u, axis=1)], axis=1)

    def errors(self, model: str, first: Array, drift: Array, speeds: Any) -> Any:
        """Return coordinates (b, N+1, 3) of the attitude off the end that is wanted.

        ``first`` (3, 3) is the error at the start, ``drift`` (N+1, 3) the rate that other wheels
        give, both in the prediction frame.
        """
        w = speeds @ self.rates.T + drift
        if model == "simplified":
            return _small_angles(angles_of(_quaternion(first)), w, self.period)
        q = _turned(_quaternion(first), w, self.period)
        return 2.0 * q[..., 1:] if model == "so3" else angles_of(q)

    def cost(self, errors: Any, speeds: Any, u: Any, soft: bool) -> Any:
        """Return costs (b,) of plans."""
        total = np.sum(self.weights * errors[:, :-1] ** 2, axis=(1, 2))
        total = total + self.speed_weight * np.sum(speeds[:, :-1] ** 2, axis=(1, 2))
        total = total + self.acceleration_weight * np.sum(u**2, axis=(1, 2))
        end = self.terminal_weight * np.sum(errors[:, -1] ** 2, axis=1)
        return total + end if soft else total


def angles_of(q: Any) -> Any:
    """Return roll, pitch, yaw (..., 3) of quaternions (..., 4), scalar first."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    sine, cosine = 2.0 * (w * y - x * z), 1.0 - 2.0 * (y * y + z * z)
    along = 2.0 * (x * y + w * z)
    level = np.sqrt(cosine * cosine + along * along)
    roll = _atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return np.stack([roll, _atan2(sine, level), _atan2(along, cosine)], axis=-1)


def _atan2(y: Any, x: Any) -> Any:
    """Return the angle of (x, y), whose parts may have a small imaginary part."""
    angle = np.arctan2(np.real(y), np.real(x))
    if not (np.iscomplexobj(y) or np.iscomplexobj(x)):
        return angle
    size = np.real(x) ** 2 + np.real(y) ** 2
    return angle + 1j * (np.real(x) * np.imag(y) - np.real(y) * np.imag(x)) / size


def _quaternion(rotation: Matrix3) -> Array:
    """Return the unit quaternion (4,), scalar first and not negative, of a rotation."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return np.array([w, x, y, z]) * (1.0 if w >= 0.0 else -1.0)


def _turned(first: Array, w: Any, period: float) -> Any:
    """Return quaternions (b, N+1, 4) under rates (b, N+1, 3) that are linear within each step."""
    before, after = w[:, :-1], w[:, 1:]
    omega = 0.5 * period * (before + after) + period**2 / 12.0 * np.cross(before, after)
    squared = np.sum(omega * omega, axis=-1, keepdims=True)
    is_small = np.abs(squared) < _SERIES
    angle = np.sqrt(np.where(is_small, 1.0, squared))
    series = 0.5 - squared / 48.0 + squared**2 / 3840.0 - squared**3 / 645120.0
    half = np.where(is_small, series, np.sin(0.5 * angle) / angle)
    series = 1.0 - squared / 8.0 + squared**2 / 384.0 - squared**3 / 46080.0
    cosine = np.where(is_small, series, np.cos(0.5 * angle))
    step = np.concatenate([cosine, half * omega], axis=-1)
    q = np.empty((*w.shape[:2], 4), dtype=w.dtype)
    q[:, 0] = first
    for k in range(step.shape[1]):
        a, b = q[:, k], step[:, k]
        q[:, k + 1, :1] = a[:, :1] * b[:, :1] - np.sum(a[:, 1:] * b[:, 1:], axis=1, keepdims=True)
        q[:, k + 1, 1:] = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])
    return q


def _small_angles(first: Array, w: Any, period: float) -> Any:
    """Return angles (b, N+1, 3) of phi' = w1, theta' = w2, psi' = w3 + phi w2."""
    before, after = w[:, :-1], w[:, 1:]
    angles = np.empty_like(w)
    angles[:, 0] = first
    gain = 0.5 * period * (before + after)
    angles[:, 1:, :2] = first[:2] + np.cumsum(gain[..., :2], axis=1)
    area = gain[..., 2] + sum(  # Gauss' rule, exact for a polynomial of third degree
        share * period * (before[..., 1] + s * (after - before)[..., 1])
        * (angles[:, :-1, 0] + s * period * (before[..., 0] + 0.5 * s * (after - before)[..., 0]))
        for s, share in zip(_NODES, _SHARES, strict=True)
    )  # fmt: skip
    angles[:, 1:, 2] = first[2] + np.cumsum(area, axis=1)
    return angles


def integrated_turns(before: Array, after: Array, period: float) -> Array:
    """Return the turns (n, 3, 3) of a period with rates (n, 3) that change linearly."""
    turned = np.broadcast_to(np.eye(3), (len(before), 3, 3))
    h = 1.0 / _SUBSTEPS

    def slope(matrix: Array, s: float) -> Array:
        rate = period * (before + s * (after - before))
        rows = np.broadcast_to(rate[:, None, :], matrix.shape)
        return np.asarray(np.cross(matrix, rows))

    for i in range(_SUBSTEPS):
        s = i * h
        k_1 = slope(turned, s)
        k_2 = slope(turned + 0.5 * h * k_1, s + 0.5 * h)
        k_3 = slope(turned + 0.5 * h * k_2, s + 0.5 * h)
        k_4 = slope(turned + h * k_3, s + h)
        turned = turned + h / 6.0 * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4)
    return turned
