"""The horizon as a nonlinear program by multiple shooting, for the solvers of CasADi."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from common import Problem, Vector, quaternion
from symbolic import penalty, stage_cost, step, terminal_cost

STAGE = 9  # variables of one stage: the scaled torque u_k, then the state k + 1
COST_SCALE = 1e3  # the optimal cost is of the order 1e-2
COMPILABLE = 10  # [steps]: gcc takes minutes for the derivatives of a longer horizon
COMPILED = {
    "jit": True,
    "compiler": "shell",
    "jit_options": {"compiler": "gcc", "flags": ["-O3", "-march=native"]},
}


class MultipleShooting:
    """A CasADi solver, warm-started from its last primal and dual solution shifted by one step.

    ``hard`` states the torque limit as a constraint |u|^2 <= max_torque^2, else it is the penalty.
    Torques are scaled by the limit, the cost by ``cost_scale``.
    """

    def __init__(
        self,
        problem: Problem,
        plugin: str,
        options: dict[str, Any],
        hard: bool,
        cost_scale: float = COST_SCALE,
    ) -> None:
        self.scale = problem.max_torque
        rows = STAGE - 3 + hard  # constraints of one stage: the step, then the limit
        self.bounds = {
            "lbg": np.tile([0.0] * 6 + [-np.inf] * hard, problem.horizon),
            "ubg": np.tile([0.0] * 6 + [1.0] * hard, problem.horizon),
        }
        self.sizes = (STAGE, rows)
        self.count = problem.horizon
        program = _program(problem, hard, cost_scale)
        common = {"print_time": False, "record_time": False, "calc_lam_p": False}
        common |= COMPILED if problem.horizon <= COMPILABLE else {}
        self.solver = ca.nlpsol("solver", plugin, program, common | options)
        self.reset()

    def reset(self) -> None:
        """Forget the last solution."""
        variables, rows = (size * self.count for size in self.sizes)
        self.start = {
            "x0": np.zeros(variables),
            "lam_x0": np.zeros(variables),
            "lam_g0": np.zeros(rows),
        }

    def solve(self, attitude: Vector, momentum: Vector) -> Vector:
        """Solve from the last solution, shifted."""
        state = [*quaternion(attitude), *momentum.tolist()]
        found = self.solver(p=state, **self.start, **self.bounds)
        values = found["x"].full().ravel()
        self.start = {
            "x0": shifted(values, self.sizes[0]),
            "lam_x0": shifted(found["lam_x"].full().ravel(), self.sizes[0]),
            "lam_g0": shifted(found["lam_g"].full().ravel(), self.sizes[1]),
        }
        return self.scale * values[:3]

    def outcome(self) -> tuple[int, bool]:
        """Return what the solver says of the last solve."""
        stats = self.solver.stats()
        return stats["iter_count"], stats["success"]


def shifted(values: Vector, size: int) -> Vector:
    """Return stages 1, 2, .., N-1 and the last one once more."""
    return np.concatenate([values[size:], values[-size:]])


def _program(problem: Problem, hard: bool, cost_scale: float) -> dict[str, ca.SX]:
    first = state = ca.SX.sym("x0", 6)
    variables, constraints, cost = [], [], 0
    for k in range(problem.horizon):
        scaled, following = ca.SX.sym(f"u{k}", 3), ca.SX.sym(f"x{k + 1}", 6)
        torque = problem.max_torque * scaled
        cost += stage_cost(problem, state, torque)
        cost += 0 if hard else penalty(problem, torque)
        variables += [scaled, following]
        constraints += [following - step(problem, state, torque)]
        constraints += [ca.dot(scaled, scaled)] if hard else []
        state = following
    cost += terminal_cost(problem, state)
    return {
        "x": ca.vertcat(*variables),
        "p": first,
        "f": cost_scale * cost,
        "g": ca.vertcat(*constraints),
    }
