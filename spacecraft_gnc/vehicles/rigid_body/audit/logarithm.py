"""Rotation vectors at the end of plans, for the terminal cost of Kalabic et al."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.drawing.representations import quaternions_xyzw
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit.matrices import hats

HALF_TURN: Final = 1e-12  # |w| up to which an attitude counts as half a turn away
SMALL_SQUARE: Final = 0.05  # theta^2 below which the coefficients are summed as series
_SERIES: Final = (1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160, 691 / 1307674368000)


def continuous(C: Array) -> Array:
    """Return rotation vectors (m, 3) of the last of C (m, N+1, 3, 3), of angles continuous along.

    Of the first one the principal vector counts; half a turn away that with the larger positive
    component.
    """
    q = quaternions_xyzw(C.reshape(-1, 3, 3)).reshape(*C.shape[:2], 4)
    turned = np.where(np.einsum("mki,mki->mk", q[:, 1:], q[:, :-1]) < 0.0, -1.0, 1.0)
    w, v = q[:, 0, 3], q[:, 0, :3]
    half = np.where(v.max(axis=1) >= -v.min(axis=1), 1.0, -1.0)
    first = np.where(np.abs(w) > HALF_TURN, np.where(w > 0.0, 1.0, -1.0), half)
    last = q[:, -1] * (first * turned.prod(axis=1))[:, None]
    sine = np.linalg.norm(last[:, :3], axis=1)
    angle = 2.0 * np.arctan2(sine, last[:, 3])
    factor = np.divide(angle, sine, out=np.full(len(sine), 2.0), where=sine > 0.0)
    return np.asarray(factor[:, None] * last[:, :3])


def derivative(Z: Array) -> Array:
    """Return L (m, 3, 3) with delta Z = L eta: I + hat(Z)/2 + c hat(Z)^2."""
    c, _ = _bend(Z)
    H = hats(Z)
    return np.asarray(np.eye(3) + 0.5 * H + c[:, None, None] * (H @ H))


def curvature(Z: Array, y: Array) -> Array:
    """Return the derivative (m, 3, 3) to Z of L(Z)^T y at fixed y."""
    c, slope = _bend(Z)
    n = np.cross(Z, y)
    D = 0.5 * hats(y) - c[:, None, None] * (hats(n) + hats(Z) @ hats(y))
    return np.asarray(D + (slope[:, None] * np.cross(Z, n))[:, :, None] * Z[:, None, :])


def _bend(Z: Array) -> tuple[Array, Array]:
    """Return c = (1 - theta/2 cot(theta/2)) / theta^2 and (dc/dtheta)/theta, (m,) each."""
    t = np.sum(Z * Z, axis=1)
    c = np.polynomial.polynomial.polyval(t, _SERIES)
    steps = [2.0 * i * a for i, a in enumerate(_SERIES)][1:]
    slope = np.polynomial.polynomial.polyval(t, steps)
    large = t >= SMALL_SQUARE
    theta = np.sqrt(t[large])
    half = 0.5 * theta
    cot, sine = np.cos(half) / np.sin(half), np.sin(half)
    c[large] = (1.0 - half * cot) / t[large]
    slope[large] = (-2.0 / theta + 0.5 * cot + 0.25 * theta / sine**2) / (t[large] * theta)
    return c, slope
