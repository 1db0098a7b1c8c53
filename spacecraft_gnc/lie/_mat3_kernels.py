"""Kernels on 3-vectors and row-major 3x3 matrices held as tuples, and so in registers.

Unlike arrays, tuples are not allocated or aliased. Frames are those of the caller.
"""

from __future__ import annotations

from spacecraft_gnc._inner_kernels import inlined_inner_kernel
from spacecraft_gnc._kernels import inlined_kernel

EYE = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@inlined_inner_kernel
def load3(a, k, i=0):
    """Read three numbers of row ``k`` of a 2-D array, from column ``i``."""
    return (a[k, i], a[k, i + 1], a[k, i + 2])


@inlined_inner_kernel
def store3(a, k, x, i=0):
    """Write three numbers to row ``k`` of a 2-D array, from column ``i``."""
    a[k, i] = x[0]
    a[k, i + 1] = x[1]
    a[k, i + 2] = x[2]


@inlined_inner_kernel
def load9_flat(a, k, i=0):
    """Read a matrix from row ``k`` of a 2-D array, from column ``i``."""
    return (
        a[k, i], a[k, i + 1], a[k, i + 2], a[k, i + 3], a[k, i + 4],
        a[k, i + 5], a[k, i + 6], a[k, i + 7], a[k, i + 8],
    )  # fmt: skip


@inlined_inner_kernel
def store9_flat(a, k, A, i=0):
    """Write a matrix to row ``k`` of a 2-D array, from column ``i``."""
    for j in range(9):
        a[k, i + j] = A[j]


@inlined_inner_kernel
def load9(a, k):
    """Read block ``k`` of an (n, 3, 3) array."""
    return (
        a[k, 0, 0], a[k, 0, 1], a[k, 0, 2],
        a[k, 1, 0], a[k, 1, 1], a[k, 1, 2],
        a[k, 2, 0], a[k, 2, 1], a[k, 2, 2],
    )  # fmt: skip


@inlined_inner_kernel
def load9_rows(a, k):
    """Read rows ``k`` to ``k + 2`` of an (n, 3) array."""
    return (
        a[k, 0], a[k, 1], a[k, 2],
        a[k + 1, 0], a[k + 1, 1], a[k + 1, 2],
        a[k + 2, 0], a[k + 2, 1], a[k + 2, 2],
    )  # fmt: skip


@inlined_inner_kernel
def store9_rows(a, k, A):
    """Write a matrix to rows ``k`` to ``k + 2`` of an (n, 3) array."""
    store3(a, k, (A[0], A[1], A[2]))
    store3(a, k + 1, (A[3], A[4], A[5]))
    store3(a, k + 2, (A[6], A[7], A[8]))


@inlined_inner_kernel
def store9(a, k, A):
    """Write block ``k`` of an (n, 3, 3) array."""
    a[k, 0, 0] = A[0]
    a[k, 0, 1] = A[1]
    a[k, 0, 2] = A[2]
    a[k, 1, 0] = A[3]
    a[k, 1, 1] = A[4]
    a[k, 1, 2] = A[5]
    a[k, 2, 0] = A[6]
    a[k, 2, 1] = A[7]
    a[k, 2, 2] = A[8]


@inlined_kernel
def add(x, y):
    """Sum x + y of two 3-vectors."""
    return (x[0] + y[0], x[1] + y[1], x[2] + y[2])


@inlined_inner_kernel
def sub(x, y):
    """Difference x - y of two 3-vectors."""
    return (x[0] - y[0], x[1] - y[1], x[2] - y[2])


@inlined_inner_kernel
def scale(s, x):
    """Product s x of a number and a 3-vector."""
    return (s * x[0], s * x[1], s * x[2])


@inlined_inner_kernel
def dot(x, y):
    """Inner product of two 3-vectors."""
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


@inlined_inner_kernel
def cross(x, y):
    """Cross product x x y."""
    return (
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    )


@inlined_inner_kernel
def mat_vec(A, x):
    """Product A x."""
    return (
        A[0] * x[0] + A[1] * x[1] + A[2] * x[2],
        A[3] * x[0] + A[4] * x[1] + A[5] * x[2],
        A[6] * x[0] + A[7] * x[1] + A[8] * x[2],
    )


@inlined_inner_kernel
def mat_t_vec(A, x):
    """Product A^T x."""
    return (
        A[0] * x[0] + A[3] * x[1] + A[6] * x[2],
        A[1] * x[0] + A[4] * x[1] + A[7] * x[2],
        A[2] * x[0] + A[5] * x[1] + A[8] * x[2],
    )


@inlined_inner_kernel
def transpose(A):
    """Transpose A^T."""
    return (A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8])


@inlined_inner_kernel
def mat_mat(A, B):
    """Product A B."""
    return (
        A[0] * B[0] + A[1] * B[3] + A[2] * B[6],
        A[0] * B[1] + A[1] * B[4] + A[2] * B[7],
        A[0] * B[2] + A[1] * B[5] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[3] + A[5] * B[6],
        A[3] * B[1] + A[4] * B[4] + A[5] * B[7],
        A[3] * B[2] + A[4] * B[5] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[3] + A[8] * B[6],
        A[6] * B[1] + A[7] * B[4] + A[8] * B[7],
        A[6] * B[2] + A[7] * B[5] + A[8] * B[8],
    )


@inlined_kernel
def mat_t_mat(A, B):
    """Product A^T B."""
    return mat_mat(transpose(A), B)


@inlined_kernel
def mat_add(A, B):
    """Sum A + B."""
    return (
        A[0] + B[0], A[1] + B[1], A[2] + B[2],
        A[3] + B[3], A[4] + B[4], A[5] + B[5],
        A[6] + B[6], A[7] + B[7], A[8] + B[8],
    )  # fmt: skip


@inlined_inner_kernel
def mat_sub(A, B):
    """Difference A - B."""
    return (
        A[0] - B[0], A[1] - B[1], A[2] - B[2],
        A[3] - B[3], A[4] - B[4], A[5] - B[5],
        A[6] - B[6], A[7] - B[7], A[8] - B[8],
    )  # fmt: skip


@inlined_kernel
def mat_scale(s, A):
    """Product s A."""
    return (
        s * A[0], s * A[1], s * A[2],
        s * A[3], s * A[4], s * A[5],
        s * A[6], s * A[7], s * A[8],
    )  # fmt: skip


@inlined_inner_kernel
def outer(x, y):
    """Outer product x y^T."""
    return (
        x[0] * y[0], x[0] * y[1], x[0] * y[2],
        x[1] * y[0], x[1] * y[1], x[1] * y[2],
        x[2] * y[0], x[2] * y[1], x[2] * y[2],
    )  # fmt: skip


@inlined_inner_kernel
def hat(x):
    """Cross-product matrix of x."""
    return (0.0, -x[2], x[1], x[2], 0.0, -x[0], -x[1], x[0], 0.0)


@inlined_inner_kernel
def hat_mat(x, A):
    """Product hat(x) A."""
    return (
        x[1] * A[6] - x[2] * A[3], x[1] * A[7] - x[2] * A[4], x[1] * A[8] - x[2] * A[5],
        x[2] * A[0] - x[0] * A[6], x[2] * A[1] - x[0] * A[7], x[2] * A[2] - x[0] * A[8],
        x[0] * A[3] - x[1] * A[0], x[0] * A[4] - x[1] * A[1], x[0] * A[5] - x[1] * A[2],
    )  # fmt: skip


@inlined_inner_kernel
def vee_antisymmetric(A):
    """Vector of the antisymmetric part (A - A^T)/2."""
    return (0.5 * (A[7] - A[5]), 0.5 * (A[2] - A[6]), 0.5 * (A[3] - A[1]))


@inlined_inner_kernel
def trace_minus(A):
    """Matrix tr(A) I - A, for which hat(x) A + A^T hat(x) = hat((tr(A) I - A) x)."""
    return (
        A[4] + A[8], -A[1], -A[2],
        -A[3], A[0] + A[8], -A[5],
        -A[6], -A[7], A[0] + A[4],
    )  # fmt: skip


@inlined_inner_kernel
def inverse(A):
    """Inverse by cofactors, and the determinant (the caller checks that it is not zero)."""
    c0 = A[4] * A[8] - A[5] * A[7]
    c1 = A[5] * A[6] - A[3] * A[8]
    c2 = A[3] * A[7] - A[4] * A[6]
    det = A[0] * c0 + A[1] * c1 + A[2] * c2
    s = 1.0 / det if det != 0.0 else 0.0
    return (
        s * c0, s * (A[2] * A[7] - A[1] * A[8]), s * (A[1] * A[5] - A[2] * A[4]),
        s * c1, s * (A[0] * A[8] - A[2] * A[6]), s * (A[2] * A[3] - A[0] * A[5]),
        s * c2, s * (A[1] * A[6] - A[0] * A[7]), s * (A[0] * A[4] - A[1] * A[3]),
    ), det  # fmt: skip
