"""Time scipy's fsolve on the compiled conditions, the derivative by finite differences."""

from __future__ import annotations

import ctypes

import numpy as np
from common import Problem, Vector, main
from ours_cpp import build, settings
from scipy.optimize import fsolve

ACCEPTED = 1e-10  # largest residual: finite differences do not reach the tolerance of the others


class Fsolve:
    """Warm-started from its last multipliers, shifted."""

    formulation = (
        "first-order conditions of the penalized problem, residual compiled from the C++, Powell's "
        "hybrid method with finite differences"
    )
    tolerance = "xtol 1e-12"

    def __init__(self, problem: Problem) -> None:
        self.settings = settings(problem)
        self.state, self.out = np.zeros(12), np.zeros(15)
        function = ctypes.CDLL(
            str(build("conditions.cpp", "conditions.so", "-shared", "-fPIC"))
        ).conditions
        function.restype, function.argtypes = None, [ctypes.c_void_p] * 4
        fixed = [x.ctypes.data for x in (self.settings, self.state)]
        result = self.out.ctypes.data

        def residual(multipliers: Vector) -> Vector:
            function(*fixed, multipliers.ctypes.data, result)
            return self.out[:6].copy()

        self.residual = residual
        self.reset()

    def reset(self) -> None:
        """Forget the multipliers."""
        self.start = np.zeros(6)

    def solve(self, attitude: Vector, momentum: Vector) -> Vector:
        """Solve from the multipliers of the last step, shifted."""
        self.state[:9], self.state[9:] = attitude.ravel(), momentum
        found, self.report, _, _ = fsolve(self.residual, self.start, full_output=True, xtol=1e-12)
        self.norm = float(np.linalg.norm(self.residual(found)))
        self.start = self.out[9:15].copy()
        return self.out[6:9].copy()

    def outcome(self) -> tuple[int, bool]:
        """Return the evaluations and whether the residual is small."""
        return self.report["nfev"], self.norm <= ACCEPTED


if __name__ == "__main__":
    main(Fsolve)
