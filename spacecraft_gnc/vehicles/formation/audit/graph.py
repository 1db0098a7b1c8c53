"""Parked formations and the transitions between them, searched by the audit's own predictions.

Parked, every craft is on the natural motion. A formation is known, up to time, by the differences
of the craft's places to the first one's. A transition commands new places at one instant of the
period, and holds them; it counts where every constraint is kept over the horizon. With an even
number of samples, the natural motion half a period later is its own negative, as are then all
distances between craft: half of the instants tell the rest.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.vehicles.formation.audit.candidates import Limits, predict
from spacecraft_gnc.vehicles.formation.audit.loop import Loop

Integers = NDArray[np.int64]
NO_WAY: Final = -1
_MOST_CLASSES: Final = 10_000
_MOST_PAIRS: Final = 10**8
_MOST_WORK: Final = 10**11


def is_searched(p: int, n: int) -> bool:
    """Tell whether the governor searches the graph of n craft with p places (documented)."""
    few = n >= 2 and p ** (n - 1) <= _MOST_CLASSES
    return few and p**4 <= _MOST_PAIRS and p ** (2 * n) <= _MOST_WORK


def numbers_of(places: Integers, p: int) -> Integers:
    """Return the number of the formation of places (..., n): its differences as digits."""
    number = np.zeros(places.shape[:-1], dtype=np.int64)
    for i in range(1, places.shape[-1]):
        number = number * p + (places[..., i] - places[..., 0]) % p
    return number


class Left(NamedTuple):
    """Transitions from each formation (p^(n-1),) to the desired one; -1: no way leads there."""

    fewest: Integers
    """With every transition that may be possible, a limit met within rounding included."""
    most: Integers
    """With those that keep every limit beyond rounding."""

    def holds(self, number: int, told: float) -> bool:
        """Tell whether what is told of a formation is right."""
        fewest, most, claimed = (
            math.inf if left == NO_WAY else float(left)
            for left in (self.fewest[number], self.most[number], told)
        )
        return fewest <= claimed <= most


class Ways:
    """Transitions left, of each set of craft that form up, searched when first needed.

    Parameters
    ----------
    loop : Loop
    """

    def __init__(self, loop: Loop) -> None:
        self._loop = loop
        self._found: dict[bytes, Left] = {}

    def of(self, lost: NDArray[np.bool_]) -> Left:
        """Return those of the craft that are not ``lost`` (n,)."""
        key = lost.tobytes()
        if key not in self._found:
            self._found[key] = transitions_left(self._loop, ~lost)
        return self._found[key]

    def number(self, shifts: Integers, lost: NDArray[np.bool_]) -> int:
        """Return the number of the formation of shifts (n,)."""
        return int(numbers_of((self._loop.phases + shifts)[~lost], self._loop.p))

    def of_candidates(self, lost: NDArray[np.bool_]) -> Integers | None:
        """Return the transitions left of all candidates (p,) * n; None where rounding decides."""
        left, loop = self.of(lost), self._loop
        if (left.fewest != left.most).any():
            return None
        shifts = np.moveaxis(np.indices((loop.p,) * loop.n), 0, -1)
        return np.asarray(left.most[numbers_of((loop.phases + shifts)[..., ~lost], loop.p)])


def transitions_left(loop: Loop, able: NDArray[np.bool_]) -> Left:
    """Return how many transitions lead from each formation of ``able`` craft to the desired one."""
    phases = loop.phases[able]
    n, p = len(phases), loop.p
    if not is_searched(p, n):
        none = np.full(p ** max(n - 1, 0), NO_WAY)
        return Left(none, none)
    goal = int(numbers_of(phases, p))
    possible, certain = _joint(loop)
    fewest = _counted(possible, n, goal)
    alike = np.array_equal(possible, certain)
    return Left(fewest, fewest if alike else _counted(certain, n, goal))


def _counted(joint: NDArray[np.bool_], n: int, goal: int) -> Integers:
    """Return the fewest transitions from each formation of n craft to the goal."""
    p = len(joint)
    left = np.full(p ** (n - 1), NO_WAY)
    edges = np.zeros((left.size, left.size), dtype=bool)
    for number in range(left.size):
        for places in _instants(number, n, p):
            if not _is_kept(joint, places):
                break  # nor at the others: it passes all of them
            edges[number, _reached(joint, places)] = True
    front, count = np.array([goal]), 0
    while front.size:
        left[front] = count
        front = np.flatnonzero(edges[:, front].any(axis=1) & (left == NO_WAY))
        count += 1
    return left


def _joint(loop: Loop) -> NDArray[np.bool_]:
    """Return which transitions two parked craft can make together (2, p, p, p, p): f, g, f', g'.

    From the place f to the place g, and from f' to g'; first those that may be possible, then
    those that are beyond rounding.
    """
    p = loop.p
    everywhere = replace(loop, n=p, phases=np.zeros(p, dtype=np.int64))
    none = np.zeros(p, dtype=bool)
    limits = Limits(everywhere, predict(everywhere, 0, loop.path[:, 0], none), none)
    own = [limits.of_craft(f, 0) for f in range(p)]
    joint = np.zeros((2, p, p, p, p), dtype=bool)
    limit = np.array([loop.slack, -loop.slack])[:, None, None]
    half = p // 2 if p % 2 == 0 else 0
    for f in range(p):
        for other in range(f, p):
            if half and min(f, other, (f - half) % p, (other - half) % p) not in (f, other):
                continue
            kept = limits.of_pair(f, other, own[f], own[other], loop.slack) <= limit
            for turn in {0, half}:
                a, b = (f + turn) % p, (other + turn) % p
                turned = np.roll(kept, (turn, turn), axis=(1, 2))
                joint[:, a, :, b], joint[:, b, :, a] = turned, turned.transpose(0, 2, 1)
    return joint


def _instants(number: int, n: int, p: int) -> Integers:
    """Return the places (m, n) of a formation at the instants of a period, or of half of one."""
    digits = [number // p ** (n - 1 - i) % p for i in range(1, n)]
    instants = np.arange(p // 2 if p % 2 == 0 else p)
    return np.asarray((np.array([0, *digits]) + instants[:, None]) % p)


def _is_kept(joint: NDArray[np.bool_], f: Integers) -> bool:
    return all(joint[f[i], f[i], f[j], f[j]] for j in range(len(f)) for i in range(j))


def _reached(joint: NDArray[np.bool_], f: Integers) -> Integers:
    """Return the formations (m,) that one transition leads to from places (n,), some repeated."""
    p = len(joint)
    g: NDArray[Any] = np.arange(p)[:, None]
    for i in range(1, len(f)):
        fits = np.ones((len(g), p), dtype=bool)
        for j in range(i):
            fits &= joint[f[j], g[:, j], f[i]]
        rows, last = np.nonzero(fits)
        g = np.hstack([g[rows], last[:, None]])
    return numbers_of(g, p)
