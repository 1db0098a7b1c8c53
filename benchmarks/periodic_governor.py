"""Sets and steps of the periodic governor at the scale of docking, and QP solvers side by side.

nice python benchmarks/periodic_governor.py [--steps N]

A rigid deputy beside a chief that turns once in 1000 s about a tilted axis: 12 states, 6 references
(port offset, attitude), 200 steps of 5 s, 70 rows a step. Linear throughout: the state is what the
governor believes. Solvers that are not installed are left out.
"""

from __future__ import annotations

import argparse
import importlib
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.linalg import expm

from spacecraft_gnc import lie
from spacecraft_gnc.governors.periodic import (
    PeriodicConstraints,
    PeriodicGovernor,
    PeriodicLoop,
    cached_sets,
    qp,
)

P, STEP, MASS, ORBIT = 200, 5.0, 130.0, 0.0012  # steps, s, kg, rad/s
INERTIA = MASS / 12.0 * np.diag([1.0, 1.0, 0.72])  # of a cuboid 0.6 x 0.6 x 0.8 m
SPIN = 2.0 * np.pi / (P * STEP) * np.array([np.sin(0.5), 0.0, np.cos(0.5)])
PORT = np.array([-0.3, 0.0, 0.1])
VERTICES = np.array([[x, y, z] for x in (-0.3, 0.3) for y in (-0.3, 0.3) for z in (-0.4, 0.4)])
START = np.array([20.0, 4.0, -3.0, 0.0, 0.0, 0.0, 0.3, -0.2, 0.25, 0.0, 0.0, 0.0])
WEIGHT = np.array([1.0, 1.0, 1.0, 100.0, 100.0, 100.0])


def continuous(t: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the linear relative motion in the chief's frame: position, velocity, angle, rate."""
    turn, spin = lie.exp(SPIN * t), lie.hat(SPIN)
    tide = turn.T @ np.diag([3.0, 0.0, -1.0]) @ turn * ORBIT**2
    coriolis = turn.T @ (-2.0 * ORBIT * lie.hat(np.array([0.0, 0.0, 1.0]))) @ turn
    a, b = np.zeros((12, 12)), np.zeros((12, 6))
    a[:3, 3:6] = a[6:9, 9:] = np.eye(3)
    a[3:6, :3], a[3:6, 3:6] = tide + coriolis @ spin - spin @ spin, coriolis - 2.0 * spin
    a[6:9, 6:9] = -spin
    a[9:, 9:] = np.linalg.solve(INERTIA, lie.hat(INERTIA @ SPIN) - spin @ INERTIA)
    b[3:6, :3], b[9:, 3:] = np.eye(3) / MASS, np.linalg.inv(INERTIA)
    return a, b


def discrete() -> list[tuple[np.ndarray, np.ndarray]]:
    """Return (A_k, B_k) of every step."""
    found = []
    for k in range(P):
        a, b = continuous((k + 0.5) * STEP)
        both = expm(STEP * np.block([[a, b], [np.zeros((6, 18))]]))
        found.append((both[:12, :12], both[:12, 12:]))
    return found


def problem() -> tuple[PeriodicLoop, PeriodicConstraints]:
    """Return the loop under periodic LQ feedback, and its constraints."""
    plant = discrete()
    q = np.diag(np.repeat([0.01, 1.0, 0.1, 10.0], 3))
    r = np.diag(np.repeat([1.0, 100.0], 3))
    cost, gains = q.copy(), [np.empty(0)] * P
    for k in range(4 * P - 1, -1, -1):
        a, b = plant[k % P]
        gains[k % P] = gain = np.linalg.solve(r + b.T @ cost @ b, b.T @ cost @ a)
        cost = q + a.T @ cost @ (a - b @ gain)
        cost = 0.5 * (cost + cost.T)
    target = np.zeros((12, 6))
    target[:3, :3] = target[6:9, 3:] = np.eye(3)
    maps, feeds, rows, through, bounds = [], [], [], [], []
    for (a, b), gain in zip(plant, gains, strict=True):
        feed = gain @ target + np.linalg.lstsq(b, target - a @ target, rcond=None)[0]
        maps.append(a - b @ gain)
        feeds.append(b @ feed)
        on_state, limits = state_rows()
        controls = np.vstack([np.hstack([-gain, feed]), np.hstack([gain, -feed])])
        rows.append(np.vstack([controls[:, :12], on_state]))
        through.append(np.vstack([controls[:, 12:], np.zeros((len(on_state), 6))]))
        bounds.append([*(([1.0] * 3 + [0.05] * 3) * 2), *limits])
    names = tuple(f"row {i}" for i in range(len(bounds[0])))
    loop = PeriodicLoop(np.array(maps), np.array(feeds))
    return loop, PeriodicConstraints(np.array(rows), np.array(through), np.array(bounds), names)


def state_rows() -> tuple[np.ndarray, list[float]]:
    """Return 58 rows on the state: vertices off the face, line of sight, angles and rates."""
    rows, bounds = [], []
    for vertex in VERTICES:
        arm = vertex - PORT
        of_vertex = np.zeros((3, 12))
        of_vertex[:, :3], of_vertex[:, 6:9] = np.eye(3), -lie.hat(arm)
        rows.append(-of_vertex[0])
        bounds.append(arm[0] + 0.02)
        for axis, sign in ((1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)):
            rows.append(sign * of_vertex[axis] - np.tan(np.pi / 6.0) * of_vertex[0])
            bounds.append(np.tan(np.pi / 6.0) * arm[0] + 1.0)
    for i, limit in zip(
        (3, 4, 5, 6, 7, 8, 9, 10, 11), [0.5] * 3 + [0.8] * 3 + [0.05] * 3, strict=True
    ):
        rows += [np.eye(12)[i], -np.eye(12)[i]]
        bounds += [limit, limit]
    return np.array(rows), bounds


def fly(governor: PeriodicGovernor, loop: PeriodicLoop, steps: int) -> tuple[list, list]:
    """Return the times of the steps [s], and the programs solved on the way."""
    x, times, programs = START.copy(), [], []
    for k in range(steps):
        begun = time.perf_counter()
        decision = governor.decide(k, x, np.zeros(6))
        times.append(time.perf_counter() - begun)
        o = governor.sets.at(k)
        acts = np.linalg.norm(o.reference_rows, axis=1) > 1e-9
        programs.append((o.reference_rows[acts], (o.bounds - o.state_rows @ x)[acts]))
        x = loop.step(k, x, decision.reference)
    return times, programs


def by_daqp(h: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve as the governor does."""
    return qp.nearest_reference(qp.Weight(WEIGHT), np.zeros(6), h, b).reference


def by_piqp(h: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve with PIQP at 1e-9."""
    import piqp

    solver = piqp.DenseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-9
    solver.setup(np.diag(WEIGHT), np.zeros(6), None, None, h, np.full(len(b), -np.inf), b)
    solver.solve()
    return np.array(solver.result.x)


def by_clarabel(h: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve with Clarabel at 1e-9."""
    import clarabel
    from scipy.sparse import csc_matrix

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-9
    cones = [clarabel.NonnegativeConeT(len(b))]
    solver = clarabel.DefaultSolver(
        csc_matrix(np.diag(WEIGHT)), np.zeros(6), csc_matrix(h), b, cones, settings
    )
    return np.array(solver.solve().x)


def by_osqp(h: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve with OSQP at 1e-6, polished."""
    import osqp
    from scipy.sparse import csc_matrix

    solver = osqp.OSQP()
    solver.setup(
        csc_matrix(np.diag(WEIGHT)), np.zeros(6), csc_matrix(h), np.full(len(b), -np.inf), b,
        verbose=False, eps_abs=1e-6, eps_rel=1e-6, max_iter=20000, polishing=True,
    )  # fmt: skip
    return np.array(solver.solve().x)


def by_highs(h: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Solve with the active-set method of HiGHS."""
    import highspy

    model, count = highspy.HighsModel(), len(b)
    lp, free = model.lp_, highspy.kHighsInf
    lp.num_col_, lp.num_row_, lp.col_cost_ = 6, count, np.zeros(6)
    lp.col_lower_, lp.col_upper_ = np.full(6, -free), np.full(6, free)
    lp.row_lower_, lp.row_upper_ = np.full(count, -free), b
    lp.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    lp.a_matrix_.start_ = np.arange(0, 6 * count + 1, 6)
    lp.a_matrix_.index_, lp.a_matrix_.value_ = np.tile(np.arange(6), count), h.ravel()
    model.hessian_.dim_, model.hessian_.format_ = 6, highspy.HessianFormat.kTriangular
    model.hessian_.start_, model.hessian_.index_ = np.arange(7), np.arange(6)
    model.hessian_.value_ = WEIGHT
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.passModel(model)
    solver.run()
    return np.array(solver.getSolution().col_value)


SOLVERS: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "daqp": by_daqp, "piqp": by_piqp, "clarabel": by_clarabel, "osqp": by_osqp, "highspy": by_highs,
}  # fmt: skip


def compare(programs: list) -> None:
    """Print times, and what the answers miss: the distance to DAQP's, and broken rows."""
    exact = [by_daqp(h, b) for h, b in programs]
    for name, solve in SOLVERS.items():
        try:
            importlib.import_module(name)
        except ModuleNotFoundError:
            continue
        times, far, broken = [], 0.0, 0.0
        for (h, b), v in zip(programs, exact, strict=True):
            begun = time.perf_counter()
            found = solve(h, b)
            times.append(1e3 * (time.perf_counter() - begun))
            far = max(far, np.abs(found - v).max())
            broken = max(broken, float((h @ found - b).max()))
        print(
            f"{name:9s} median {np.median(times):8.3f} ms  longest {max(times):8.2f} ms  "
            f"off daqp {far:.1e}  rows broken by {broken:.1e}"
        )


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--steps", type=int, default=200, help="control steps flown")
    steps = parser.parse_args().steps
    loop, constraints = problem()
    print(f"spectral radius a step {loop.spectral_radius ** (1.0 / P):.4f}, ", end="")
    print(f"rows a step {constraints.bounds.shape[1]}")
    with TemporaryDirectory() as folder:
        for _ in range(2):
            begun = time.perf_counter()
            sets = cached_sets(loop, constraints, folder=Path(folder))
            print(f"sets in {time.perf_counter() - begun:.3f} s")
    rows = [len(o.bounds) for o in sets.sets]
    print(
        f"determined {sets.determined}, {sets.steps} backward steps, horizon {sets.horizon}, ",
        end="",
    )
    print(f"rows {min(rows)} to {max(rows)}")
    begun = time.perf_counter()
    governor = PeriodicGovernor(sets, WEIGHT)
    print(f"governor in {time.perf_counter() - begun:.3f} s")
    times, programs = fly(governor, loop, steps)
    print(
        f"governor step: median {1e3 * np.median(times):.3f} ms, longest {1e3 * max(times):.2f} ms"
    )
    compare(programs)


if __name__ == "__main__":
    main()
