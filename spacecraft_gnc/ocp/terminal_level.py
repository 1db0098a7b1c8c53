"""The level of the terminal set: how far from the target the terminal controller is good.

Source: Kalabic et al. 2014, (29)-(31): the largest c for which the terminal cost falls by the stage
cost, F(X+) - F(X) <= -lambda L(X, kappa(X)), and both momenta are solvable (4), wherever
|x|_P^2 <= c. The nearest violation is looked for along rays from the target: quasi-random ones
first, then descending from the worst of them. The level found is checked with as many fresh
samples of the whole set.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp import _level_kernels
from spacecraft_gnc.ocp.terminal_controller import TerminalController
from spacecraft_gnc.types import Array

RAYS = 4096
SAMPLES = 2**15
SHELLS_PER_FACTOR = 8  # shells while the radius doubles
SMALLEST = 2.0**-7  # first shell, as a share of the half-turn's radius; nearer, linear theory holds
LARGEST = 2.0**7
DESCENTS, ROUNDS, AROUND = 8, 50, 32
SHRINK = 0.75
MARGIN = 1e-6
CONFIDENCE = 0.99


class Level(NamedTuple):
    """A level c of |x|_P^2, and what stands behind it."""

    value: float
    """c"""
    bound_by: str
    """What limits it: "torque limit", "half a turn" or "cost decrease (31)"."""
    samples: int
    """Fresh quasi-random samples of the set, all without a violation."""
    confidence: float
    """Probability with which the violating share of the set would have shown, were the samples
    independent."""
    violating_share: float
    """That share: 1 - (1 - confidence)^(1/samples)."""


def decrease_level(
    body: Array, data: Array, design: TerminalController, bound: float = math.inf
) -> Level:
    """Return the largest level, up to ``bound`` and half a turn, at which (30) and (4) hold.

    Parameters
    ----------
    body, data : array
        Packed inertia and problem, as the kernels take them.
    design : TerminalController
    bound : float
        Level that another limit allows, such as `TerminalController.torque_level`.

    Raises
    ------
    ParameterError
        If a fresh sample of the set found violates the decrease.
    """
    limits = {"torque limit": bound, "half a turn": design.half_turn_level()}
    name = min(limits, key=lambda key: limits[key])
    found = nearest_violation(body, data, design, limits[name])
    level = limits[name]
    if found < level:
        name, level = "cost decrease (31)", found * (1.0 - MARGIN)
    samples = ball(spread(SAMPLES, 7, first=0)) @ (math.sqrt(level) * _root(design)).T
    violations = _level_kernels.count_violations(body, data, design.gain, samples)
    if violations:
        raise ParameterError(
            f"terminal_set: received a problem whose terminal level {level:.6g} is violated by "
            f"{violations} of {SAMPLES} samples; required a decrease in the whole set; use a "
            "smaller stage_cost_scale or another weight"
        )
    share = -math.expm1(math.log1p(-CONFIDENCE) / SAMPLES)
    return Level(level, name, SAMPLES, CONFIDENCE, share)


def nearest_violation(
    body: Array, data: Array, design: TerminalController, limit: float = math.inf
) -> float:
    """Return the smallest level |x|_P^2 seen at which (30) or (4) fails, ``limit`` if none below.

    Parameters
    ----------
    body, data, design
        As for `decrease_level`.
    limit : float
        Level beyond which nothing is looked for; 16384 half-turn levels at the most.
    """
    unit = math.sqrt(design.half_turn_level())
    radius = min(math.sqrt(limit), LARGEST * unit)
    count = max(2, math.ceil(SHELLS_PER_FACTOR * math.log2(radius / (SMALLEST * unit))))
    shells = np.geomspace(min(SMALLEST * unit, 0.5 * radius), radius, count)
    root = _root(design)
    directions = _sphere(spread(RAYS, 6, first=0))
    problem = (body, data, design.gain)

    def radii(directions: Array, limit: float) -> Array:
        found = np.empty(len(directions))
        rays = np.ascontiguousarray(directions @ root.T)
        _level_kernels.first_violations(*problem, rays, shells, limit, found)
        return found

    found = radii(directions, radius)
    order = np.argsort(found)[:DESCENTS]
    best = float(found[order[0]])
    if best >= radius:
        return limit
    noise = _sphere(spread(AROUND, 6, first=RAYS))
    for start, reached in zip(directions[order], found[order], strict=True):
        center, value, width = start, float(reached), 0.3
        for _ in range(ROUNDS):
            trial = center + width * noise
            trial /= np.linalg.norm(trial, axis=1, keepdims=True)
            values = radii(trial, value)
            if values.min() < value:
                center, value = trial[np.argmin(values)], float(values.min())
            else:
                width *= SHRINK
        best = min(best, value)
    return best**2


def _root(design: TerminalController) -> Array:
    """Return (6, 6) S with |S u|_P = |u|."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(design.riccati)).T)


def spread(count: int, dimension: int, first: int) -> Array:
    """Return (count, dimension) points of the unit cube, those after the ``first`` ones.

    Kronecker's sequence of the generalized golden ratio g, g^(d+1) = g + 1: quasi-random, without a
    seed, the same on every machine.
    """
    ratio = 2.0
    for _ in range(60):
        ratio = (1.0 + ratio) ** (1.0 / (dimension + 1))
    steps = ratio ** -np.arange(1.0, dimension + 1.0)
    return np.asarray((0.5 + np.outer(np.arange(first + 1, first + count + 1), steps)) % 1.0)


def _sphere(cube: Array) -> Array:
    """Map points (n, 6) of the cube to the unit sphere, by the normal distribution."""
    from scipy.special import ndtri  # loads for long, and for this method only

    normal = ndtri(np.clip(cube, 1e-12, 1.0 - 1e-12))
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def ball(cube: Array) -> Array:
    """Map points (n, 7) of the cube to the unit ball of R^6, evenly."""
    return np.asarray(_sphere(cube[:, :6]) * cube[:, 6:] ** (1.0 / 6.0))
