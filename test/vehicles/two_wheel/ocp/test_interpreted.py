"""The kernels of the SQP give the same numbers compiled and interpreted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[4]
PROGRAM = """
import sys
import numpy as np
from wheel_problems import MODELS, REST, near, report, skew
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver
found = {}
for model in MODELS:
    for soft in (False, True):
        plan = SqpSolver(skew(model, 6), restarts=0).solve(near(1, 0.05), REST, soft=soft)
        assert plan.converged
        found[f"{model}_{soft}"] = plan.accelerations
        found[f"{model}_{soft}_numbers"] = [
            plan.cost, plan.min_curvature, *plan.terminal_multipliers,
        ]
chord = SqpSolver(skew("so3", 6), chord=True).solve(near(1, 0.05), REST)
far = SqpSolver(report(horizon=4), restarts=0, max_iterations=10).solve(near(2, 0.5), REST)
assert not far.converged
np.savez(sys.argv[1], **found, chord=chord.accelerations, far=far.terminal_violation)
"""


def run(target, **environment):
    path = os.pathsep.join([str(ROOT), str(ROOT / "test")])
    subprocess.run(
        [sys.executable, "-c", PROGRAM, str(target)],
        check=True,
        env={**os.environ, "PYTHONPATH": path, **environment},
    )
    with np.load(target) as stored:
        return dict(stored)


def test_compiled_and_interpreted_kernels_agree(tmp_path):
    compiled = run(tmp_path / "compiled.npz")
    interpreted = run(tmp_path / "interpreted.npz", NUMBA_DISABLE_JIT="1")
    assert len(compiled) == 14
    for name, value in compiled.items():
        size = max(1.0, float(np.abs(value).max()))
        assert np.abs(value - interpreted[name]).max() < 1e-6 * size, name
