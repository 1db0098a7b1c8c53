"""Time our solver, called from Python as the controller calls it."""

from __future__ import annotations

from common import Problem, Vector, main

from spacecraft_gnc.ocp import AttitudeOcp, ShootingSolver
from spacecraft_gnc.ocp.problem import Weights
from spacecraft_gnc.ocp.shooting import ShootingOptions


def ocp_of(problem: Problem, max_torque: float) -> AttitudeOcp:
    """Return the project's own problem; ``max_torque`` 0 leaves the penalty out."""
    weights = Weights(
        problem.stage_attitude,
        problem.stage_momentum,
        problem.stage_torque,
        problem.terminal_attitude,
        problem.terminal_momentum,
    )
    return AttitudeOcp(
        problem.inertia,
        problem.time_step,
        problem.horizon,
        weights,
        max_torque,
        problem.torque_penalty,
    )


class Ours:
    """`ShootingSolver` on the penalized problem."""

    formulation = "first-order conditions of the penalized problem, compiled, called from Python"

    def __init__(self, problem: Problem) -> None:
        ocp = ocp_of(problem, problem.max_torque)
        self.tolerance = f"residual {problem.tolerance:g}"
        self.solver = ShootingSolver(ocp, options=ShootingOptions(problem.tolerance))
        self.solver.solve(problem.attitude[0], problem.momentum[0])  # compiles
        self.reset()

    def reset(self) -> None:
        """Forget the multipliers."""
        self.start: Vector | None = None

    def solve(self, attitude: Vector, momentum: Vector) -> Vector:
        """Solve from the multipliers of the last step, shifted."""
        self.solution = self.solver.solve(attitude, momentum, warm_start=self.start)
        self.start = self.solution.warm_start
        return self.solution.torques[0]

    def outcome(self) -> tuple[int, bool]:
        """Return the Newton steps and whether they converged."""
        return self.solution.iterations, self.solution.converged


if __name__ == "__main__":
    main(Ours)
