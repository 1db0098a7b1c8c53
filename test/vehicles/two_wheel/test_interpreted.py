"""The gyrostat's kernels give the same numbers compiled and interpreted."""

from __future__ import annotations

import numpy as np
from both_ways import compiled_and_interpreted

PROGRAM = """
import sys
import numpy as np
from spacecraft_gnc import lie
from wheeled import PYRAMID, small
gyrostat = small(PYRAMID, 0.05, max_speed=60.0, max_acceleration=30.0)
state = gyrostat.state_from_rate(
    lie.exp(np.array([0.3, 0.2, 0.1])), [0.3, -0.5, 0.8], [50.0, -20.0, 30.0, 20.0]
)
commands = np.random.default_rng(0).normal(scale=20.0, size=(100, 4))
motion = gyrostat.simulate(state, commands)
end = gyrostat.step(state, commands[0], 20)
rubbing = small(
    PYRAMID, 0.05, max_speed=60.0, max_acceleration=30.0,
    viscous_friction=[3e-3, 0.0, 1e-3, 0.0], coulomb_friction=[0.1, 0.1, 0.0, 0.0],
)
slowed = rubbing.simulate(state, commands)
stopped = rubbing.step(state, np.zeros(4), 200)
np.savez(sys.argv[1], *motion, *end[:5], *slowed, *stopped[:5])
"""


def test_compiled_and_interpreted_kernels_agree(tmp_path):
    compiled, interpreted = compiled_and_interpreted(PROGRAM, tmp_path)
    assert len(compiled) == 16
    for name, value in compiled.items():
        size = max(1.0, float(np.abs(value).max()))
        assert np.abs(value - interpreted[name]).max() < 1e-13 * size, name
