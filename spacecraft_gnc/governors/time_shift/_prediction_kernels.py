"""Kernels that predict craft under every shift and test pairs of them; `prediction` documents them.

Arrays: ``path`` (3, samples and instants) natural positions, period by period; ``rows`` (3, 6, r)
and ``pushes`` (3, 6, N) what an error adds to position and delta-v; ``positions`` (n, p, 3, r).
"""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import kernel, unlocked_kernel

BLOCK = 16  # instants tested between two looks whether any failed
NO_ANGLE = -4.0  # c |c| of a cosine that every angle keeps


@kernel
def spread(rows, e, out):
    """Set out (3, r) = rows . e for a state e (6,)."""
    for c in range(3):
        for q in range(out.shape[1]):
            out[c, q] = rows[c, 0, q] * e[0]
        for j in range(1, 6):
            for q in range(out.shape[1]):
                out[c, q] += rows[c, j, q] * e[j]


@kernel
def largest(out):
    """Largest square of the length of a column (3, r), and the first column that has it."""
    worst, at = -1.0, 0
    for q in range(out.shape[1]):
        size = out[0, q] * out[0, q] + out[1, q] * out[1, q] + out[2, q] * out[2, q]
        if size > worst:
            worst, at = size, q
    return worst, at


@inner_kernel
def quadratic(S, e):
    """Quadratic form e . S e for S (6, 6)."""
    total = 0.0
    for i in range(6):
        row = 0.0
        for j in range(6):
            row += S[i, j] * e[j]
        total += e[i] * row
    return total


@kernel
def predict_craft(k, x, theta, m, natural, path, pushes, rows, S, delta_v, at, cost, positions):
    """Squares of the largest delta-v (p,), their steps, cost (p,) and positions (p, 3, r)."""
    p, r = natural.shape[0], rows.shape[2]
    e, pushed = np.empty(6), np.empty((3, pushes.shape[2]))
    for a in range(p):
        s = (k + theta + a) % p
        for j in range(6):
            e[j] = x[j] - natural[s, j]
        spread(pushes, e, pushed)
        delta_v[a], at[a] = largest(pushed)
        cost[a] = quadratic(S, e)
        spread(rows, e, positions[a])
        for c in range(3):
            for q in range(r):
                positions[a, c, q] += path[c, s * m + q]


@inner_kernel
def keeps_apart(u, w, least):
    """Whether two craft, positions (3, r), keep their distance; ``least`` is its square."""
    failed = 0
    for q in range(u.shape[1]):
        dx, dy, dz = u[0, q] - w[0, q], u[1, q] - w[1, q], u[2, q] - w[2, q]
        failed += dx * dx + dy * dy + dz * dz < least
    return failed == 0


@inner_kernel
def keeps_both(u, w, path, s, z, least, cosine):
    """Whether two craft keep distance and angle; s, z: first columns of ``path`` of each.

    ``cosine`` is c |c| of the limit's cosine c: x |x| grows with x, which saves the root of the
    lengths. Slices start at 0, so that the compiler sees that no index is negative.
    """
    r = u.shape[1]
    for begin in range(0, r, BLOCK):
        end = min(begin + BLOCK, r)
        ux, uy, uz = u[0, begin:end], u[1, begin:end], u[2, begin:end]
        wx, wy, wz = w[0, begin:end], w[1, begin:end], w[2, begin:end]
        sx, sy, sz = path[0, s + begin :], path[1, s + begin :], path[2, s + begin :]
        zx, zy, zz = path[0, z + begin :], path[1, z + begin :], path[2, z + begin :]
        failed = 0
        for q in range(end - begin):
            dx, dy, dz = ux[q] - wx[q], uy[q] - wy[q], uz[q] - wz[q]
            cx, cy, cz = sx[q] - zx[q], sy[q] - zy[q], sz[q] - zz[q]
            d2 = dx * dx + dy * dy + dz * dz
            c2 = cx * cx + cy * cy + cz * cz
            along = dx * cx + dy * cy + dz * cz
            failed += (d2 < least) | (along * abs(along) < cosine * (d2 * c2))
        if failed > 0:
            return False
    return True


@unlocked_kernel
def pair_masks(k, theta, m, natural, path, positions, able, lost, least, cosine, masks):
    """Which shifts of each pair (n, n, p, p), i < j, keep its constraints, of those ``able``."""
    n, p = able.shape
    for i in range(n):
        for j in range(i + 1, n):
            for a in range(p):
                if not able[i, a]:
                    continue
                s = ((k + theta[i] + a) % p) * m
                for b in range(p):
                    if not able[j, b]:
                        continue
                    u, w = positions[i, a], positions[j, b]
                    if lost[i] and lost[j]:
                        masks[i, j, a, b] = True
                    elif lost[i] or lost[j]:
                        masks[i, j, a, b] = keeps_apart(u, w, least)
                    else:
                        z = ((k + theta[j] + b) % p) * m
                        masks[i, j, a, b] = keeps_both(u, w, path, s, z, least, cosine)


@kernel
def extremes(u, w, path, s, z):
    """Least square of the distance and least cosine of the angle of a pair, with their instants."""
    nearest, near_at, cosine, wide_at = np.inf, 0, 2.0, 0
    for q in range(u.shape[1]):
        dx, dy, dz = u[0, q] - w[0, q], u[1, q] - w[1, q], u[2, q] - w[2, q]
        cx = path[0, s + q] - path[0, z + q]
        cy = path[1, s + q] - path[1, z + q]
        cz = path[2, s + q] - path[2, z + q]
        d2 = dx * dx + dy * dy + dz * dz
        size = math.sqrt(d2 * (cx * cx + cy * cy + cz * cz))
        if d2 < nearest:
            nearest, near_at = d2, q
        if size > 0.0:  # else there is no direction
            found = (dx * cx + dy * cy + dz * cz) / size
            if found < cosine:
                cosine, wide_at = found, q
    return nearest, near_at, cosine, wide_at


@unlocked_kernel
def pair_extremes(k, theta, m, natural, path, positions, nearest, near_at, cosine, wide_at):
    """`extremes` of every pair of craft and shifts, each (n, n, p, p), i < j."""
    n, p = positions.shape[0], natural.shape[0]
    for i in range(n):
        for j in range(i + 1, n):
            for a in range(p):
                s = ((k + theta[i] + a) % p) * m
                for b in range(p):
                    z = ((k + theta[j] + b) % p) * m
                    (
                        nearest[i, j, a, b],
                        near_at[i, j, a, b],
                        cosine[i, j, a, b],
                        wide_at[i, j, a, b],
                    ) = extremes(positions[i, a], positions[j, b], path, s, z)


@inner_kernel
def first_failure(u, w, path, s, z, least, cosine, is_drifting):
    """First instant at which a pair fails, the number of instants if it never does.

    Arguments as of `keeps_both`; ``is_drifting``: of the distance alone.
    """
    for q in range(u.shape[1]):
        dx, dy, dz = u[0, q] - w[0, q], u[1, q] - w[1, q], u[2, q] - w[2, q]
        cx = path[0, s + q] - path[0, z + q]
        cy = path[1, s + q] - path[1, z + q]
        cz = path[2, s + q] - path[2, z + q]
        d2 = dx * dx + dy * dy + dz * dz
        along = dx * cx + dy * cy + dz * cz
        c2 = cx * cx + cy * cy + cz * cz
        if d2 < least or (not is_drifting and along * abs(along) < cosine * (d2 * c2)):
            return q
    return u.shape[1]


@unlocked_kernel
def pair_failures(k, theta, m, path, positions, able, lost, least, cosine, until):
    """Set ``until`` (n, n, p, p), i < j, to the `first_failure` of each pair of ``able`` shifts."""
    n, p = able.shape
    for i in range(n):
        for j in range(i + 1, n):
            for a in range(p):
                s = ((k + theta[i] + a) % p) * m
                for b in range(p):
                    if able[i, a] and able[j, b] and not (lost[i] and lost[j]):
                        z = ((k + theta[j] + b) % p) * m
                        until[i, j, a, b] = first_failure(
                            positions[i, a], positions[j, b], path, s, z, least, cosine,
                            lost[i] or lost[j],
                        )  # fmt: skip
