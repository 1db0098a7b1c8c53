"""One random problem in the terms of the program: rollout, cost, and Newton's correction."""

# ruff: noqa: N803 - the symbols are the paper's

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
from program import STATE, ZONE, ZONES, Program

Array = np.ndarray


@cache
def program(horizon: int, controls: int) -> Program:
    """Return the functions for a horizon."""
    return Program(horizon, controls)


def half_trace_minus(Q: Array) -> Array:
    """Return S with |Q^(1/2) hat(x)|_F^2 / 2 = x.S x."""
    return 0.5 * (np.trace(Q) * np.eye(3) - Q)


def hat(v: Array) -> Array:
    """Return the matrix of v x."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def quaternion(R: Array) -> Array:
    """Return the unit quaternion (scalar first) of a rotation, from its largest component."""
    t = np.trace(R)
    K = np.empty((4, 4))
    K[0, 0], K[1:, 1:] = t, R + R.T - t * np.eye(3)
    K[0, 1:] = K[1:, 0] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    K = (K + np.eye(4)) / 4.0  # e e^T
    largest = int(np.argmax(np.diag(K)))
    e = K[largest] / math.sqrt(K[largest, largest])
    return e / np.linalg.norm(e)


class Problem:
    """One drawn problem in the terms of the program."""

    def __init__(self, drawn: dict[str, Any]) -> None:
        self.seed, n = drawn["seed"], drawn["horizon"]
        self.J = np.array(drawn["inertia"])
        self.B = np.array(drawn["actuators"])
        self.scale = drawn["control_scale"]
        reference = np.array(drawn["reference"])
        m = self.B.shape[1]
        effort = np.array(drawn["stage_torque"])
        turned = [
            half_trace_minus(reference.T @ np.array(drawn[name]) @ reference)
            for name in ("stage_attitude", "terminal_attitude")
        ]
        zones = np.zeros((ZONE, ZONES))
        zones[0], zones[3], zones[6:8] = 1.0, 1.0, [[1.0], [1.0]]  # none: never inside, no weight
        for i, (body, inertial, half_angle, sign, penalty) in enumerate(drawn["zones"]):
            zones[:3, i], zones[3:6, i] = body, reference.T @ np.array(inertial)
            zones[6:, i] = math.cos(half_angle), sign, penalty
        self.values = {
            "J": self.J, "S1": turned[0], "T1": turned[1],
            "S2": half_trace_minus(np.array(drawn["stage_momentum"])),
            "T2": half_trace_minus(np.array(drawn["terminal_momentum"])),
            "D": half_trace_minus(effort) if m == 3 else effort[0, 0] * np.eye(m),
            "B": self.B, "limit": drawn["limit"], "scale": self.scale,
            "penalty": drawn["penalty"] if drawn["limit"] > 0.0 else 0.0,
            "cost_scale": 1.0, "zones": zones,
        }  # fmt: skip
        self.program = program(n, m)
        self.momentum = np.array(drawn["momentum"])
        e = quaternion(reference.T @ np.array(drawn["attitude"]))
        self.start = np.concatenate([e, self.rodrigues(0.5 * self.momentum)])
        self.parameters = self.program.pack(self.values)

    def rodrigues(self, b: Array) -> Array:
        """Return g of b(g) = b; raise ArithmeticError where no step exists."""
        J, g = self.J, np.linalg.solve(self.J, b)
        for _ in range(50):
            Jg, size = J @ g, 1.0 + g @ g
            mismatch = Jg + np.cross(g, Jg) - size * b
            slope = J + hat(g) @ J - hat(Jg) - 2.0 * np.outer(b, g)
            change = np.linalg.solve(slope, mismatch)
            largest = np.abs(change).max()
            g = g - change * min(1.0, 0.5 / largest) if largest > 0.0 else g
            if largest <= 1e-15 * np.abs(g).max():
                break
        else:
            if not largest <= 1e-13 * np.abs(g).max():
                raise ArithmeticError("the integrator's equation has no solution")
        self._require_principal(g)
        return g

    def _require_principal(self, g: Array) -> None:
        """Require F Jd + Jd F^T > 0: the solution that goes to zero with the momentum."""
        G = hat(g)
        F = np.eye(3) + 2.0 / (1.0 + g @ g) * (G + G @ G)
        Jd = 0.5 * np.trace(self.J) * np.eye(3) - self.J
        if np.linalg.eigvalsh(F @ Jd + Jd @ F.T)[0] <= 0.0:
            raise ArithmeticError("the body turns too far in one step")

    def rollout(self, v: Array) -> Array:
        """Return the states (N + 1, 7) under controls (N, m); the last holds h Pi / 2 for g."""
        states = [self.start]
        for k, control in enumerate(v):
            e, g = states[-1][:4], states[-1][4:]
            root, Jg = 1.0 + g @ g, self.J @ g
            turned = np.concatenate(
                [[e[0] - e[1:] @ g], e[1:] + e[0] * g + np.cross(e[1:], g)]
            ) / math.sqrt(root)
            b = (Jg - np.cross(g, Jg)) / root + 0.5 * self.scale * (self.B @ control)
            last = b if k == len(v) - 1 else self.rodrigues(b)
            states.append(np.concatenate([turned / np.linalg.norm(turned), last]))
        return np.array(states)

    def cost(self, v: Array) -> tuple[float, float]:
        """Return the cost, and the part of it that the controls move: not of R_0, Pi_0 and R_1."""
        states = self.rollout(v)
        total = self.program.over_stages("cost", _stacked(states, v), self.parameters).sum()
        return float(total), float(total) - self._fixed(states)

    def _fixed(self, states: Array) -> float:
        """Cost of what no control moves."""
        p, fixed = self.values, 0.0
        for k in range(min(2, len(states))):
            e = states[k, :4]
            S1 = p["S1"] if k < len(states) - 1 else p["T1"]
            fixed += 4.0 * e[1:] @ S1 @ e[1:]
            if k < len(states) - 1:
                t = 2.0 * np.cross(e[1:], p["zones"][3:6].T)
                seen = p["zones"][3:6].T - e[0] * t + np.cross(e[1:], t)
                excess = p["zones"][7] * ((p["zones"][:3].T * seen).sum(1) - p["zones"][6])
                fixed += float(p["zones"][8] @ np.maximum(0.0, excess) ** 2)
        return float(fixed + self.momentum @ p["S2"] @ self.momentum)

    def newton(self, v: Array) -> tuple[Array, bool, float]:
        """Return Newton's correction of the controls, whether the Hessian is positive, the slope.

        The controls of a stage are counted along and across themselves, so that the stiff direction
        of the penalty is an axis and the factorization does not mix it with the others.
        """
        f, p, n, m = self.program, self.parameters, *v.shape
        states = self.rollout(v)
        w = _stacked(states, v)
        size = 2 * STATE + m
        slope = f.over_stages("slope", w, p)
        A = f.over_stages("jacobian", w, p).reshape(STATE, size, n, order="F")
        lam = np.zeros((STATE, n))
        ahead = slope[STATE + m :, n - 1]
        for k in reversed(range(n)):
            lam[:, k] = -np.linalg.solve(A[:, STATE + m :, k].T, ahead)
            if k > 0:
                ahead = slope[:STATE, k] + A[:, :STATE, k].T @ lam[:, k] + slope[STATE + m :, k - 1]
        gradient = slope[STATE : STATE + m] + np.einsum("iak,ik->ak", A[:, STATE : STATE + m], lam)
        H = f.over_stages("hessian", w, p, np.ones((1, n)), lam).reshape(size, size, n, order="F")
        frames = [_frame(control) for control in v]
        hessian, moved = np.zeros((n * m, n * m)), np.zeros((STATE, n * m))
        for k in range(n):
            own = np.zeros((m, n * m))
            own[:, k * m : (k + 1) * m] = frames[k]
            pushed = A[:, :STATE, k] @ moved + A[:, STATE : STATE + m, k] @ own
            following = -np.linalg.solve(A[:, STATE + m :, k], pushed)
            Z = np.concatenate([moved, own, following])
            hessian += Z.T @ H[:, :, k] @ Z
            moved = following
        turned = np.concatenate([frames[k].T @ gradient[:, k] for k in range(n)])
        scale = np.sqrt(np.abs(np.diag(hessian)))
        scale[scale == 0.0] = 1.0
        scaled = hessian / np.outer(scale, scale)
        try:
            np.linalg.cholesky(scaled)
            positive = True
        except np.linalg.LinAlgError:
            positive = False
        correction = -np.linalg.solve(scaled, turned / scale) / scale
        steps = np.array([frames[k] @ correction[k * m : (k + 1) * m] for k in range(n)])
        return steps, positive, float(turned @ correction)


def _stacked(states: Array, v: Array) -> Array:
    return np.concatenate([states[:-1].T, v.T, states[1:].T])


def _frame(v: Array) -> Array:
    """Return an orthogonal matrix whose first column is along v."""
    size = np.linalg.norm(v)
    if size == 0.0:
        return np.eye(len(v))
    x = v / size
    x[0] += math.copysign(1.0, x[0])
    return np.eye(len(v)) - 2.0 * np.outer(x, x) / (x @ x)
