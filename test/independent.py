"""Independent implementation of Gupta's problem in plain numpy, also for complex numbers.

It shares no code with the package: F comes from Newton on the printed matrix equation, the
costates from (34)-(38) as printed, the cost from (27)-(30) with Frobenius norms.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import expm


def hat(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def vee(m):
    return 0.5 * np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])


def cayley(f):
    """Rotation (I + hat(f)) (I - hat(f))^-1, analytic in f."""
    return (np.eye(3) + hat(f)) @ np.linalg.inv(np.eye(3) - hat(f))


class Problem:
    """Data of one problem; ``zones`` are (v, w, beta, mu) of (30): H = beta - v . R^T w.

    The reference turns at ``omega`` with the torque ``tau``, both in its own frame, as the
    integrator carries it on. Its momentum is the one with which the integrator makes that turn, by
    the matrix equation, and half a step of what accelerates it; its torque, too, is the
    integrator's.
    """

    def __init__(
        self, J, h, N, Q1, Q2, Q3, P1, P2, alpha, mu0, zones, R_ref,
        omega=(0.0, 0.0, 0.0), tau=(0.0, 0.0, 0.0),
    ):  # fmt: skip
        self.J, self.h, self.N = J, h, N
        self.Q1, self.Q2, self.Q3, self.P1, self.P2 = Q1, Q2, Q3, P1, P2
        self.alpha, self.mu0, self.zones = alpha, mu0, zones
        self.Jd = 0.5 * np.trace(J) * np.eye(3) - J
        omega = np.asarray(omega)
        F = expm(h * hat(omega))
        Pi_ref = vee(F @ self.Jd - self.Jd @ F.T) / h
        beyond = np.asarray(tau) - np.cross(omega, J @ omega)
        self.u_ref = (Pi_ref - F.T @ Pi_ref) / h + beyond
        self.references = self.rollout(R_ref, Pi_ref + 0.5 * h * beyond, [self.u_ref] * N)

    def relative_rotation(self, Pi):
        """F of h hat(Pi) = F Jd - Jd F^T by Newton on its Cayley vector."""
        f = 0.5 * self.h * np.linalg.solve(self.J, Pi)
        for _ in range(60):
            F = cayley(f)
            g = 2.0 * vee(F @ self.Jd) - self.h * Pi
            derivative = np.empty((3, 3), dtype=np.result_type(f, 1.0))
            inverse = np.linalg.inv(np.eye(3) - hat(f))
            for i in range(3):
                dF = (hat(np.eye(3)[i]) + F @ hat(np.eye(3)[i])) @ inverse
                derivative[:, i] = 2.0 * vee(dF @ self.Jd)
            change = np.linalg.solve(derivative, g)
            f = f - change
            if np.abs(change).max() < 1e-15:
                break
        return cayley(f)

    def rollout(self, R, Pi, u):
        states = [(R, Pi)]
        for k in range(self.N):
            F = self.relative_rotation(Pi)
            R, Pi = R @ F, F.T @ Pi + self.h * u[k]
            states.append((R, Pi))
        return states

    def cost(self, R, Pi, u):
        def frobenius(Q, A):
            return 0.5 * np.trace(A.T @ Q @ A)

        states = self.rollout(R, Pi, u)
        h, total = self.h, 0.0
        for k in range(self.N):
            R_k, Pi_k = states[k]
            total = total + h * (
                frobenius(self.Q1, R_k - self.references[k][0])
                + frobenius(self.Q2, hat(Pi_k - self.references[k][1]))
                + frobenius(self.Q3, hat(u[k] - self.u_ref))
            )
            H0 = 0.5 * np.trace(hat(u[k]).T @ hat(u[k])) - self.alpha
            if self.alpha > 0.0 and H0.real > 0.0:
                total = total + h * self.mu0 * H0**2
            for v, w, beta, mu in self.zones:
                H = beta - v @ (R_k.T @ w)
                if H.real > 0.0:
                    total = total + h * mu * H**2
        R_N, Pi_N = states[-1]
        R_ref, Pi_ref = self.references[-1]
        ends = frobenius(self.P1, R_N - R_ref) + frobenius(self.P2, hat(Pi_N - Pi_ref))
        return total + ends

    def residual(self, R, Pi, lam):
        """Residual (44) after running (31)-(38) forward from multipliers lam (6,)."""
        h, l1, l2 = self.h, lam[:3], lam[3:]
        for k in range(self.N):
            F = self.relative_rotation(Pi)
            if k > 0:
                R_ref, Pi_ref = self.references[k]
                g = -h * vee(R.T @ self.Q1 @ R_ref)
                for v, w, beta, mu in self.zones:
                    H = beta - v @ (R.T @ w)
                    if H.real > 0.0:
                        g = g - mu * vee(R.T @ (2.0 * h * H * np.outer(w, v)))
                M = h * F.T @ np.linalg.inv(np.trace(F @ self.Jd) * np.eye(3) - F @ self.Jd)
                l1 = F.T @ (l1 + g)
                right = -M.T @ l1 + l2 + h * vee(self.Q2 @ hat(Pi - Pi_ref))
                l2 = np.linalg.solve(F - M.T @ hat(F.T @ Pi), right)
            R, Pi = R @ F, F.T @ Pi + h * self.control(l2)
        R_ref, Pi_ref = self.references[-1]
        end = vee(R.T @ self.P1 @ R_ref)
        return np.concatenate([l1 - end, l2 + vee(self.P2 @ hat(Pi - Pi_ref))])

    def control(self, l2):
        """u of (38) by Newton on its three equations, from the real solution."""
        S3 = 0.5 * (np.trace(self.Q3) * np.eye(3) - self.Q3)
        l2 = l2 + S3 @ self.u_ref
        u = np.linalg.solve(S3, l2)
        if self.alpha <= 0.0 or (u @ u).real <= self.alpha:
            return u
        u = u * np.sqrt(self.alpha / (u @ u))
        for _ in range(200):
            H0 = u @ u - self.alpha
            g = S3 @ u + 2.0 * self.mu0 * H0 * u - l2
            slope = S3 + 2.0 * self.mu0 * (H0 * np.eye(3) + 2.0 * np.outer(u, u))
            change = np.linalg.solve(slope, g)
            u = u - change
            if np.abs(change).max() < 1e-17:
                break
        return u
