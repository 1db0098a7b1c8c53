"""Kernels of the bound on what a body can turn in a time; `certificate` has the derivation."""

from __future__ import annotations

import math

from spacecraft_gnc._kernels import kernel


@kernel
def half_sine_squared(sine):
    """Square of the sine of half the angle, of the sine of the angle up to a quarter turn."""
    return 0.5 * sine * sine / (1.0 + math.sqrt(1.0 - sine * sine))


@kernel
def size(p):
    """Euclidean norm."""
    return math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])


@kernel
def coupling(h, quadratic, spread, p, norm, sine, out):
    """Largest change of each component of the momentum over a step without torque, into ``out``."""
    error = half_sine_squared(sine) * (2.0 + spread) * norm
    for i in range(3):
        total = 0.0
        for j in range(3):
            for k in range(3):
                total += quadratic[i, j, k] * p[j] * p[k]
        out[i] = h * total + error


@kernel
def envelope(h, quadratic, spread, moment, torque, box, ends, work, largest, norms):
    """Bounds of the components |Pi_k| into ``largest`` (N, 3), and of their norm into ``norms``.

    ``ends`` (2, 3): sizes of the first and last momentum. Returns whether no step may turn by a
    quarter or more.
    """
    N = largest.shape[0]
    push = h * size(torque)
    first, last = size(ends[0]), size(ends[1])
    for k in range(N):
        p = largest[k]
        if k == 0:
            p[:] = ends[0]
        norms[k] = min(size(p), last + (N - k) * push)
        if k > 0:
            norms[k] = min(norms[k], first + k * push)
        sine = h * norms[k] / moment
        if not sine < 1.0:
            return False
        coupling(h, quadratic, spread, p, norms[k], sine, work)
        if k + 1 < N:
            for i in range(3):
                largest[k + 1, i] = min(box[i], p[i] + h * torque[i] + work[i])
    for k in range(N - 1, 0, -1):
        p, after = largest[k], ends[1] if k + 1 == N else largest[k + 1]
        coupling(h, quadratic, spread, p, norms[k], h * norms[k] / moment, work)
        for i in range(3):
            p[i] = min(p[i], after[i] + h * torque[i] + work[i])
        norms[k] = min(norms[k], size(p))
    return True


@kernel
def farthest(h, inverse, spread, moment, axis, weights, largest, norms, corners, turned):
    """Add up over the steps the largest |w . n| + c |w x n| for each c of ``weights``, and |w x n|.

    ``w`` is the rotation vector of a step, n the ``axis``; at last the largest |w|. ``turned`` has
    these sums, in this order; each maximum is at a corner of the box of the momentum.
    """
    count = weights.shape[0]
    turned[:] = 0.0
    for k in range(largest.shape[0]):
        sine = h * norms[k] / moment
        longer = math.asin(sine) / sine if sine > 1e-9 else 1.0 + 1e-9
        error = half_sine_squared(sine) * spread
        p = largest[k]
        for corner in range(4):
            b = p[1] if corner % 2 == 0 else -p[1]
            c = p[2] if corner < 2 else -p[2]
            along, square = 0.0, 0.0
            for i in range(3):
                w = h * (inverse[i, 0] * p[0] + inverse[i, 1] * b + inverse[i, 2] * c)
                along += w * axis[i]
                square += w * w
            corners[corner, 0] = abs(along)
            corners[corner, 1] = math.sqrt(max(0.0, square - along * along))
            corners[corner, 2] = math.sqrt(square)
        for j in range(count + 2):
            best = 0.0
            for corner in range(4):
                if j < count:
                    value = corners[corner, 0] + weights[j] * corners[corner, 1]
                else:
                    value = corners[corner, j - count + 1]
                best = max(best, value)
            share = math.sqrt(1.0 + weights[j] * weights[j]) if j < count else 1.0
            turned[j] += longer * (best + share * error)
