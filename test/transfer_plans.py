"""Plans of transfers as the audit reads them."""

from __future__ import annotations

from spacecraft_gnc.vehicles.rigid_body.audit.transfer_conditions import Transfer


def transfer_of(solution):
    """Return the numbers of a solution."""
    problem = solution.problem
    return Transfer(
        problem.body.inertia, problem.body.time_step, problem.limits, problem.goal,
        solution.attitude, solution.momentum, solution.torque, solution.co_momentum,
        solution.zeta, solution.torque_multipliers, solution.momentum_multipliers,
    )  # fmt: skip
