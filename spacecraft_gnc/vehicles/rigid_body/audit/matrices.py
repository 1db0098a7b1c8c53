"""3 x 3 matrices and vectors, many at once: (..., 3, 3) and (..., 3) arrays."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.types import Array


def trace_minus(X: Array) -> Array:
    """Return tr(X) I - X of (..., 3, 3) matrices."""
    return np.asarray(np.trace(X, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - X)


def vee(X: Array) -> Array:
    """Return the vector (..., 3) of the antisymmetric part of (..., 3, 3) matrices."""
    parts = [X[..., 2, 1] - X[..., 1, 2], X[..., 0, 2] - X[..., 2, 0], X[..., 1, 0] - X[..., 0, 1]]
    return np.asarray(0.5 * np.stack(parts, axis=-1))


def hats(a: Array) -> Array:
    """Return hat(a) (..., 3, 3) of vectors (..., 3)."""
    return np.cross(a[..., None, :], np.eye(3)).swapaxes(-2, -1)


def times(X: Array, a: Array) -> Array:
    """Return X a of (..., 3, 3) matrices and (..., 3) vectors."""
    return np.asarray((X @ a[..., None])[..., 0])


def transposed(X: Array) -> Array:
    """Return X^T of (..., 3, 3) matrices."""
    return X.swapaxes(-2, -1)


def exp(a: Array) -> Array:
    """Return exp(hat(a)) of vectors (m, 3)."""
    angle = np.linalg.norm(a, axis=1)[:, None, None]
    H = hats(a)
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * H
                      + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * H @ H)  # fmt: skip
