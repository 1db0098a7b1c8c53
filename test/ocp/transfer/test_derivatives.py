"""The stage derivatives and curvatures agree with differences of the roll-out."""

from __future__ import annotations

import numpy as np
import pytest
from transfer_cases import BODY

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp.transfer._stage_kernels import A_AT, B_AT, HPE, HPP, PHI, linearize, move

FULL = RigidBody([[900.0, 50.0, -80.0], [50.0, 1300.0, 30.0], [-80.0, 30.0, 1000.0]], 0.2)
SCALES = np.repeat([1e-3, 1.0], 3)  # [rad], [N m s]


def one_step(body, momentum, torque):
    """Rotation of a step and the momentum after it."""
    quaternions, gap = np.empty((1, 4)), np.empty((1, 3))
    momenta = np.array([momentum, np.zeros(3)])
    ok, end = move(
        body.packed, body.time_step, torque[None], momenta, np.eye(3).ravel(), quaternions, gap
    )
    assert ok
    return lie.exp(np.array(end)), gap[0], quaternions


@pytest.mark.parametrize("body", [BODY, FULL], ids=["diagonal", "full"])
def test_derivatives(body):
    rng = np.random.default_rng(1)
    momentum, torque = 400.0 * rng.standard_normal(3), 20.0 * rng.standard_normal(3)
    lam, m = rng.standard_normal((1, 3)), 300.0 * rng.standard_normal(3)
    step, _, quaternions = one_step(body, momentum, torque)
    stage = np.zeros((2, 45))
    momenta = np.array([momentum, np.zeros(3)])
    linearize(body.packed, body.time_step, momenta, quaternions, lam, tuple(m), True, stage)
    Phi, B, A, Hpp, Hpe = (stage[0, i : i + 9].reshape(3, 3) for i in (PHI, B_AT, A_AT, HPP, HPE))

    def after(x):
        turned, gap, _ = one_step(body, momentum + x[3:], torque)
        return np.append(lie.log(step.T @ lie.exp(x[:3]) @ turned), gap)

    def lagrangian(x):
        y = after(x)
        return m @ y[:3] + lam[0] @ y[3:]

    units = np.diag(SCALES)
    slopes = np.array([(after(d) - after(-d)) / 2.0 for d in units]).T / SCALES
    np.testing.assert_allclose(
        slopes, np.block([[Phi, B], [np.zeros((3, 3)), A]]), rtol=0.0, atol=1e-9
    )
    bends = np.empty((6, 6))
    for i, a in enumerate(5.0 * units):
        for j, b in enumerate(5.0 * units):
            total = lagrangian(a + b) - lagrangian(a - b) - lagrangian(b - a) + lagrangian(-a - b)
            bends[i, j] = total / (100.0 * SCALES[i] * SCALES[j])
    np.testing.assert_allclose(bends[3:, 3:], Hpp, rtol=1e-4, atol=1e-4 * np.abs(Hpp).max())
    np.testing.assert_allclose(bends[3:, :3], Hpe, rtol=1e-4, atol=1e-4 * np.abs(Hpe).max())
    np.testing.assert_allclose(bends[:3, :3], 0.0, atol=1e-4)
