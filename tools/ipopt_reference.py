"""Write test/data/random_ipopt.npz: random problems and their optima by CasADi and IPOPT.

Needs only CasADi and numpy, not this package: run `python tools/ipopt_reference.py` in a separate
environment. The problem of Gupta et al. 2015, (27)-(30), by multiple shooting: besides the torques,
the attitudes, momenta and Cayley vectors of the relative rotations are unknowns, and
h hat(Pi) = F Jd - Jd F^T is a constraint; cost and penalties are written with Frobenius norms.
"""
# ruff: noqa: N803, N806 - the symbols are the paper's

from __future__ import annotations

from pathlib import Path

import casadi as ca
import numpy as np

TARGET = Path(__file__).resolve().parents[1] / "test" / "data" / "random_ipopt.npz"
N_PROBLEMS, LARGEST_HORIZON, SEED = 40, 30, 2015
WEIGHTS = {  # decades of the eigenvalues
    "stage_attitude": (-3, 0), "stage_momentum": (-3, 0), "stage_torque": (-1, 1),
    "terminal_attitude": (-3, 0), "terminal_momentum": (-3, 0),
}  # fmt: skip
OPTIONS = {
    "print_time": False,
    "ipopt": {
        "tol": 1e-12, "constr_viol_tol": 1e-13, "dual_inf_tol": 1e-12, "max_iter": 3000,
        "nlp_scaling_method": "none", "print_level": 0, "sb": "yes", "acceptable_iter": 0,
    },
}  # fmt: skip


def rotation(rng):
    """Return a rotation, uniform over the group."""
    w, x, y, z = rng.normal(size=4)
    w, x, y, z = np.array([w, x, y, z]) / np.sqrt(w * w + x * x + y * y + z * z)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def symmetric(rng, diagonal):
    """Return a symmetric matrix with given eigenvalues."""
    axes = rotation(rng)
    matrix = axes @ np.diag(diagonal) @ axes.T
    return 0.5 * (matrix + matrix.T)


def draw(rng):
    """Return the data of one problem: plain numbers and arrays."""
    a, b, c = rng.uniform(0.2, 1.0, 3)
    problem = {"inertia": symmetric(rng, [b + c, a + c, a + b])}
    for name, decades in WEIGHTS.items():
        problem[name] = symmetric(rng, 10.0 ** rng.uniform(*decades, 3))
    momentum = rng.normal(size=3)
    zones = np.full((2, 8), np.nan)  # body axis, inertial axis, half-angle [rad], penalty
    for row in zones[: rng.integers(0, 3)]:
        body, inertial = rng.normal(size=3), rng.normal(size=3)
        row[:3], row[3:6] = body / np.linalg.norm(body), inertial / np.linalg.norm(inertial)
        row[6:] = rng.uniform(0.2, 1.0), 10.0 ** rng.uniform(0.0, 2.0)
    return problem | {
        "time_step": rng.choice([0.1, 0.2, 0.4]), "horizon": rng.integers(2, LARGEST_HORIZON + 1),
        "max_torque": rng.choice([0.0, 0.01, 0.1, 0.5]), "torque_penalty": 10 ** rng.uniform(3, 6),
        "zones": zones, "attitude": rotation(rng), "reference": rotation(rng),
        "momentum": momentum * rng.uniform(0.0, 0.5) / np.linalg.norm(momentum),
    }  # fmt: skip


def half_square(weight, matrix):
    """Return |weight^(1/2) matrix|_F^2 / 2."""
    return 0.5 * ca.trace(matrix.T @ weight @ matrix)


def relative_rotation(f):
    """Return the rotation of a Cayley vector f, of length tan(angle / 2)."""
    scale = 2.0 / (1.0 + ca.dot(f, f))
    return ca.DM.eye(3) + scale * (ca.skew(f) + ca.skew(f) @ ca.skew(f))


def stage(p, R, Pi, u):
    """Return the stage cost (27) with the penalties."""
    cost = half_square(p["stage_attitude"], R - p["reference"])
    cost += half_square(p["stage_momentum"], ca.skew(Pi))
    cost += half_square(p["stage_torque"], ca.skew(u))
    if p["max_torque"] > 0.0:
        cost += p["torque_penalty"] * ca.fmax(0.0, ca.dot(u, u) - p["max_torque"] ** 2) ** 2
    for row in p["zones"]:
        if np.isfinite(row).all():
            inside = ca.dot(row[:3], R.T @ row[3:6]) - np.cos(row[6])
            cost += row[7] * ca.fmax(0.0, inside) ** 2
    return p["time_step"] * cost


def solve(p):
    """Return IPOPT's torques (N, 3), cost, and whether it converged."""
    h, n = float(p["time_step"]), int(p["horizon"])
    Jd = 0.5 * np.trace(p["inertia"]) * np.eye(3) - p["inertia"]
    unknowns, start, constraints, cost = [], [], [], 0.0

    def unknown(name, rows, columns, value):
        symbol = ca.SX.sym(name, rows, columns)
        unknowns.append(ca.vec(symbol))
        start.append(np.asarray(value).ravel(order="F"))
        return symbol

    R, Pi = ca.SX(p["attitude"]), ca.SX(p["momentum"])
    at, at_momentum = p["attitude"], p["momentum"]  # the start: the free motion, u = 0
    torques = []
    for k in range(n):
        guess = free_step(p["inertia"], Jd, h, at_momentum)
        turned = np.array(ca.DM(relative_rotation(ca.DM(guess))))
        at, at_momentum = at @ turned, turned.T @ at_momentum
        u, f = unknown(f"u{k}", 3, 1, np.zeros(3)), unknown(f"f{k}", 3, 1, guess)
        F = relative_rotation(f)
        constraints.append(ca.inv_skew(F @ Jd - Jd @ F.T) - h * Pi)
        cost += stage(p, R, Pi, u)
        R_next, Pi_next = unknown(f"R{k}", 3, 3, at), unknown(f"P{k}", 3, 1, at_momentum)
        constraints += [ca.vec(R_next - R @ F), Pi_next - F.T @ Pi - h * u]
        R, Pi = R_next, Pi_next
        torques.append(u)
    cost += half_square(p["terminal_attitude"], R - p["reference"])
    cost += half_square(p["terminal_momentum"], ca.skew(Pi))
    x, g = ca.vertcat(*unknowns), ca.vertcat(*constraints)
    solver = ca.nlpsol("ipopt", "ipopt", {"x": x, "f": cost, "g": g}, OPTIONS)
    found = solver(x0=np.concatenate(start), lbg=0.0, ubg=0.0)
    u = np.array(ca.Function("u", [x], [ca.horzcat(*torques).T])(found["x"]))
    return u, float(found["f"]), solver.stats()["return_status"] == "Solve_Succeeded"


def free_step(inertia, Jd, h, momentum):
    """Return the Cayley vector of one step at a given momentum, by Newton with differences."""

    def mismatch(f):
        F = np.array(ca.DM(relative_rotation(ca.DM(f))))
        a = F @ Jd - Jd @ F.T
        return np.array([a[2, 1], a[0, 2], a[1, 0]]) - h * momentum

    f = 0.5 * h * np.linalg.solve(inertia, momentum)
    for _ in range(8):
        ahead, behind = ([mismatch(f + s * e) for e in np.eye(3)] for s in (1e-6, -1e-6))
        f = f - np.linalg.solve((np.array(ahead) - np.array(behind)).T / 2e-6, mismatch(f))
    return f


def main():
    """Draw, solve and write."""
    rng = np.random.default_rng(SEED)
    rows = []
    while len(rows) < N_PROBLEMS:
        problem = draw(rng)
        u, cost, solved = solve(problem)
        print(len(rows), problem["horizon"], problem["max_torque"], cost, solved)
        if solved:
            padded = np.full((LARGEST_HORIZON, 3), np.nan)
            padded[: len(u)] = u
            rows.append(problem | {"torque": padded, "cost": cost})
    np.savez_compressed(TARGET, **{name: np.array([row[name] for row in rows]) for name in rows[0]})


if __name__ == "__main__":
    main()
