"""All combinations of time shifts of three craft, each propagated step by step with plain NumPy."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

PAIRS = ((0, 1), (0, 2), (1, 2))


class Enumerated(NamedTuple):
    """Per combination (p, p, p): whether it is admissible, and its W and Omega."""

    admissible: np.ndarray
    shift_cost: np.ndarray
    state_cost: np.ndarray

    def best(self):
        """Return the shifts of the least J, ties to the lowest."""
        j = np.where(self.admissible, self.shift_cost + self.state_cost, np.inf)
        return np.array(np.unravel_index(j.argmin(), j.shape))


def flown(problem, step, state, i):
    """Return positions (p, N + 1, 3), commanded ones, delta-v (p, N, 3) and Omega (p,) of craft i.

    One flight for each of its shifts, by the plant's equation.
    """
    p, horizon = problem.samples, problem.horizon
    shifts = np.arange(p)
    x, at, told, pushes, cost = np.tile(state, (p, 1)), [], [], [], np.zeros(p)
    for k in range(step, step + horizon + 1):
        wanted = problem.natural[(k + problem.phases[i] + shifts) % p]
        push = (x - wanted) @ problem.gain.T
        at.append(x[:, :3])
        told.append(wanted[:, :3])
        if k == step + horizon:
            break
        pushes.append(push)
        error = x - wanted
        cost += np.einsum("ai,ij,aj->a", error, problem.state_weight, error)
        cost += np.einsum("ai,ij,aj->a", push, problem.control_weight, push)
        x = (x + np.hstack([np.zeros((p, 3)), push])) @ problem.state_map.T
    return np.stack(at, 1), np.stack(told, 1), np.stack(pushes, 1), cost


def enumerate_all(problem, step, states):
    """Return what becomes of every combination of shifts of three craft."""
    p = problem.samples
    flights = [flown(problem, step, states[i], i) for i in range(3)]
    able = [(np.linalg.norm(f[2], axis=2) <= problem.max_delta_v).all(axis=1) for f in flights]
    admissible = able[0][:, None, None] & able[1][None, :, None] & able[2][None, None]
    for i, j in PAIRS:
        keeps = np.empty((p, p), dtype=bool)
        for a in range(p):
            keeps[a] = pair_is_kept(problem, flights[i], flights[j], a)
        expanded = np.expand_dims(keeps, ({0, 1, 2} - {i, j}).pop())
        admissible = admissible & expanded
    a = np.arange(p)
    apart = np.abs(a[:, None] - a)
    squared = problem.shift_weight * np.minimum(apart, p - apart) ** 2.0
    shift_cost = squared[:, :, None] + squared[:, None, :] + squared[None]
    costs = [f[3] for f in flights]
    state_cost = costs[0][:, None, None] + costs[1][None, :, None] + costs[2][None, None]
    return Enumerated(admissible, shift_cost, state_cost)


def pair_is_kept(problem, first, second, a):
    """Tell, for each shift of the second craft, whether a pair keeps distance and angle."""
    apart = first[0][a] - second[0]
    told = first[1][a] - second[1]
    distance, length = np.linalg.norm(apart, axis=2), np.linalg.norm(told, axis=2)
    along = np.einsum("akx,akx->ak", apart, told)
    with np.errstate(divide="ignore", invalid="ignore"):
        angle = np.arccos(np.clip(along / (distance * length), -1.0, 1.0))
    angle = np.where(length > 0.0, angle, 0.0)
    return ((distance >= problem.min_separation) & (angle <= problem.max_angle)).all(axis=1)
