"""Largest time steps with which a momentum can be integrated, in closed form (NumPy only).

A step of the integrator exists if and only if (h hat(Pi))^2 + 4 Jd^2 >= 0, which is
h |hat(Pi) Jd^-1| <= 2 in the spectral norm. Source: Kalabic et al. 2014, (3).
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc.types import Array, Matrix3, Vector3

_SURELY = 1.0 - 1e-9  # rounding decides nothing
_EQUAL = 1e-12  # difference of two moments, relative, up to which they are the same


def is_surely_free(inertia: Matrix3, momentum: Vector3, step: float) -> bool:
    """Tell whether every step [s] of the free body exists, wherever its momentum points.

    h |Pi| < 2 d, with d the smallest eigenvalue of Jd. Where that does not hold, the step may exist
    all the same: `largest_free_step` decides.

    Parameters
    ----------
    inertia : (3, 3) array
        Body frame [kg m^2].
    momentum : (3,) array
        Body frame [N m s].
    step : float
        Time step h [s].
    """
    moments = np.linalg.eigvalsh(inertia)
    smallest = 0.5 * float(moments.sum()) - float(moments[-1])
    return step * math.hypot(*momentum) < 2.0 * smallest * _SURELY


def largest_step(inertia: Matrix3, momentum: Vector3) -> float:
    """Return the largest time step [s] for which a step from this momentum exists.

    Parameters
    ----------
    inertia : (3, 3) array
        Body frame [kg m^2].
    momentum : (3,) array
        Body frame [N m s]; `largest_free_step` covers the subsequent motion.
    """
    size, direction = _size_and_direction(momentum)
    if size == 0.0:
        return math.inf
    nonstandard = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    hat = np.cross(np.eye(3), direction)
    bound = size * float(np.linalg.norm(hat @ np.linalg.inv(nonstandard), 2))
    return 2.0 / bound if bound > 0.0 else math.inf


def largest_free_step(inertia: Matrix3, momentum: Vector3) -> float:
    """Return the largest time step [s] for which every step of the free body exists.

    In the body frame a free momentum keeps its size and its energy Pi . J^-1 Pi / 2, and moves
    along the curve on which both are constant. With x_i = Pi_i^2 along the principal axes, that
    curve is a segment of a straight line, and the condition is linear in x: with the eigenvalues
    d_i of Jd it reads 1 + sum_i x_i / (4 d_i^2 / h^2 - |Pi|^2) <= 0 if one of the denominators is
    negative. It therefore holds on the whole curve if it holds at the two ends of the segment.

    Parameters
    ----------
    inertia : (3, 3) array
        Body frame [kg m^2].
    momentum : (3,) array
        Body frame [N m s].
    """
    size, direction = _size_and_direction(momentum)
    if size == 0.0:
        return math.inf
    moments, axes = np.linalg.eigh(inertia)
    ends = _ends(moments, (axes.T @ direction) ** 2)
    diagonal = np.diag(moments)
    return min(largest_step(diagonal, np.sqrt(x)) for x in ends) / size


def _size_and_direction(momentum: Vector3) -> tuple[float, Vector3]:
    """Scale a momentum by its largest component, so that no square overflows."""
    size = float(np.abs(momentum).max())
    if size == 0.0:
        return 0.0, np.zeros(3)
    scaled = np.asarray(momentum) / size
    length = float(np.linalg.norm(scaled))
    return size * length, scaled / length


def _ends(moments: Vector3, x: Vector3) -> tuple[Array, Array]:
    """Return the ends of the segment x >= 0 on which sum x_i and sum x_i / J_i are constant."""
    inverse = moments[0] / moments
    v = np.cross(np.ones(3), inverse)
    v[np.abs(v) <= _EQUAL] = 0.0  # a body of revolution precesses about its axis
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = -x / v
    first = reach[v > 0.0].max(initial=-math.inf)
    last = reach[v < 0.0].min(initial=math.inf)
    if not v.any():  # a sphere does not move
        return x, x
    return np.maximum(x + first * v, 0.0), np.maximum(x + last * v, 0.0)
