"""Write test/data/terminal_set_ipopt.npz: terminal-set problems and their optima by IPOPT.

Needs only CasADi, numpy and `ipopt_reference.py` beside it: run
`python tools/ipopt_terminal_reference.py` in a separate environment. The problem of Kalabic et
al. 2014, (24)-(32), by multiple shooting, with the torque limit and the terminal set as inequality
constraints. The logarithm is that of a quaternion carried along the horizon, so its angle is
continuous; the Riccati equation (27) is iterated to its fixed point.
"""
# ruff: noqa: N803, N806 - the symbols are the paper's

from __future__ import annotations

import casadi as ca
import numpy as np
from ipopt_reference import OPTIONS, free_step, relative_rotation, rotation, symmetric

TARGET_NAME = "terminal_set_ipopt.npz"
N_PROBLEMS, LARGEST_HORIZON, SEED = 18, 20, 2014
KINDS = ("free", "border", "kappa")
TIGHT = OPTIONS | {
    "ipopt": OPTIONS["ipopt"]
    | {
        "bound_relax_factor": 0.0,
        "tol": 1e-10,
        "dual_inf_tol": 1e-9,
        "compl_inf_tol": 1e-11,
        "constr_viol_tol": 1e-11,
    }
}
PAPER = {
    "inertia": np.diag([10.0, 8.0, 8.0]), "time_step": 0.1, "horizon": 251,
    "stage_attitude": np.eye(3), "stage_rate": np.diag([3.0, 5.0, 5.0]),
    "stage_torque": 1000.0 * np.eye(3), "stage_cost_scale": 0.1, "max_torque": 0.02,
    "momentum": np.zeros(3), "reference": np.eye(3),
}  # fmt: skip


def trace_minus(weight):
    """Return tr(Q) I - Q."""
    return np.trace(weight) * np.eye(3) - weight


def controller(p):
    """Return P and K of (27) and (28), by iterating the Riccati equation."""
    h, inverse, zero = p["time_step"], np.linalg.inv(p["inertia"]), np.zeros((3, 3))
    A = np.block([[np.eye(3), h * inverse], [zero, np.eye(3)]])
    B = np.vstack([zero, h * np.eye(3)])
    rate = inverse @ trace_minus(p["stage_rate"]) @ inverse
    Q = np.block([[trace_minus(p["stage_attitude"]), zero], [zero, rate]])
    P, change = Q, 1.0
    while change > 1e-15:
        K = -np.linalg.solve(p["stage_torque"] + B.T @ P @ B, B.T @ P @ A)
        new = A.T @ P @ (A + B @ K) + Q
        new = 0.5 * (new + new.T)
        P, change = new, np.abs(new - P).max() / np.abs(new).max()
    return P, K


def draw(rng, near):
    """Return the data of one problem: plain numbers and arrays; ``near``: almost on target."""
    a, b, c = rng.uniform(0.3, 1.0, 3)
    momentum = rng.normal(size=3)
    momentum *= rng.uniform(0.0, 0.01 if near else 0.3) / np.linalg.norm(momentum)
    reference = rotation(rng)
    turn = np.array(ca.DM(relative_rotation(ca.DM(0.05 * rng.normal(size=3)))))
    return {
        "inertia": symmetric(rng, [b + c, a + c, a + b]),
        "time_step": rng.choice([0.1, 0.2]), "horizon": rng.integers(2, LARGEST_HORIZON + 1),
        "stage_attitude": symmetric(rng, 10.0 ** rng.uniform(-1, 1, 3)),
        "stage_rate": symmetric(rng, 10.0 ** rng.uniform(-1, 1, 3)),
        "stage_torque": symmetric(rng, 10.0 ** rng.uniform(0, 2, 3)),
        "stage_cost_scale": 0.1, "max_torque": rng.choice([0.0, 0.02, 0.1, 0.5]),
        "attitude": reference @ turn if near else rotation(rng), "reference": reference,
        "momentum": momentum,
    }  # fmt: skip


def quaternion(R):
    """Return the unit quaternion (w, q), w >= 0, of a rotation short of half a turn."""
    w = 0.5 * np.sqrt(1.0 + np.trace(R))
    return w, np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / (4.0 * w)


def terminal_level(P, n, C, Pi, w, v):
    """Return |(Z, Pi)|_P^2, with Z of the quaternion (w, v), of an angle up to two half turns."""
    if n > LARGEST_HORIZON:  # too long a product; the paper's flight stays short of half a turn
        w = 0.5 * ca.sqrt(1.0 + ca.trace(C))
        v = ca.inv_skew(C - C.T) / (4.0 * w)
    sine = ca.sqrt(ca.dot(v, v))
    x = ca.vertcat(2.0 * ca.atan2(sine, w) / sine * v, Pi)
    return x.T @ P @ x


def solve(p, P, c):
    """Return IPOPT's torques (N, 3), cost, terminal level, and whether it converged."""
    h, n, scale = float(p["time_step"]), int(p["horizon"]), p["stage_cost_scale"]
    Jd = 0.5 * np.trace(p["inertia"]) * np.eye(3) - p["inertia"]
    unknowns, start, constraints, bounded, cost = [], [], [], [], 0.0

    def unknown(name, rows, columns, value):
        symbol = ca.SX.sym(name, rows, columns)
        unknowns.append(ca.vec(symbol))
        start.append(np.asarray(value).ravel(order="F"))
        return symbol

    at, at_momentum = p["reference"].T @ p["attitude"], p["momentum"]  # the free motion
    w, v = quaternion(at)
    C, Pi, torques = ca.SX(at), ca.SX(at_momentum), []
    for k in range(n):
        guess = free_step(p["inertia"], Jd, h, at_momentum)
        turned = np.array(ca.DM(relative_rotation(ca.DM(guess))))
        at, at_momentum = at @ turned, turned.T @ at_momentum
        u, f = unknown(f"u{k}", 3, 1, np.zeros(3)), unknown(f"f{k}", 3, 1, guess)
        F = relative_rotation(f)
        constraints.append(ca.inv_skew(F @ Jd - Jd @ F.T) - h * Pi)
        stage = ca.trace(p["stage_attitude"] @ (np.eye(3) - C))
        stage += ca.trace(p["stage_rate"] @ (np.eye(3) - F)) / h**2
        cost += scale * (stage + 0.5 * u.T @ p["stage_torque"] @ u)
        if p["max_torque"] > 0.0:
            bounded.append(ca.dot(u, u) / p["max_torque"] ** 2 - 1.0)
        C_next, Pi_next = unknown(f"C{k}", 3, 3, at), unknown(f"P{k}", 3, 1, at_momentum)
        constraints += [ca.vec(C_next - C @ F), Pi_next - F.T @ Pi - h * u]
        C, Pi = C_next, Pi_next
        norm = ca.sqrt(1.0 + ca.dot(f, f))
        w, v = (w - ca.dot(v, f)) / norm, (w * f + v + ca.cross(v, f)) / norm
        torques.append(u)
    level = terminal_level(P, n, C, Pi, w, v)
    cost += 0.5 * level
    if np.isfinite(c):
        bounded.append(level / c - 1.0)
    every, g = ca.vertcat(*unknowns), ca.vertcat(*constraints, *bounded)
    solver = ca.nlpsol("ipopt", "ipopt", {"x": every, "f": cost, "g": g}, TIGHT)
    lower = np.concatenate([np.zeros(g.shape[0] - len(bounded)), np.full(len(bounded), -np.inf)])
    found = solver(x0=np.concatenate(start), lbg=lower, ubg=0.0)
    read = ca.Function("read", [every], [ca.horzcat(*torques).T, level])
    u, reached = (np.array(value) for value in read(found["x"]))
    solved = solver.stats()["return_status"] == "Solve_Succeeded"
    return u, float(found["f"]), float(reached.item()), solved


def kappa_level(p, P, K):
    """Return the largest c with |K x| <= max_torque wherever x . P x <= c."""
    return p["max_torque"] ** 2 / np.linalg.eigvalsh(K @ np.linalg.solve(P, K.T))[-1]


def main():
    """Draw, solve and write."""
    from ipopt_reference import TARGET

    rng = np.random.default_rng(SEED)
    rows = []
    while len(rows) < N_PROBLEMS:
        kind = KINDS[len(rows) % len(KINDS)]
        problem = draw(rng, kind == "kappa")
        P, K = controller(problem)
        u, cost, reached, solved = solve(problem, P, np.inf)
        c = np.inf
        if solved and kind != "free":
            limited = kind == "kappa" and problem["max_torque"] > 0.0
            c = kappa_level(problem, P, K) if limited else rng.uniform(0.9, 0.999) * reached
            if c > reached or (kind == "kappa" and not limited):
                continue
            u, cost, reached, solved = solve(problem, P, c)
        print(len(rows), kind, problem["horizon"], problem["max_torque"], cost, c, reached, solved)
        if solved:
            padded = np.full((LARGEST_HORIZON, 3), np.nan)
            padded[: len(u)] = u
            rows.append(problem | {"level": c, "torque": padded, "cost": cost})
    arrays = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    angle = np.radians(57.0)
    hat = np.array([[0.0, 0.0, 0.6], [0.0, 0.0, -0.8], [-0.6, 0.8, 0.0]])
    paper = PAPER | {"attitude": np.eye(3) + np.sin(angle) * hat + (1 - np.cos(angle)) * hat @ hat}
    P, K = controller(paper)
    u, cost, reached, solved = solve(paper, P, kappa_level(paper, P, K))
    print("paper, N = 251", cost, reached, solved)
    arrays |= {"paper_torque": u, "paper_cost": cost}
    np.savez_compressed(TARGET.with_name(TARGET_NAME), **arrays)


if __name__ == "__main__":
    main()
