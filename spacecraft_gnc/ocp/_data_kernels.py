"""Where the numbers of a problem stand in ``data``, as `problem` and `terminal_set` pack them.

S = (tr(Q) I - Q)/2 turns |Q^(1/2) hat(a)|_F^2 / 2 into a . S a. The m controls are counted in the
eigenvectors V of their weight S3 = V diag(d) V^T: z = V^T u, and torque = G^T z with the rows of
G = V^T B^T. From D_U on stand d (m), G (m x 3), and V^T B^+ (m x 3), which makes z of a torque.

U_UNIT, MADE_OF and MADE_OF_PI scale tolerances only. U_UNIT is the mean eigenvalue of the torque's
sensitivity to lam2, to which Levenberg's term is relative; MADE_OF + MADE_OF_PI |Pi| bounds the sum
of the terms of a lam2, below whose rounding no solve can get.

LOG_FORM is 1 for the cost of Kalabic et al. 2014, (24)-(26), and 0 for that of Gupta et al. 2015,
(27), (28); only the former reads Q_RATE (lambda Q2 / h^2) and P_LOG (6 x 6 weight of (Z, Pi)).
MU0 is infinite for a hard torque limit. PLANT_H is read for moving references only: the step of the
integrator whose momentum is measured.
"""

from __future__ import annotations

from spacecraft_gnc._inner_kernels import inlined_inner_kernel
from spacecraft_gnc._kernels import inlined_kernel
from spacecraft_gnc.lie._mat3_kernels import dot, mat_vec

H, ALPHA, MU0 = 0, 1, 2
Q1, P1, S_Q2, S_P2, LOG_FORM, Q_RATE, P_LOG = 3, 12, 21, 30, 39, 40, 49
U_UNIT, MADE_OF, MADE_OF_PI, PLANT_H, M_U, D_U = 85, 86, 87, 88, 89, 90


@inlined_inner_kernel
def data3(data, i):
    """Three consecutive numbers of ``data``."""
    return (data[i], data[i + 1], data[i + 2])


@inlined_inner_kernel
def data9(data, i):
    """Nine consecutive numbers of ``data``."""
    return (
        data[i], data[i + 1], data[i + 2], data[i + 3], data[i + 4],
        data[i + 5], data[i + 6], data[i + 7], data[i + 8],
    )  # fmt: skip


@inlined_inner_kernel
def log_weight(data, row, column):
    """3 x 3 block of the weight of (Z_N, Pi_N) from a row and a column, 0 or 3 each."""
    i = P_LOG + 6 * row + column
    return (
        data[i], data[i + 1], data[i + 2],
        data[i + 6], data[i + 7], data[i + 8],
        data[i + 12], data[i + 13], data[i + 14],
    )  # fmt: skip


@inlined_kernel
def quadratic(S, x):
    """Value x . S x."""
    return dot(x, mat_vec(S, x))
