"""The kernels of the SQP give the same numbers compiled and interpreted."""

from __future__ import annotations

import numpy as np
from both_ways import compiled_and_interpreted

PROGRAM = """
import sys
import numpy as np
from wheel_problems import MODELS, REST, near, report, skew
from spacecraft_gnc.vehicles.two_wheel.ocp.sqp import SqpSolver
found = {}
for model in MODELS:
    for soft in (False, True):
        plan = SqpSolver(skew(model, 4), restarts=0).solve(near(1, 0.05), REST, soft=soft)
        assert plan.converged
        found[f"{model}_{soft}"] = plan.accelerations
        found[f"{model}_{soft}_numbers"] = [
            plan.cost, plan.min_curvature, *plan.terminal_multipliers,
        ]
chord = SqpSolver(skew("so3", 4), chord=True).solve(near(1, 0.05), REST)
far = SqpSolver(report(horizon=4), restarts=0, max_iterations=10).solve(near(2, 0.5), REST)
assert not far.converged
np.savez(sys.argv[1], **found, chord=chord.accelerations, far=far.terminal_violation)
"""


def test_compiled_and_interpreted_kernels_agree(tmp_path):
    compiled, interpreted = compiled_and_interpreted(PROGRAM, tmp_path)
    assert len(compiled) == 14
    for name, value in compiled.items():
        size = max(1.0, float(np.abs(value).max()))
        assert np.abs(value - interpreted[name]).max() < 1e-6 * size, name
