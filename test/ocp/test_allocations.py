"""The hot path allocates nothing: what numba counts are the handles of the arrays handed over."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

COUNT = """
import sys
import numpy as np
from numba.core.runtime import rtsys
from spacecraft_gnc import lie
from spacecraft_gnc.ocp import AttitudeOcp, ShootingOptions, ShootingSolver

ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, int(sys.argv[1]), max_torque=0.01)
solver = ShootingSolver(ocp, options=ShootingOptions(formulation=sys.argv[2]))
far, near = lie.exp(np.array([0.5, 1.0, 1.0])), np.eye(3)
counts = []
for attitude in (near, far):
    solver.solve(attitude, np.zeros(3))
    before = rtsys.get_allocation_stats().alloc
    steps = solver.solve(attitude, np.zeros(3)).iterations
    counts.append((rtsys.get_allocation_stats().alloc - before, steps))
print(*counts[0], *counts[1])
"""


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="counts compiled code")
@pytest.mark.parametrize("formulation", ["backward_sweep", "single_shooting"])
def test_allocations_depend_neither_on_the_horizon_nor_on_the_iterations(formulation):
    counts = set()
    for horizon in ("2", "20"):
        command = [sys.executable, "-c", COUNT, horizon, formulation]
        environment = {**os.environ, "NUMBA_NRT_STATS": "1"}
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, check=True, timeout=300
        )
        near, no_steps, far, some_steps = map(int, done.stdout.split())
        assert no_steps == 0
        assert some_steps >= 2
        counts |= {near, far}
    assert counts == {7}  # one handle for each of the arrays that Python passes
