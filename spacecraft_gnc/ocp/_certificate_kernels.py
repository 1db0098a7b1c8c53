"""Kernels that say whether a solve has arrived: residual, rounding, gradient of the cost."""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inner_kernel
from spacecraft_gnc._kernels import inlined_kernel, kernel
from spacecraft_gnc.lie._mat3_kernels import dot, load3
from spacecraft_gnc.ocp._data_kernels import ALPHA, D_U, M_U, MADE_OF, MADE_OF_PI, MU0
from spacecraft_gnc.ocp._stage_kernels import SIGMA_AT, Z_AT
from spacecraft_gnc.ocp._track_kernels import control_reference, end_momentum

ROUNDING = 2.0**-52


@kernel
def largest_row(rows, column):
    """Largest norm of the vectors that stand in the rows from a column on."""
    largest = 0.0
    for k in range(rows.shape[0]):
        x = load3(rows, k, column)
        largest = max(largest, dot(x, x))
    return math.sqrt(largest)


@inlined_kernel
def rounding_of(data, track, Pi):
    """What rounding may leave of the conditions, by the size of the terms that lam2 adds up."""
    N = Pi.shape[0] - 1
    first, last, Pi_ref = load3(Pi, 0), load3(Pi, N), end_momentum(track)
    momentum = math.sqrt(dot(first, first) + dot(last, last) + dot(Pi_ref, Pi_ref))
    return ROUNDING * N * (data[MADE_OF] + data[MADE_OF_PI] * momentum)


@inner_kernel
def is_stationary(data, track, lam, W, left):
    """Whether the torques of W make the cost stationary but for ``left`` of the multipliers.

    The gradient is formed anew, from the torques alone: (S3 + 2 mu0 max(0, |u|^2 - alpha)) u minus
    S3 u_ref and B^T lam2. Rounding of |u|^2 enters it times 2 mu0; a hard limit is held to that
    rounding.
    """
    m, alpha, mu0 = int(data[M_U]), data[ALPHA], data[MU0]
    hard, gains, fed = math.isinf(mu0), 0.0, 0.0
    for i in range(m):
        g, pull = D_U + m + 3 * i, data[D_U + i] * control_reference(track, m, i)
        fed += pull * pull
        gains += data[g] * data[g] + data[g + 1] * data[g + 1] + data[g + 2] * data[g + 2]
    bound = math.sqrt(gains) * (2.0 * left + 32.0 * ROUNDING * largest_row(lam, 3))
    bound += 32.0 * ROUNDING * math.sqrt(fed)
    for k in range(lam.shape[0]):
        l2, zz, ee, sigma, allowed = load3(lam, k, 3), 0.0, 0.0, 0.0, 0.0
        for i in range(m):
            zz += W[k, Z_AT + i] * W[k, Z_AT + i]
        if alpha > 0.0 and hard:
            sigma = W[k, SIGMA_AT]
            if zz > alpha * (1.0 + 8.0 * ROUNDING) or (sigma > 0.0 and zz < alpha * (1.0 - 1e-9)):
                return False
        elif alpha > 0.0 and zz > alpha * (1.0 - 8.0 * ROUNDING):
            sigma = max(0.0, 2.0 * mu0 * (zz - alpha))
            allowed = 32.0 * ROUNDING * mu0 * zz * math.sqrt(zz)
        for i in range(m):
            g = D_U + m + 3 * i
            pull = data[g] * l2[0] + data[g + 1] * l2[1] + data[g + 2] * l2[2]
            e = (data[D_U + i] + sigma) * W[k, Z_AT + i]
            e -= data[D_U + i] * control_reference(track, m, i)
            e -= pull
            ee += e * e
        if not ee <= (bound + allowed) * (bound + allowed):
            return False
    return True
