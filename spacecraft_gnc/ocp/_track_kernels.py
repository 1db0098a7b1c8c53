"""Kernels of the reference over the horizon: what each stage is weighed against.

``track`` is laid out as follows: P1 R_N, R_N and Pi_N of the reference for the terminal cost, the
distance from one stage's row to the next (0 while the reference rests: one row serves all), then
for each stage Q1 R_k (Kalabic: R_k Q1), R_k and Pi_k, and last the m reference controls z_ref =
V^T B^+ u_ref. docs/solver.md, "A moving reference", has the equations. At rest Pi_k and z_ref are
+0, whose subtraction changes no bit.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc._kernels import inlined_kernel, kernel
from spacecraft_gnc.dynamics._lgvi_kernels import (
    body_inertia,
    polished,
    relative_quaternion,
    rotate_back,
    rotate_rows,
)
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    mat_mat,
    mat_vec,
    scale,
    sub,
)
from spacecraft_gnc.ocp._data_kernels import D_U, LOG_FORM, M_U, P1, PLANT_H, Q1, H, data3, data9

TERMINAL_AT, END_AT, PI_AT, STRIDE_AT, STAGES_AT, STAGE_SIZE = 0, 9, 18, 21, 22, 21


def track_size(n: int, m: int) -> int:
    """Numbers of ``track`` over n steps for m controls."""
    return STAGES_AT + STAGE_SIZE * n + m


@inlined_inner_kernel
def stage_weighed(track, k):
    """Q1 R_k (Kalabic: R_k Q1) of stage k."""
    return data9(track, STAGES_AT + int(track[STRIDE_AT]) * k)


@inlined_kernel
def stage_reference(track, k):
    """R_k of stage k."""
    return data9(track, STAGES_AT + int(track[STRIDE_AT]) * k + 9)


@inlined_inner_kernel
def stage_momentum(track, k):
    """Pi_k of stage k of the reference."""
    return data3(track, STAGES_AT + int(track[STRIDE_AT]) * k + 18)


@inlined_inner_kernel
def end_momentum(track):
    """Pi_N of the reference."""
    return data3(track, PI_AT)


@inlined_inner_kernel
def control_reference(track, m, i):
    """Component i of the m reference controls z_ref."""
    return track[track.shape[0] - m + i]


@inlined_inner_kernel
def is_moving(omega, tau):
    """Whether a rate or a torque is fed forward."""
    return dot(omega, omega) > 0.0 or dot(tau, tau) > 0.0


@kernel
def start_of_motion(body, h, omega, tau):
    """Pi_0 and u_ref of a body, integrated by steps h, that turns at omega with the torque tau.

    Where tau is omega x J omega they are those of F = exp(h hat(omega)), h hat(Pi) = F J_d - J_d
    F^T and u = (I - F^T) Pi / h in closed form, and every step makes that turn. What tau has
    beyond that accelerates: half a step of it is in Pi_0, so that the first turn has the mean rate.
    """
    J_omega = mat_vec(body_inertia(body), omega)
    gyroscopic = cross(omega, J_omega)
    angle = h * math.sqrt(dot(omega, omega))
    whole = math.sin(angle) / angle if angle > 0.0 else 1.0
    half = math.sin(0.5 * angle) / (0.5 * angle) if angle > 0.0 else 1.0
    needed = scale(half * half, gyroscopic)
    beyond = sub(tau, gyroscopic)
    Pi = add(scale(whole, J_omega), scale(0.5 * h, add(needed, beyond)))
    return Pi, add(needed, beyond)


@inlined_inner_kernel
def _store(values, track, at):
    for i in range(len(values)):
        track[at + i] = values[i]


@inner_kernel
def _store_stage(data, R, Pi, track, at):
    Q = data9(data, Q1)
    _store(mat_mat(R, Q) if data[LOG_FORM] > 0.0 else mat_mat(Q, R), track, at)
    _store(R, track, at + 9)
    _store(Pi, track, at + 18)


@kernel
def set_track(body, data, R, omega, tau, track):
    """Fill ``track`` for a reference at R that moves by omega and tau; returns whether it can.

    It starts with the momentum that the plant has on its way, and moves as the prediction carries
    it on with u_ref held over the horizon: a body on its way is to do just that.
    """
    m, h, Pi, ok = int(data[M_U]), data[H], (0.0, 0.0, 0.0), True
    controls = track.shape[0] - m
    track[STRIDE_AT] = 0.0
    for i in range(m):
        track[controls + i] = 0.0
    if is_moving(omega, tau):
        track[STRIDE_AT] = STAGE_SIZE
        Pi, u = start_of_motion(body, data[PLANT_H], omega, tau)
        for i in range(m):
            track[controls + i] = dot(data3(data, D_U + 4 * m + 3 * i), u)
        for k in range((controls - STAGES_AT) // STAGE_SIZE):
            _store_stage(data, R, Pi, track, STAGES_AT + STAGE_SIZE * k)
            q0, q, exists = relative_quaternion(body, h, Pi)
            ok = ok and exists
            R, Pi = polished(rotate_rows(q0, q, R)), add(rotate_back(q0, q, Pi), scale(h, u))
    else:
        _store_stage(data, R, Pi, track, STAGES_AT)
    _store(mat_mat(data9(data, P1), R), track, TERMINAL_AT)
    _store(R, track, END_AT)
    _store(Pi, track, PI_AT)
    return ok
