"""Enumeration of all shifts at one control step, by predictions of the audit's own.

Each craft is propagated step by step under each of its p shifts; each pair is then measured under
all p^2 of theirs. The worst share by which a limit is exceeded and the cost of all p^n candidates
are sums and maxima of these: a candidate is admissible where no share is positive.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.audit.loop import Loop

_NEVER: Final = -math.inf
_NOW, _SOON = np.array([0]), np.array([1, 2, 4, 7, 12, 20])
_BLOCK: Final = 1000


class Predicted(NamedTuple):
    """Craft under each of their shifts, from one recorded state."""

    positions: Array
    """(n, p, r, 3) at r instants [m]."""
    commanded: Array
    """(n, p, r, 3) likewise."""
    delta_v: Array
    """(n, p, horizon) lengths [m/s]."""
    cost: Array
    """(n, p) Omega; 0 for a lost craft."""


def predict(loop: Loop, step: int, states: Array, lost: NDArray[np.bool_]) -> Predicted:
    """Propagate craft (n, 6) over the horizon; those ``lost`` drift."""
    x = np.repeat(states[:, None], loop.p, axis=1)
    places: list[Array] = []
    sizes, cost = [], np.zeros((loop.n, loop.p))
    columns = (step + loop.phases[:, None] + np.arange(loop.p)) % loop.p
    for k in range(loop.horizon):
        error = x - loop.path[(columns + k) % loop.p, 0]
        push = np.where(lost[:, None, None], 0.0, error @ loop.K.T)
        sizes.append(np.linalg.norm(push, axis=-1))
        cost += np.sum(error @ loop.Q * error, axis=-1) + np.sum(push @ loop.R * push, axis=-1)
        after = x + np.concatenate([np.zeros_like(push), push], axis=-1)
        places += [x[..., :3], *(after @ part.T for part in loop.parts[1:])]
        x = after @ loop.A.T
    places.append(x[..., :3])
    cost[lost] = 0.0
    ahead, part = np.divmod(np.arange(len(places)), loop.checks)
    asked = loop.path[(columns[..., None] + ahead) % loop.p, part, :3]
    return Predicted(np.stack(places, axis=2), asked, np.stack(sizes, axis=2), cost)


def separation(loop: Loop, apart: Array) -> Array:
    """Return the shares (..., r) by which places apart (..., r, 3) are too near."""
    return np.asarray(1.0 - np.sqrt(np.einsum("...i,...i->...", apart, apart)) / loop.separation)


def angle(loop: Loop, apart: Array, wanted: Array) -> Array:
    """Return the shares (..., r) by which actual and commanded directions differ too much.

    Two craft that are to be at one place have no direction, and no angle.
    """
    along = np.einsum("...i,...i->...", apart, wanted)
    sizes = np.einsum("...i,...i->...", apart, apart) * np.einsum("...i,...i->...", wanted, wanted)
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(sizes > 0.0, along / np.sqrt(sizes), 1.0)
    return np.asarray(np.arccos(np.clip(cosine, -1.0, 1.0)) / loop.angle - 1.0)


class Limits:
    """What the constraints ask of the candidates of one step.

    Parameters
    ----------
    loop : Loop
    made : Predicted
    lost : (n,) array of bool
        Two lost craft have no constraint, one lost and one able no angle.
    """

    def __init__(self, loop: Loop, made: Predicted, lost: NDArray[np.bool_]) -> None:
        self.loop, self.made, self.lost = loop, made, lost

    def _directions(self, i: int, j: int) -> bool:
        return self.loop.angle != math.inf and not (self.lost[i] or self.lost[j])

    def along(self, shifts: NDArray[np.int64]) -> Iterator[tuple[str, tuple[int, ...], Array]]:
        """Yield name, craft and shares (r,) of each constraint under one candidate (n,)."""
        loop, made = self.loop, self.made
        for i in np.flatnonzero(~self.lost).tolist():
            yield "delta-v", (i,), made.delta_v[i, shifts[i]] / loop.delta_v - 1.0
        for i, j in combinations(range(loop.n), 2):
            if self.lost[i] and self.lost[j]:
                continue
            apart = made.positions[i, shifts[i]] - made.positions[j, shifts[j]]
            yield "separation", (i, j), separation(loop, apart)
            if self._directions(i, j):
                wanted = made.commanded[i, shifts[i]] - made.commanded[j, shifts[j]]
                yield "angle", (i, j), angle(loop, apart, wanted)

    def of_craft(self, i: int, last: int) -> Array:
        """Return the worst share (p,) of a craft; a lost one has no other than its last shift."""
        if self.lost[i]:
            return np.where(np.arange(self.loop.p) == last, _NEVER, math.inf)
        return np.asarray(self.made.delta_v[i].max(axis=1) / self.loop.delta_v - 1.0)

    def of_pair(self, i: int, j: int, first: Array, second: Array, most: float) -> Array:
        """Return the worst share (p, p) of a pair, of shifts whose own are ``first``, ``second``.

        Where a share is beyond ``most`` anyway, it is only known to be.
        """
        p = self.loop.p
        if self.lost[i] and self.lost[j]:
            return np.full((p, p), _NEVER)
        found = np.maximum(first[:, None], second)
        a, b = np.nonzero(found <= most)
        r = self.made.positions.shape[2]
        for instants in (_NOW, _SOON[r > _SOON], np.arange(r)):  # most that fail do so at once
            worst = np.full(len(a), _NEVER)
            for block in range(0, len(a), _BLOCK):
                part = slice(block, block + _BLOCK)
                worst[part] = self._shares(i, j, a[part], b[part], instants).max(axis=1)
            found[a, b] = worst
            a, b = a[worst <= most], b[worst <= most]
        return found

    def kept_until(self, i: int, j: int, most: float) -> NDArray[np.int64]:
        """Return the instants (p, p) at which a share of a pair first is beyond ``most``.

        Where none is, their number.
        """
        p, r = self.loop.p, self.made.positions.shape[2]
        found = np.full((p, p), r)
        if self.lost[i] and self.lost[j]:
            return found
        b, every = np.arange(p), np.arange(r)
        for a in range(p):
            beyond = self._shares(i, j, np.full(p, a), b, every) > most
            found[a] = np.where(beyond.any(axis=1), beyond.argmax(axis=1), r)
        return found

    def _shares(
        self, i: int, j: int, a: NDArray[np.int64], b: NDArray[np.int64], at: NDArray[np.int64]
    ) -> Array:
        """Return the larger share (m, r) of both constraints under shifts (m,), (m,)."""
        made = self.made
        apart = made.positions[i][:, at][a] - made.positions[j][:, at][b]
        shares = separation(self.loop, apart)
        if self._directions(i, j):
            wanted = made.commanded[i][:, at][a] - made.commanded[j][:, at][b]
            shares = np.maximum(shares, angle(self.loop, apart, wanted))
        return shares


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """All candidates of one step.

    Attributes
    ----------
    limits : Limits
    worst : (p,) * n array
        Largest share by which a candidate exceeds a limit; infinite: it is none.
    cost : (p,) * n array
        W + Omega.
    own : n arrays (p,)
        Worst share of each craft alone.
    """

    limits: Limits
    worst: Array
    cost: Array
    own: tuple[Array, ...]

    @classmethod
    def at(
        cls,
        loop: Loop,
        step: int,
        states: Array,
        lost: NDArray[np.bool_],
        shifts: NDArray[np.int64],
        most: float,
    ) -> Candidates:
        """Return those from states (n, 6); ``shifts`` (n,) are the last ones, which lost keep.

        A worst share beyond ``most`` is only known to be beyond it.
        """
        n, p = loop.n, loop.p
        limits = Limits(loop, predict(loop, step, states, lost), lost)
        own = [limits.of_craft(i, int(shifts[i])) for i in range(n)]
        worst, cost = np.full((p,) * n, _NEVER), np.zeros((p,) * n)
        for i in range(n):
            np.maximum(worst, _spread(own[i], (i,), n), out=worst)
            cost += _spread(limits.made.cost[i], (i,), n)
        apart = loop.apart()
        for i, j in combinations(range(n), 2):
            found = limits.of_pair(i, j, own[i], own[j], most)
            np.maximum(worst, _spread(found, (i, j), n), out=worst)
            if not (lost[i] or lost[j]):
                cost += _spread(apart, (i, j), n)
        return cls(limits, worst, cost, tuple(own))

    def kept_until(self, most: float) -> NDArray[np.int64]:
        """Return the instants (p,) * n at which a share of a pair first is beyond ``most``.

        -1 where a craft's own is.
        """
        n, p = self.limits.loop.n, self.limits.loop.p
        found = np.full((p,) * n, self.limits.made.positions.shape[2])
        for i, j in combinations(range(n), 2):
            until = self.limits.kept_until(i, j, most)
            np.minimum(found, _spread(until, (i, j), n), out=found)
        for i in range(n):
            found[np.broadcast_to(_spread(self.own[i] > most, (i,), n), found.shape)] = -1
        return found

    def costs(self, shifts: NDArray[np.int64]) -> tuple[float, float]:
        """Return W and Omega of one candidate."""
        able, apart = np.flatnonzero(~self.limits.lost).tolist(), self.limits.loop.apart()
        W = sum(float(apart[shifts[i], shifts[j]]) for i, j in combinations(able, 2))
        return W, float(sum(self.limits.made.cost[i, shifts[i]] for i in able))


def _spread(values: NDArray[Any], craft: tuple[int, ...], n: int) -> NDArray[Any]:
    """Return values of one or two craft as an array that broadcasts over all n."""
    shape = [1] * n
    for axis, i in enumerate(craft):
        shape[i] = values.shape[axis]
    return values.reshape(shape)
