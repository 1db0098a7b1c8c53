"""Kernels of the audit: steps of the integrator, and plans certified afresh, many in one call.

They share the stage quantities and the costate sweep with the solvers, not Newton's method: what a
plan is worth is worked out from the numbers of the plan alone.
"""

from __future__ import annotations

import math

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    body_nonstandard_inertia,
    held,
    relative_quaternion,
    rotate_back,
    rotate_rows,
)
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    load3,
    load9,
    load9_flat,
    load9_rows,
    mat_t_vec,
    scale,
    store3,
    store9,
)
from spacecraft_gnc.ocp._data_kernels import (
    ALPHA,
    D_U,
    LOG_FORM,
    M_U,
    MU0,
    P1,
    P_LOG,
    Q1,
    Q_RATE,
    S_P2,
    S_Q2,
    H,
    data9,
    log_weight,
)
from spacecraft_gnc.ocp._stage_kernels import M_AT, SIGMA_AT, Z_AT, horizon_cost, squared_control
from spacecraft_gnc.ocp._sweep_kernels import (
    K1_AT,
    K2_AT,
    factorize,
    smallest_pivot,
    store_stage,
    substitute,
    sweep_costates,
)
from spacecraft_gnc.ocp._track_kernels import (
    control_reference,
    end_momentum,
    set_track,
    stage_momentum,
)

STATUS, ATTITUDE_DEFECT, MOMENTUM_DEFECT, RESIDUAL, RADIUS_DEFECT, COST, LARGEST, CURVATURE = range(
    8
)
STATE_ROUNDING = 1e3 * 2.0**-52  # [rad], and relative to the largest momentum of a plan
MULTIPLIER, FIRST_DEFECT, COSTATE, MADE_OF, CORRECTION, NUMBERS = 8, 9, 10, 11, 12, 13
ON_LIMIT = 1e-12
"""Relative distance of |u|^2 from its bound within which the bound counts as touched."""


@kernel
def resume(body, h, substeps, attitudes, momenta, torques, next_attitudes, next_momenta):
    """Advance every state (m) by one control step of its torque; returns the first without one."""
    for i in range(momenta.shape[0]):
        R, Pi, done = held(
            body, h, load9(attitudes, i), load3(momenta, i), load3(torques, i), substeps
        )
        if done != substeps:
            return i
        store9(next_attitudes, i, R)
        store3(next_momenta, i, Pi)
    return momenta.shape[0]


@kernel
def _distance(a, b):
    """Largest difference of two vectors or matrices; infinite where a number is not finite."""
    largest = 0.0
    for i in range(len(a)):
        d = abs(a[i] - b[i])
        largest = max(largest, d) if math.isfinite(d) else math.inf
    return largest


@kernel
def _fill(body, data, R, Pi, u, z, W, numbers):
    """Fill the stages of W from a plan, and compare each of its states with the step before."""
    h, Jd = data[H], body_nonstandard_inertia(body)
    for k in range(z.shape[0]):
        q0, q, ok = relative_quaternion(body, h, load3(Pi, k))
        if not ok:
            return False
        p = rotate_back(q0, q, load3(Pi, k))
        store_stage(h, Jd, W, k, q0, q, p)
        for i in range(z.shape[1]):
            W[k, Z_AT + i] = z[k, i]
        turned = _distance(rotate_rows(q0, q, load9(R, k)), load9(R, k + 1))
        pushed = _distance(add(p, scale(h, load3(u, k))), load3(Pi, k + 1))
        numbers[ATTITUDE_DEFECT] = max(numbers[ATTITUDE_DEFECT], turned)
        at = FIRST_DEFECT if k == 0 else MOMENTUM_DEFECT
        numbers[at] = max(numbers[at], pushed)
    return True


@kernel
def _pull(data, track, lam2, i):
    """Component i of B^T lam2 + S3 u_ref along the eigenvectors of the control weight."""
    m = int(data[M_U])
    g = D_U + m + 3 * i
    pull = data[g] * lam2[0] + data[g + 1] * lam2[1] + data[g + 2] * lam2[2]
    return pull - data[D_U + i] * (0.0 - control_reference(track, m, i))


@kernel
def _conditions(data, track, lam, W, back, left, numbers):
    """Fill ``left`` (N, 3) with what (38) leaves of each stage's lam2; set sigma in W.

    Returns its norm over the horizon.

    sigma is fitted where the limit is touched, since |u|^2 - max_torque^2 of rounded numbers has
    lost it; how far |u| is from what that sigma says is kept apart.
    """
    m, alpha = int(data[M_U]), data[ALPHA]
    total = 0.0
    for k in range(W.shape[0]):
        l2, zz, sigma = load3(lam, k, 3), squared_control(W, k), 0.0
        if alpha > 0.0 and zz >= alpha * (1.0 - ON_LIMIT):
            for i in range(m):
                z = W[k, Z_AT + i]
                sigma += z * (_pull(data, track, l2, i) - data[D_U + i] * z)
            sigma = max(0.0, sigma / zz)
            bound = math.sqrt(alpha + sigma / (2.0 * data[MU0]))
            off = math.sqrt(zz) - bound
            if sigma > 0.0 or off > 0.0:
                numbers[RADIUS_DEFECT] = max(numbers[RADIUS_DEFECT], abs(off))
        W[k, SIGMA_AT] = sigma
        r = (0.0, 0.0, 0.0)
        for i in range(m):
            off = _pull(data, track, l2, i) - (data[D_U + i] + sigma) * W[k, Z_AT + i]
            r = add(r, scale(off, load3(back, i)))
        store3(left, k, r)
        total += dot(r, r)
        numbers[LARGEST] = max(numbers[LARGEST], zz)
        numbers[COSTATE] = max(numbers[COSTATE], math.sqrt(dot(l2, l2)))
    return math.sqrt(total)


@kernel
def _size3(x):
    return math.sqrt(dot(x, x))


@kernel
def _size9(A):
    total = 0.0
    for i in range(9):
        total += A[i] * A[i]
    return math.sqrt(total)


@kernel
def _zones_pull(h, zones, R):
    """Sum the sizes of what the zones that act at R add to lam1."""
    total = 0.0
    for i in range(zones.shape[0]):
        v = (zones[i, 0], zones[i, 1], zones[i, 2])
        a = mat_t_vec(R, (zones[i, 3], zones[i, 4], zones[i, 5]))
        excess = zones[i, 7] * (dot(v, a) - zones[i, 6])
        if excess > 0.0:
            total += h * zones[i, 8] * excess * _size3(cross(v, a))
    return total


@kernel
def _made_of(data, zones, track, R, Pi, W, back):
    """Sum of the sizes of what adds up to lam2 over the horizon, its first step included.

    The scale of its rounding, and of what counts as little of it: near the target, where lam2
    itself vanishes, it does not, for the entries of a rotation are of the order of one.
    """
    N, h = W.shape[0], data[H]
    fastest = 0.0  # a momentum near zero is a difference of larger ones
    for k in range(N + 1):
        fastest = max(fastest, _size3(load3(Pi, k)))
    fastest = max(fastest, _size3(stage_momentum(track, 0)), _size3(end_momentum(track)))
    if data[LOG_FORM] > 0.0:
        push = _size9(data9(data, Q_RATE))
        a1 = 0.5 * (_size9(log_weight(data, 0, 0)) + _size9(log_weight(data, 0, 3)) * fastest)
        a2 = 0.5 * (_size9(log_weight(data, 3, 0)) + _size9(log_weight(data, 3, 3)) * fastest)
    else:
        a1, push = _size9(data9(data, P1)), 0.0
        a2 = _size9(data9(data, S_P2)) * fastest
    turn, spin = h * _size9(data9(data, Q1)), h * _size9(data9(data, S_Q2)) * fastest
    for k in range(N - 1, -1, -1):
        a2 += _size9(load9_flat(W, k, M_AT)) * (a1 + push) + spin
        a1 += turn + _zones_pull(h, zones, load9(R, k))
    fed, m = (0.0, 0.0, 0.0), back.shape[0]
    for i in range(m):
        fed = add(fed, scale(data[D_U + i] * control_reference(track, m, i), load3(back, i)))
    return a2 + _size3(fed)


@kernel
def _multiplier(data, zones, track, R, Pi, W, lam, other, claimed):
    """Multiplier nu of the terminal set from the first costate, linear in it; ``data`` has nu = 0.

    ``lam`` and ``other`` come back as the costates for nu = 0 and 1; ``data`` with (1 + nu) F.
    """
    sweep_costates(data, zones, track, R, Pi, lam, W)
    for i in range(36):
        data[P_LOG + i] *= 2.0
    sweep_costates(data, zones, track, R, Pi, other, W)
    along, square = 0.0, 0.0
    for i in range(6):
        slope = other[0, i] - lam[0, i]
        along += slope * (claimed[i] - lam[0, i])
        square += slope * slope
    nu = along / square if square > 0.0 else 0.0
    for i in range(36):
        data[P_LOG + i] *= 0.5 * (1.0 + nu)
    return nu


@kernel
def _correction(data, fac, left, Pi, step):
    """Largest change of a lam2 by one Newton step from the plan, with its own factorization.

    But for what a change of the state by `STATE_ROUNDING` makes, component by component.
    """
    zero, fastest = (0.0, 0.0, 0.0), 0.0
    substitute(data[H], fac, left, zero, zero, 0.0, step)
    for k in range(Pi.shape[0]):
        fastest = max(fastest, _size3(load3(Pi, k)))
    largest = 0.0
    for k in range(step.shape[0]):
        for i in range(3):
            moved = 0.0
            for j in range(3):
                turned, pushed = fac[k, K1_AT + 3 * i + j], fac[k, K2_AT + 3 * i + j]
                moved += abs(turned) + fastest * abs(pushed)
            largest = max(largest, abs(step[k, i]) - STATE_ROUNDING * moved)
    return largest


@kernel
def certify(
    body, problem, zones, references, attitudes, momenta, torques, controls, costates,
    back, has_set, lam, W, fac, left, track, data, numbers,
):  # fmt: skip
    """Work out afresh what each plan is worth: a row of ``numbers`` (m, NUMBERS) each.

    Plans are (m, N+1, 3, 3), (m, N+1, 3), (m, N, 3) with controls (m, N, n) in the eigenvectors of
    their weight; ``references`` (m, 5, 3) are rows R_ref, omega_ref, tau_ref; ``costates`` (m, 6)
    come in as claimed and go out as found. ``back`` (n, 3) is the pseudo-inverse of G. ``lam`` (2,
    N, 6) and what follows is work space, ``left`` (2, N, 3) among it.
    """
    for j in range(numbers.shape[0]):
        n = numbers[j]
        for i in range(NUMBERS):
            n[i] = 0.0
        for i in range(data.shape[0]):
            data[i] = problem[i]
        R, Pi = attitudes[j], momenta[j]
        r = references[j]
        moves = set_track(body, data, load9_rows(r, 0), load3(r, 3), load3(r, 4), track)
        if not _fill(body, data, R, Pi, torques[j], controls[j], W, n) or not moves:
            n[STATUS] = 1.0
            continue
        if has_set:
            n[MULTIPLIER] = _multiplier(data, zones, track, R, Pi, W, lam[0], lam[1], costates[j])
        sweep_costates(data, zones, track, R, Pi, lam[0], W)
        n[RESIDUAL] = _conditions(data, track, lam[0], W, back, left[0], n)
        n[MADE_OF] = _made_of(data, zones, track, R, Pi, W, back)
        for i in range(6):
            costates[j, i] = lam[0, 0, i]
        # the published cost leaves the multiplier's share out
        weighted = data[LOG_FORM] > 0.0 and n[MULTIPLIER] != 0.0
        n[COST] = horizon_cost(problem if weighted else data, zones, track, R, Pi, W)
        factorize(body, data, zones, track, R, Pi, lam[0], W, fac, 0.0, False)
        n[CURVATURE] = smallest_pivot(data[H], fac)
        n[CORRECTION] = _correction(data, fac, left[0], Pi, left[1])
