"""Kernels of the Lie group variational integrator; `rigid_body` documents the equations.

``body`` is the packed inertia of `rigid_body.pack_inertia`: J (9), J^-1 (9), Jd (9), the smallest
eigenvalue of Jd.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc._kernels import inlined_kernel, kernel
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    hat_mat,
    inverse,
    load3,
    load9,
    load9_rows,
    mat_mat,
    mat_vec,
    scale,
    store3,
    store9,
    store9_rows,
    sub,
)

BODY_SIZE = 28
MAX_NEWTON_STEPS = 30
# Newton converges quadratically: after a correction of 1e-10 the error is below rounding.
LAST_CORRECTION_SQUARED = 1e-20


@inlined_inner_kernel
def body_inertia(body):
    """Inertia J of a packed body."""
    return (
        body[0], body[1], body[2], body[3], body[4], body[5], body[6], body[7], body[8],
    )  # fmt: skip


@inlined_inner_kernel
def body_inverse_inertia(body):
    """J^-1 of a packed body."""
    return (
        body[9], body[10], body[11], body[12], body[13], body[14], body[15], body[16], body[17],
    )  # fmt: skip


@inlined_inner_kernel
def body_nonstandard_inertia(body):
    """Jd of a packed body."""
    return (
        body[18], body[19], body[20], body[21], body[22], body[23], body[24], body[25], body[26],
    )  # fmt: skip


@inlined_kernel
def solvable(body, h, Pi):
    """Kalabic (3): whether (h hat(Pi))^2 + 4 Jd^2 >= 0, so that F exists (see `rigid_body`)."""
    a = scale(h, Pi)
    aa = dot(a, a)
    if not aa < math.inf:
        return False
    if aa <= 4.0 * body[27] * body[27]:  # sufficient, and true in all ordinary flight
        return True
    Jd = body_nonstandard_inertia(body)
    # S = 4 Jd^2 + a a^T - |a|^2 I, positive semi-definite iff its pivots are not negative.
    s00 = 4.0 * (Jd[0] * Jd[0] + Jd[1] * Jd[1] + Jd[2] * Jd[2]) + a[0] * a[0] - aa
    s11 = 4.0 * (Jd[3] * Jd[3] + Jd[4] * Jd[4] + Jd[5] * Jd[5]) + a[1] * a[1] - aa
    s22 = 4.0 * (Jd[6] * Jd[6] + Jd[7] * Jd[7] + Jd[8] * Jd[8]) + a[2] * a[2] - aa
    s01 = 4.0 * (Jd[0] * Jd[3] + Jd[1] * Jd[4] + Jd[2] * Jd[5]) + a[0] * a[1]
    s02 = 4.0 * (Jd[0] * Jd[6] + Jd[1] * Jd[7] + Jd[2] * Jd[8]) + a[0] * a[2]
    s12 = 4.0 * (Jd[3] * Jd[6] + Jd[4] * Jd[7] + Jd[5] * Jd[8]) + a[1] * a[2]
    if s00 <= 0.0:
        return False
    d11 = s11 - s01 * s01 / s00
    if d11 <= 0.0:
        return False
    e12 = s12 - s01 * s02 / s00
    return s22 - s02 * s02 / s00 - e12 * e12 / d11 >= 0.0


@inner_kernel
def relative_quaternion(body, h, Pi):
    """Solve 2 q0 J q + 2 q x (J q) = h Pi for the quaternion (q0, q) of F_k; return q0, q, ok."""
    J = body_inertia(body)
    a = scale(h, Pi)
    q = scale(0.5, mat_vec(body_inverse_inertia(body), a))
    q0 = 1.0
    if not solvable(body, h, Pi):
        return q0, q, False
    for _ in range(MAX_NEWTON_STEPS):
        qq = dot(q, q)
        if qq >= 1.0:  # beyond half a turn: return into the unit ball and continue
            q = scale(0.9 / math.sqrt(qq), q)
            qq = dot(q, q)
        q0 = math.sqrt(1.0 - qq)
        Jq = mat_vec(J, q)
        g = sub(scale(2.0, add(scale(q0, Jq), cross(q, Jq))), a)
        # Half the Jacobian: q0 J - (J q) q^T / q0 + hat(q) J - hat(J q).
        K = hat_mat(q, J)
        s = scale(1.0 / q0, Jq)
        H = (
            q0 * J[0] - s[0] * q[0] + K[0],
            q0 * J[1] - s[0] * q[1] + K[1] + Jq[2],
            q0 * J[2] - s[0] * q[2] + K[2] - Jq[1],
            q0 * J[3] - s[1] * q[0] + K[3] - Jq[2],
            q0 * J[4] - s[1] * q[1] + K[4],
            q0 * J[5] - s[1] * q[2] + K[5] + Jq[0],
            q0 * J[6] - s[2] * q[0] + K[6] + Jq[1],
            q0 * J[7] - s[2] * q[1] + K[7] - Jq[0],
            q0 * J[8] - s[2] * q[2] + K[8],
        )
        H_inverse, det = inverse(H)
        if det == 0.0:
            return q0, q, False
        d = scale(-0.5, mat_vec(H_inverse, g))
        q = add(q, d)
        if dot(d, d) <= LAST_CORRECTION_SQUARED:
            qq = dot(q, q)
            return math.sqrt(1.0 - qq), q, qq < 1.0
    return q0, q, False


@inlined_inner_kernel
def rotation_of(q0, q):
    """Rotation F of the unit quaternion (q0, q)."""
    x, y, z = q
    return (
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - q0 * z), 2.0 * (x * z + q0 * y),
        2.0 * (x * y + q0 * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - q0 * x),
        2.0 * (x * z - q0 * y), 2.0 * (y * z + q0 * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


@inlined_inner_kernel
def rotate_back(q0, q, x):
    """F^T x as x plus a small correction: the rounding error is half an ulp of x."""
    t = scale(2.0, cross(q, x))
    return add(x, sub(cross(q, t), scale(q0, t)))


@inlined_inner_kernel
def rotate_rows(q0, q, R):
    """R F, row by row: row^T F = F^T applied to the row as a column."""
    r0 = rotate_back(q0, q, (R[0], R[1], R[2]))
    r1 = rotate_back(q0, q, (R[3], R[4], R[5]))
    r2 = rotate_back(q0, q, (R[6], R[7], R[8]))
    return (r0[0], r0[1], r0[2], r1[0], r1[1], r1[2], r2[0], r2[1], r2[2])


@inlined_inner_kernel
def polished(R):
    """One Newton-Schulz step R (3 I - R^T R)/2: squares the orthogonality error."""
    a = 1.5 - 0.5 * (R[0] * R[0] + R[3] * R[3] + R[6] * R[6])
    b = 1.5 - 0.5 * (R[1] * R[1] + R[4] * R[4] + R[7] * R[7])
    c = 1.5 - 0.5 * (R[2] * R[2] + R[5] * R[5] + R[8] * R[8])
    d = -0.5 * (R[0] * R[1] + R[3] * R[4] + R[6] * R[7])
    e = -0.5 * (R[0] * R[2] + R[3] * R[5] + R[6] * R[8])
    f = -0.5 * (R[1] * R[2] + R[4] * R[5] + R[7] * R[8])
    return mat_mat(R, (a, d, e, d, b, f, e, f, c))


@kernel
def propagate(body, h, attitudes, momenta, torques, n):
    """Fill rows 1..n of attitudes (n+1,3,3), momenta (n+1,3) under torques (n,3) or (1,3)."""
    R = load9(attitudes, 0)
    Pi = load3(momenta, 0)
    held = torques.shape[0] == 1
    for k in range(n):
        q0, q, ok = relative_quaternion(body, h, Pi)
        if not ok:
            return k
        R = polished(rotate_rows(q0, q, R))
        Pi = add(rotate_back(q0, q, Pi), scale(h, load3(torques, 0 if held else k)))
        store9(attitudes, k + 1, R)
        store3(momenta, k + 1, Pi)
    return n


@kernel
def held(body, h, R, Pi, u, n):
    """R, Pi after up to n steps of the held torque u, and the number of steps that exist."""
    for k in range(n):
        q0, q, ok = relative_quaternion(body, h, Pi)
        if not ok:
            return R, Pi, k
        R = polished(rotate_rows(q0, q, R))
        Pi = add(rotate_back(q0, q, Pi), scale(h, u))
    return R, Pi, n


@kernel
def advance(body, h, state, n):
    """Advance ``state`` (5, 3), rows R, Pi, u, in place by n steps of the held torque u."""
    R, Pi, done = held(body, h, load9_rows(state, 0), load3(state, 3), load3(state, 4), n)
    if done == n:
        store9_rows(state, 0, R)
        store3(state, 3, Pi)
    return done
