"""Kernels of the bound on what a body can turn in a time; `certificate` has the derivation."""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel, unlocked_kernel


@inner_kernel
def half_sine_squared(sine):
    """Square of the sine of half the angle, of the sine of the angle up to a quarter turn."""
    return 0.5 * sine * sine / (1.0 + math.sqrt(1.0 - sine * sine))


@inner_kernel
def size(p):
    """Euclidean norm."""
    return math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])


@inner_kernel
def coupling(h, quadratic, spread, p, norm, sine, out):
    """Largest change of each component of the momentum over a step without torque, into ``out``."""
    error = half_sine_squared(sine) * (2.0 + spread) * norm
    for i in range(3):
        total = 0.0
        for j in range(3):
            for k in range(3):
                total += quadratic[i, j, k] * p[j] * p[k]
        out[i] = h * total + error


@unlocked_kernel
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
def corner(h, inverse, axis, a, b, c):
    """Sizes of w . n and w x n, and of w, for the rotation vector w = h J^-1 (a, b, c)."""
    x = h * (inverse[0, 0] * a + inverse[0, 1] * b + inverse[0, 2] * c)
    y = h * (inverse[1, 0] * a + inverse[1, 1] * b + inverse[1, 2] * c)
    z = h * (inverse[2, 0] * a + inverse[2, 1] * b + inverse[2, 2] * c)
    along, square = x * axis[0] + y * axis[1] + z * axis[2], x * x + y * y + z * z
    return abs(along), math.sqrt(max(0.0, square - along * along)), math.sqrt(square)


@unlocked_kernel
def farthest(h, inverse, spread, moment, axis, weights, largest, norms, turned):
    """Add up over the steps the largest |w . n| + c |w x n| for each c of ``weights``, and |w x n|.

    ``w`` is the rotation vector of a step, n the ``axis``; at last the largest |w|. ``turned`` has
    these sums, in this order; each maximum is at a corner of the box of the momentum.
    """
    count, errors = weights.shape[0], 0.0
    turned[:] = 0.0
    for k in range(largest.shape[0]):
        sine = h * norms[k] / moment
        longer = math.asin(sine) / sine if sine > 1e-9 else 1.0 + 1e-9
        errors += longer * half_sine_squared(sine) * spread
        a, b, c = largest[k, 0], largest[k, 1], largest[k, 2]
        n0, x0, w0 = corner(h, inverse, axis, a, b, c)
        n1, x1, w1 = corner(h, inverse, axis, a, -b, c)
        n2, x2, w2 = corner(h, inverse, axis, a, b, -c)
        n3, x3, w3 = corner(h, inverse, axis, a, -b, -c)
        for j in range(count):
            v = weights[j]
            best = max(n0 + v * x0, n1 + v * x1, n2 + v * x2, n3 + v * x3)
            turned[j] += longer * best
        turned[count] += longer * max(x0, x1, x2, x3)
        turned[count + 1] += longer * max(w0, w1, w2, w3)
    for j in range(count + 2):
        v = weights[j] if j < count else 0.0
        turned[j] += math.sqrt(1.0 + v * v) * errors
