"""Kernels of the reference over the horizon: what each stage is weighed against.

``track`` is laid out as follows: P1 R_N and R_N of the terminal cost, Pi_ref, the distance from one
stage's row to the next (0 while the reference rests: one row serves all), then for each stage Q1
R_k (Kalabic: R_k Q1) and R_k, and last the m reference controls z_ref = V^T B^+ u_ref. docs/
solver.md, "A moving reference", has the equations. At rest Pi_ref and z_ref are +0, whose
subtraction changes no bit.
"""

from __future__ import annotations

import math

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import body_inertia, rotation_of
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    cross,
    dot,
    mat_mat,
    mat_vec,
    scale,
)
from spacecraft_gnc.ocp._data_kernels import D_U, LOG_FORM, M_U, P1, Q1, H, data3, data9

TERMINAL_AT, END_AT, PI_AT, STRIDE_AT, STAGES_AT, STAGE_SIZE = 0, 9, 18, 21, 22, 18


def track_size(n: int, m: int) -> int:
    """Numbers of ``track`` over n steps for m controls."""
    return STAGES_AT + STAGE_SIZE * n + m


@kernel
def stage_weighed(track, k):
    """Q1 R_k (Kalabic: R_k Q1) of stage k."""
    return data9(track, STAGES_AT + int(track[STRIDE_AT]) * k)


@kernel
def stage_reference(track, k):
    """R_k of stage k."""
    return data9(track, STAGES_AT + int(track[STRIDE_AT]) * k + 9)


@kernel
def momentum_reference(track):
    """Pi_ref."""
    return data3(track, PI_AT)


@kernel
def control_reference(track, m, i):
    """Component i of the m reference controls z_ref."""
    return track[track.shape[0] - m + i]


@kernel
def is_moving(omega, tau):
    """Whether a rate or a torque is fed forward."""
    return dot(omega, omega) > 0.0 or dot(tau, tau) > 0.0


@kernel
def steady_spin(body, h, omega):
    """Momentum with which the integrator turns by exp(h omega) a step, and the torque it needs.

    h hat(Pi) = F J_d - J_d F^T and (I - F^T) Pi / h for F = exp(h hat(omega)), in closed form.
    """
    Pi = mat_vec(body_inertia(body), omega)
    gyroscopic = cross(omega, Pi)
    angle = h * math.sqrt(dot(omega, omega))
    half = math.sin(0.5 * angle) / (0.5 * angle) if angle > 0.0 else 1.0
    whole = math.sin(angle) / angle if angle > 0.0 else 1.0
    Pi = add(scale(whole, Pi), scale(0.5 * h * half * half, gyroscopic))
    return Pi, scale(half * half, gyroscopic), gyroscopic


@kernel
def _store(values, track, at):
    for i in range(len(values)):
        track[at + i] = values[i]


@kernel
def _store_stage(data, R, track, at):
    Q = data9(data, Q1)
    _store(mat_mat(R, Q) if data[LOG_FORM] > 0.0 else mat_mat(Q, R), track, at)
    _store(R, track, at + 9)


@kernel
def _turned(R, omega, time):
    """R exp(time hat(omega))."""
    rate = math.sqrt(dot(omega, omega))
    half = 0.5 * time * rate
    q = scale(math.sin(half) / rate if rate > 0.0 else 0.0, omega)
    return mat_mat(R, rotation_of(math.cos(half), q))


@kernel
def set_track(body, data, R, omega, tau, track):
    """Fill ``track`` for a reference that starts at R and moves by omega and tau."""
    m = int(data[M_U])
    controls = track.shape[0] - m
    end, momentum = R, (0.0, 0.0, 0.0)
    track[STRIDE_AT] = 0.0
    for i in range(m):
        track[controls + i] = 0.0
    _store_stage(data, R, track, STAGES_AT)
    if is_moving(omega, tau):
        h, n = data[H], (controls - STAGES_AT) // STAGE_SIZE
        momentum, needed, gyroscopic = steady_spin(body, h, omega)
        tau = add(tau, add(needed, scale(-1.0, gyroscopic)))
        for i in range(m):
            track[controls + i] = dot(data3(data, D_U + 4 * m + 3 * i), tau)
        track[STRIDE_AT] = STAGE_SIZE
        for k in range(1, n):
            _store_stage(data, _turned(R, omega, k * h), track, STAGES_AT + STAGE_SIZE * k)
        end = _turned(R, omega, n * h)
    _store(mat_mat(data9(data, P1), end), track, TERMINAL_AT)
    _store(end, track, END_AT)
    _store(momentum, track, PI_AT)
