"""Small periodic loops with constraints, and what a simulation says of them."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linprog

from spacecraft_gnc.governors.periodic import PeriodicConstraints, PeriodicLoop

LONG = 400  # steps after which the small loops are at rest: 0.9^400 = 5e-19


def random_loop(seed, p, n=2, q=1, radius=0.8):
    """Return a loop of spectral radius ``radius`` a step, with bounds on states and a control."""
    generator = np.random.default_rng(seed)
    turns = np.linalg.qr(generator.normal(size=(p, n, n)))[0]
    units = generator.uniform(0.5, 2.0, size=(p, n))  # they come and go, and leave the radius
    a = radius * np.roll(units, -1, axis=0)[:, :, None] * turns / units[:, None, :]
    loop = PeriodicLoop(a, generator.normal(size=(p, n, q)))
    signs = np.array([1.0, -1.0])
    on_states = np.kron(np.eye(n), signs[:, None])
    gain, feed = generator.normal(size=(p, 1, n)), generator.normal(size=(p, 1, q))
    state_rows = np.concatenate([np.tile(on_states, (p, 1, 1)), gain, -gain], axis=1)
    reference_rows = np.concatenate([np.zeros((p, 2 * n, q)), feed, -feed], axis=1)
    bounds = generator.uniform(1.0, 2.0, size=(p, 2 * n + 2))
    names = (*(f"state {i} {s}" for i in range(n) for s in "+-"), "control +", "control -")
    return loop, PeriodicConstraints(state_rows, reference_rows, bounds, names)


def kept(loop, constraints, k, x, v, steps=LONG):
    """Return the smallest slack on the way from states x (..., n) of step k under v (..., q)."""
    least = np.full(x.shape[:-1], np.inf)
    for j in range(k, k + steps):
        i = j % loop.period
        rows = x @ constraints.state_rows[i].T + v @ constraints.reference_rows[i].T
        least = np.minimum(least, (constraints.bounds[i] - rows).min(axis=-1))
        x = x @ loop.state_map[i].T + v @ loop.reference_map[i].T
    return least


def steady_slack(loop, constraints, v, share):
    """Return the smallest slack (...) of references v (..., q) in steady state, found by flying."""
    x = np.zeros((*v.shape[:-1], loop.n_states))
    for j in range(LONG * loop.period):
        i = j % loop.period
        x = x @ loop.state_map[i].T + v @ loop.reference_map[i].T
    least = np.full(v.shape[:-1], np.inf)
    for i in range(loop.period):
        rows = x @ constraints.state_rows[i].T + v @ constraints.reference_rows[i].T
        least = np.minimum(least, (share * constraints.bounds[i] - rows).min(axis=-1))
        x = x @ loop.state_map[i].T + v @ loop.reference_map[i].T
    return least


def largest(row, rows, bounds):
    """Return the largest row . z with rows z <= bounds, by linear programming."""
    found = linprog(-row, A_ub=rows, b_ub=bounds, bounds=(None, None), method="highs")
    return -found.fun if found.status == 0 else np.inf


def stacked(o):
    """Return rows (r, n + q) and bounds (r,) of a set."""
    return np.hstack([o.state_rows, o.reference_rows]), o.bounds
