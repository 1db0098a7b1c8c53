"""Sets and steps of the periodic governor at the scale of docking, and QP solvers side by side.

nice python benchmarks/periodic_governor.py [--steps N] [--period P] [--within N]

A rigid deputy beside a chief that turns once in 1000 s about a tilted axis: 12 states, 6 references
(port offset, attitude), 200 steps of 5 s; force, moment, line of sight, 8 vertices. Linear
throughout: the state is what the governor believes. Solvers that are not installed are left out.
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

ROUND, STEP, MASS, ORBIT = 200, 5.0, 130.0, 0.0012  # steps, s, kg, rad/s
INERTIA = MASS / 12.0 * np.diag([1.0, 1.0, 0.72])  # of a cuboid 0.6 x 0.6 x 0.8 m
SPIN = 2.0 * np.pi / (ROUND * STEP) * np.array([np.sin(0.5), 0.0, np.cos(0.5)])
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


def generator(t: float) -> np.ndarray:
    """Return the matrix (18, 18) whose exponential leads state and held control on."""
    a, b = continuous(t)
    return np.block([[a, b], [np.zeros((6, 18))]])


def discrete(p: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return (A_k, B_k) of every step."""
    flows = [expm(STEP * generator((k + 0.5) * STEP)) for k in range(p)]
    return [(both[:12, :12], both[:12, 12:]) for both in flows]


def feedback(plant: list[tuple[np.ndarray, np.ndarray]], p: int) -> list[np.ndarray]:
    """Return the periodic LQ gains K_k."""
    q = np.diag(np.repeat([0.01, 1.0, 0.1, 10.0], 3))
    r = np.diag(np.repeat([1.0, 100.0], 3))
    cost, gains = q.copy(), [np.empty(0)] * p
    for k in range(800, -1, -1):
        a, b = plant[k % p]
        gains[k % p] = gain = np.linalg.solve(r + b.T @ cost @ b, b.T @ cost @ a)
        cost = q + a.T @ cost @ (a - b @ gain)
        cost = 0.5 * (cost + cost.T)
    return gains


def problem(p: int, within: int) -> tuple[PeriodicLoop, PeriodicConstraints]:
    """Return the loop under LQ feedback, and its constraints, at ``within`` points of a step."""
    plant = discrete(p)
    target = np.zeros((12, 6))
    target[:3, :3] = target[6:9, 3:] = np.eye(3)
    on_state, limits = state_rows()
    maps, feeds, rows, through, bounds = [], [], [], [], []
    for k, ((a, b), gain) in enumerate(zip(plant, feedback(plant, p), strict=True)):
        feed = gain @ target + np.linalg.lstsq(b, target - a @ target, rcond=None)[0]
        maps.append(a - b @ gain)
        feeds.append(b @ feed)
        controls = np.vstack([np.hstack([-gain, feed]), np.hstack([gain, -feed])])
        stacked, held = [controls], np.hstack([-gain, feed])
        for j in range(within):  # the state on the way through the step, from (x, v)
            part = expm(STEP * j / within * generator((k + 0.5) * STEP))
            way = part[:12, :12] @ np.eye(12, 18) + part[:12, 12:] @ held
            stacked.append(on_state @ way)
        both = np.vstack(stacked)
        rows.append(both[:, :12])
        through.append(both[:, 12:])
        bounds.append([*(([1.0] * 3 + [0.05] * 3) * 2), *(limits * within)])
    names = tuple(f"row {i}" for i in range(len(bounds[0])))
    loop = PeriodicLoop(np.array(maps), np.array(feeds))
    return loop, PeriodicConstraints(np.array(rows), np.array(through), np.array(bounds), names)


def state_rows() -> tuple[np.ndarray, list[float]]:
    """Return 12 rows on the state: vertices off the docking face, port in the line of sight."""
    rows, bounds = [], []
    for vertex in VERTICES:
        arm = vertex - PORT
        of_vertex = np.zeros((3, 12))
        of_vertex[:, :3], of_vertex[:, 6:9] = np.eye(3), -lie.hat(arm)
        rows.append(-of_vertex[0])
        bounds.append(arm[0] + 0.02)
    for axis, sign in ((1, 1.0), (1, -1.0), (2, 1.0), (2, -1.0)):
        row = np.zeros(12)
        row[axis], row[0] = sign, -np.tan(np.pi / 6.0)
        rows.append(row)
        bounds.append(0.05)
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
    parser.add_argument("--period", type=int, default=200, help="1: a time-invariant loop")
    parser.add_argument("--within", type=int, default=1, help="points of a step with rows")
    given = parser.parse_args()
    steps = given.steps
    loop, constraints = problem(given.period, given.within)
    print(f"spectral radius a step {loop.spectral_radius ** (1.0 / given.period):.4f}, ", end="")
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
