"""Numbers of one program with compiled and with interpreted kernels."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

TESTS = Path(__file__).parent


def compiled_and_interpreted(program, folder):
    """Return the arrays, by name, that a program writes to the file it is given, either way."""
    return (
        _written(program, folder / "compiled.npz"),
        _written(program, folder / "interpreted.npz", NUMBA_DISABLE_JIT="1"),
    )


def _written(program, target, **environment):
    path = os.pathsep.join([str(TESTS.parent), str(TESTS)])
    subprocess.run(
        [sys.executable, "-c", program, str(target)],
        check=True,
        env={**os.environ, "PYTHONPATH": path, **environment},
    )
    with np.load(target) as stored:
        return dict(stored)
