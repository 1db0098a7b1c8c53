"""Kernels of the nominal controller; `feedback` documents the equations.

``law`` is packed by `feedback.AttitudeFeedback`: A (9), K (9), the torque limit (infinity: none).
``E`` is the attitude error V^T C.
"""

from __future__ import annotations

import math

from spacecraft_gnc._inner_kernels import inlined_inner_kernel, inner_kernel
from spacecraft_gnc._kernels import inlined_kernel, kernel
from spacecraft_gnc.dynamics._lgvi_kernels import body_inverse_inertia
from spacecraft_gnc.lie._mat3_kernels import (
    add,
    dot,
    load3,
    load9_rows,
    mat_mat,
    mat_t_mat,
    mat_t_vec,
    mat_vec,
    scale,
    store3,
    sub,
    vee_antisymmetric,
)
from spacecraft_gnc.ocp._track_kernels import is_moving, start_of_motion


@inlined_kernel
def attitude_gain(law):
    """A of a packed law."""
    return (law[0], law[1], law[2], law[3], law[4], law[5], law[6], law[7], law[8])


@inlined_kernel
def momentum_gain(law):
    """K of a packed law."""
    return (law[9], law[10], law[11], law[12], law[13], law[14], law[15], law[16], law[17])


@inlined_inner_kernel
def _demand(law, E, Pi):
    """-(K Pi + e), hat(e) = A E - E^T A."""
    e = scale(2.0, vee_antisymmetric(mat_mat(attitude_gain(law), E)))
    return scale(-1.0, add(mat_vec(momentum_gain(law), Pi), e))


@inlined_inner_kernel
def _limited(law, T):
    """T, scaled down to the limit."""
    size = math.sqrt(dot(T, T))
    return scale(law[18] / size, T) if size > law[18] else T


@inlined_inner_kernel
def feedback_torque(law, E, Pi):
    """(9), (10) at rest: T = -(K Pi + e), scaled down to the limit."""
    return _limited(law, _demand(law, E, Pi))


@inner_kernel
def tracking_torque(law, body, h, E, Pi, omega, tau):
    """T = u_ref - K (Pi - Pi_ref) - e of a moving reference, scaled down to the limit."""
    Pi_ref, u_ref = start_of_motion(body, h, mat_t_vec(E, omega), mat_t_vec(E, tau))
    return _limited(law, add(u_ref, _demand(law, E, sub(Pi, Pi_ref))))


@inlined_kernel
def lyapunov(law, body, E, Pi):
    """Pi . J^-1 Pi / 2 + tr(A (I - E)) (see `feedback.AttitudeFeedback.lyapunov`)."""
    A = attitude_gain(law)
    AE = mat_mat(A, E)
    potential = (A[0] - AE[0]) + (A[4] - AE[4]) + (A[8] - AE[8])
    return 0.5 * dot(Pi, mat_vec(body_inverse_inertia(body), Pi)) + potential


@kernel
def command(law, body, h, states, torque):
    """Write the torque (1, 3) at ``states`` (9, 3): rows C, Pi, V, omega, tau."""
    E, Pi = mat_t_mat(load9_rows(states, 4), load9_rows(states, 0)), load3(states, 3)
    omega, tau = load3(states, 7), load3(states, 8)
    if is_moving(omega, tau):
        store3(torque, 0, tracking_torque(law, body, h, E, Pi, omega, tau))
    else:
        store3(torque, 0, feedback_torque(law, E, Pi))


@kernel
def level_at(law, body, states):
    """Lyapunov function at ``states`` (7, 3): rows C, Pi, V."""
    E = mat_t_mat(load9_rows(states, 4), load9_rows(states, 0))
    return lyapunov(law, body, E, load3(states, 3))
