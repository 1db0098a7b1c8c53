"""Attitude transfers by CasADi and IPOPT: another form of the problem, with other derivatives.

Unknowns are torques, momenta, and the quaternions of steps and attitudes, with every equation of
the motion as a condition (multiple shooting: all matrices are banded). The formulas are written
here once more, not taken from the planner, whose reference this is.
"""

from __future__ import annotations

from time import perf_counter
from typing import Any, Final, NamedTuple

import casadi as ca
import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer import AttitudeTransfer
from spacecraft_gnc.ocp.transfer.starts import Start
from spacecraft_gnc.types import Array, Matrix3

OPTIONS: Final[dict[str, Any]] = {
    "print_time": False,
    "error_on_fail": False,
    "expand": True,  # takes two thirds of the time that it takes without
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.max_iter": 500,
    "ipopt.max_cpu_time": 3.0,  # [s]; a plan takes 0.1, the search for none may take minutes
    "ipopt.mu_strategy": "adaptive",  # fewer iterations than with the default
    "ipopt.bound_relax_factor": 0.0,  # else costs are up to 6e-7 below those within the bounds
    "ipopt.tol": 1e-9,
}
_MOST: Final = 0.9  # of the vector part of a step's quaternion


class TransferByIpopt(NamedTuple):
    """What IPOPT found; costs and plans count only where it ``solved`` the transfer."""

    solved: bool
    status: str
    cost: float
    torque: Array
    momentum: Array
    solve_time: float
    """Wall time of IPOPT [s], without the construction of the problem."""
    iterations: int


class TransferIpopt:
    """IPOPT for transfers of a body in a number of steps of any length."""

    def __init__(self, inertia: Matrix3, n_steps: int) -> None:
        N = n_steps
        stage = _stage(np.array(inertia)).map(N)
        F, P, Q, U = (
            ca.MX.sym("F", 3, N), ca.MX.sym("P", 3, N + 1), ca.MX.sym("Q", 4, N + 1),
            ca.MX.sym("U", 3, N),
        )  # fmt: skip
        h, goal = ca.MX.sym("h"), ca.MX.sym("goal", 4)
        implicit, momentum, attitude = stage(F, P[:, :-1], Q[:, :-1], U, h)
        end = _product(ca.vertcat(goal[0], -goal[1:]), Q[:, N])[1:]
        g = ca.vertcat(
            ca.vec(implicit), ca.vec(momentum - P[:, 1:]), ca.vec(attitude - Q[:, 1:]), end
        )
        self._n_steps, self._n_g = N, g.shape[0]
        w = ca.vertcat(ca.vec(F), ca.vec(P), ca.vec(Q), ca.vec(U))
        nlp: Any = {"x": w, "p": ca.vertcat(h, goal), "f": 0.5 * ca.sumsqr(U), "g": g}
        self._solver = ca.nlpsol("transfer", "ipopt", nlp, OPTIONS)

    def solve(self, problem: AttitudeTransfer, start: Start) -> TransferByIpopt:
        """Solve a transfer from the start, moved within the bounds."""
        N, h = self._n_steps, problem.body.time_step
        low_u, high_u, low_p, high_p = problem.limits
        torque = np.clip(start.torque, low_u, high_u)
        momentum = np.clip(start.momentum, low_p, high_p)
        rates = np.linalg.solve(problem.body.inertia, momentum.T).T
        attitudes = [np.eye(3)]
        for rate in rates[:-1]:
            attitudes.append(attitudes[-1] @ lie.exp(h * rate))
        quaternions = np.array([_wxyz(R) for R in attitudes])
        quaternions[1:] *= np.cumprod(_signs(quaternions))[:, None]
        lower, upper = np.tile(low_p, (N + 1, 1)), np.tile(high_p, (N + 1, 1))
        lower[0] = upper[0] = problem.start_momentum
        lower[-1] = upper[-1] = problem.goal_momentum
        most_q = np.full((N + 1, 4), 2.0)
        least_q = -most_q
        least_q[0] = most_q[0] = quaternions[0]
        goal = _wxyz(problem.start.T @ problem.goal)
        begun = perf_counter()
        result = self._solver(
            x0=_joined(0.5 * h * rates[:-1], momentum, quaternions, torque),
            p=[h, *(goal if goal @ quaternions[-1] >= 0.0 else -goal)],
            lbx=_joined(np.full(3 * N, -_MOST), lower, least_q, np.tile(low_u, N)),
            ubx=_joined(np.full(3 * N, _MOST), upper, most_q, np.tile(high_u, N)),
            lbg=np.zeros(self._n_g),
            ubg=np.zeros(self._n_g),
        )
        taken = perf_counter() - begun
        x, stats = np.array(result["x"]).ravel(), self._solver.stats()
        status = str(stats["return_status"])
        return TransferByIpopt(
            status == "Solve_Succeeded",
            status,
            float(result["f"]),
            x[-3 * N :].reshape(-1, 3),
            x[3 * N : 6 * N + 3].reshape(-1, 3),
            taken,
            int(stats["iter_count"]),
        )


def _stage(inertia: Matrix3) -> Any:
    """Return the function of a step: its implicit equation, next momentum and attitude."""
    f, p, q, u = ca.SX.sym("f", 3), ca.SX.sym("p", 3), ca.SX.sym("q", 4), ca.SX.sym("u", 3)
    h, J = ca.SX.sym("h"), ca.DM(inertia)
    f0 = ca.sqrt(1.0 - ca.dot(f, f))
    implicit = 2.0 * f0 * (J @ f) + 2.0 * ca.cross(f, J @ f) - h * p
    t = 2.0 * ca.cross(f, p)
    after = p + ca.cross(f, t) - f0 * t + h * u
    return ca.Function("stage", [f, p, q, u, h], [implicit, after, _product(q, ca.vertcat(f0, f))])


def _product(a: Any, b: Any) -> Any:
    """Product of quaternions (w, x, y, z)."""
    v = a[0] * b[1:] + b[0] * a[1:] + ca.cross(a[1:], b[1:])
    return ca.vertcat(a[0] * b[0] - ca.dot(a[1:], b[1:]), v)


def _wxyz(attitude: Matrix3) -> Array:
    x, y, z, w = lie.to_quaternion_xyzw(attitude)
    return np.array([w, x, y, z])


def _signs(quaternions: Array) -> Array:
    """Return -1 where a quaternion has another sign than the one before it, else 1."""
    return np.where(np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0.0, -1.0, 1.0)


def _joined(*parts: Any) -> Array:
    return np.concatenate([np.ravel(part) for part in parts])
