"""Every kernel gives the same numbers compiled and interpreted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
PROGRAM = """
import math, sys
import numpy as np
from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, ShootingSolver, Weights

J = np.array([[1.0, 0.05, -0.1], [0.05, 0.8, 0.02], [-0.1, 0.02, 0.9]])
Q = np.array([[1.0, 0.2, 0.1], [0.2, 0.9, 0.0], [0.1, 0.0, 1.1]])
zone = PointingZone("exclusion", [1, 0, 0], [math.cos(0.3), math.sin(0.3), 0.0], 0.2, 1.0)
ocp = AttitudeOcp(J, 0.4, 4, Weights(0.1 * Q, 0.05 * Q, Q, 0.1 * Q, 0.2 * Q), 0.05, 1e4, (zone,))
R, Pi = lie.exp(np.array([0.02, 0.3, 0.55])), np.array([0.05, 0.0, -0.15])
u = np.full((4, 3), 0.03)
s = ShootingSolver(ocp).solve(R, Pi, lie.exp(np.array([0.1, 0.0, 0.2])))
assert s.converged
attitudes, momenta = RigidBody(J, 0.1).simulate(R, Pi, u[0], 20)
np.savez(
    sys.argv[1], torques=s.torques, costates=s.costates, cost=s.cost, curvature=s.min_curvature,
    attitudes=attitudes, momenta=momenta, gradient=ocp.gradient(u, R, Pi),
    hessian=ocp.hessian(u, R, Pi), value=ocp.cost(u, R, Pi),
)
"""


def run(target, **environment):
    subprocess.run(
        [sys.executable, "-c", PROGRAM, str(target)],
        check=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
    )
    with np.load(target) as stored:
        return dict(stored)


def test_compiled_and_interpreted_kernels_agree(tmp_path):
    compiled = run(tmp_path / "compiled.npz")
    interpreted = run(tmp_path / "interpreted.npz", NUMBA_DISABLE_JIT="1")
    for name, value in compiled.items():
        size = max(1.0, float(np.abs(value).max()))
        assert np.abs(value - interpreted[name]).max() < 1e-12 * size, name
