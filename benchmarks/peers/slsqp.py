"""Time scipy's SLSQP on the compiled cost by finite differences: the part fmincon has in papers."""

from __future__ import annotations

import numpy as np
from common import Problem, Vector, main
from ours import ocp_of
from scipy.optimize import minimize

COST_SCALE = 1e3  # the optimal cost is of the order 1e-2


class Slsqp:
    """Warm-started from its last torques, shifted."""

    formulation = (
        "limit as constraints |u_k|^2 <= max_torque^2, cost of the torques compiled by this "
        "project, gradient of the cost by central differences"
    )
    tolerance = "ftol 1e-12, cost scaled by 1e3"

    def __init__(self, problem: Problem) -> None:
        self.ocp = ocp_of(problem, 0.0)  # no penalty
        self.scale, self.count = problem.max_torque, problem.horizon
        self.limit = {"type": "ineq", "fun": self._room, "jac": self._room_slope}
        self.reset()

    def _room(self, v: Vector) -> Vector:
        return 1.0 - np.sum(v.reshape(-1, 3) ** 2, axis=1)

    def _room_slope(self, v: Vector) -> Vector:
        slope = np.zeros((self.count, self.count, 3))
        steps = np.arange(self.count)
        slope[steps, steps] = -2.0 * v.reshape(-1, 3)
        return slope.reshape(self.count, -1)

    def reset(self) -> None:
        """Forget the torques."""
        self.start = np.zeros(3 * self.count)

    def solve(self, attitude: Vector, momentum: Vector) -> Vector:
        """Solve from the torques of the last step, shifted."""

        def cost(v: Vector) -> float:
            return COST_SCALE * self.ocp.cost(self.scale * v.reshape(-1, 3), attitude, momentum)

        self.found = minimize(
            cost,
            self.start,
            method="SLSQP",
            jac="3-point",
            constraints=self.limit,
            options={"ftol": 1e-12, "maxiter": 200},
        )
        self.start = np.concatenate([self.found.x[3:], self.found.x[-3:]])
        return self.scale * self.found.x[:3]

    def outcome(self) -> tuple[int, bool]:
        """Return the iterations and what SLSQP says."""
        return self.found.nit, self.found.success


if __name__ == "__main__":
    main(Slsqp)
