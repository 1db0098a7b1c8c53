"""Kernels of the audit: steps of the integrator, many in one call."""

from __future__ import annotations

from spacecraft_gnc._kernels import kernel
from spacecraft_gnc.dynamics._lgvi_kernels import held, relative_quaternion, rotation_of
from spacecraft_gnc.lie._mat3_kernels import load3, load9, store3, store9


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
def turns(body, h, momenta, F, exists):
    """Fill F (m, 3, 3) with the turn that each of the momenta (m, 3) makes in a step."""
    for i in range(momenta.shape[0]):
        q0, q, ok = relative_quaternion(body, h, load3(momenta, i))
        exists[i] = ok
        store9(F, i, rotation_of(q0, q))
