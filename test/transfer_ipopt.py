"""Attitude transfers by CasADi and IPOPT: another discretized problem form, other derivatives."""

from __future__ import annotations

import casadi as ca
import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer import AttitudeTransfer

OPTIONS = {
    "print_time": False,
    "error_on_fail": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.max_iter": 500,
    "ipopt.tol": 1e-9,
}


def _product(a, b):
    """Product of quaternions (w, x, y, z)."""
    v = a[0] * b[1:] + b[0] * a[1:] + ca.cross(a[1:], b[1:])
    return ca.vertcat(a[0] * b[0] - ca.dot(a[1:], b[1:]), v)


class TransferIpopt:
    """Unknowns are torques, momenta, quaternions of steps and attitudes."""

    def __init__(self, body, n_steps: int) -> None:
        N, h, J = n_steps, body.time_step, ca.DM(np.array(body.inertia))
        f, p, q, u = ca.SX.sym("f", 3), ca.SX.sym("p", 3), ca.SX.sym("q", 4), ca.SX.sym("u", 3)
        f0 = ca.sqrt(1.0 - ca.dot(f, f))
        implicit = 2.0 * f0 * (J @ f) + 2.0 * ca.cross(f, J @ f) - h * p
        t = 2.0 * ca.cross(f, p)
        after = p + ca.cross(f, t) - f0 * t + h * u
        one = ca.Function("one", [f, p, q, u], [implicit, after, _product(q, ca.vertcat(f0, f))])
        every = one.map(N)
        F, P, Q, U = (
            ca.MX.sym("F", 3, N), ca.MX.sym("P", 3, N + 1), ca.MX.sym("Q", 4, N + 1),
            ca.MX.sym("U", 3, N),
        )  # fmt: skip
        a, b, c = every(F, P[:, :-1], Q[:, :-1], U)
        goal = ca.MX.sym("goal", 4)
        inverse = ca.vertcat(goal[0], -goal[1:])
        g = ca.vertcat(
            ca.vec(a), ca.vec(b - P[:, 1:]), ca.vec(c - Q[:, 1:]), _product(inverse, Q[:, N])[1:]
        )
        self.n_steps, self.n_g = N, g.shape[0]
        w = ca.vertcat(ca.vec(F), ca.vec(P), ca.vec(Q), ca.vec(U))
        nlp = {"x": w, "p": goal, "f": 0.5 * ca.sumsqr(U), "g": g}
        self.solver = ca.nlpsol("transfer", "ipopt", nlp, OPTIONS)

    def solve(self, problem: AttitudeTransfer, torque, momentum):
        """Return status, cost, torque (N, 3), momentum (N+1, 3)."""
        N, h = self.n_steps, problem.body.time_step
        rates = np.linalg.solve(problem.body.inertia, np.asarray(momentum).T).T
        quaternions = [np.array([1.0, 0.0, 0.0, 0.0])]
        for rate in rates[:-1]:
            x, y, z, w0 = lie.to_quaternion_xyzw(lie.exp(h * rate))
            a, b = quaternions[-1], np.array([w0, x, y, z])
            quaternions.append(
                np.concatenate(
                    [
                        [a[0] * b[0] - a[1:] @ b[1:]],
                        a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]),
                    ]
                )
            )
        x, y, z, w0 = lie.to_quaternion_xyzw(problem.start.T @ problem.goal)
        low_u, high_u, low_p, high_p = problem.limits
        lower = np.full((N + 1, 3), low_p)
        upper = np.full((N + 1, 3), high_p)
        lower[0] = upper[0] = problem.start_momentum
        lower[-1] = upper[-1] = problem.goal_momentum
        ql, qh = np.full((N + 1, 4), -2.0), np.full((N + 1, 4), 2.0)
        ql[0] = qh[0] = quaternions[0]
        result = self.solver(
            x0=np.concatenate(
                [(0.5 * h * rates[:-1]).ravel(), np.ravel(momentum), np.ravel(quaternions),
                 np.ravel(torque)]
            ),
            p=[w0, x, y, z],
            lbx=np.concatenate(
                [np.full(3 * N, -0.9), lower.ravel(), ql.ravel(), np.tile(low_u, N)]
            ),
            ubx=np.concatenate(
                [np.full(3 * N, 0.9), upper.ravel(), qh.ravel(), np.tile(high_u, N)]
            ),
            lbg=np.zeros(self.n_g),
            ubg=np.zeros(self.n_g),
        )  # fmt: skip
        x = np.array(result["x"]).ravel()
        momentum = x[3 * N : 3 * N + 3 * (N + 1)].reshape(-1, 3)
        torque = x[-3 * N :].reshape(-1, 3)
        return self.solver.stats()["return_status"], float(result["f"]), torque, momentum
