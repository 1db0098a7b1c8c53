"""Admissible sets O_infinity,k of one period, and their rows from the loop and what they are of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.governors.periodic.problem import PeriodicConstraints, PeriodicLoop
from spacecraft_gnc.governors.periodic.steady import SteadyReferences
from spacecraft_gnc.types import Array, read_only

STEADY: Final = -1
"""``ahead`` of a steady-state row."""

Indices = NDArray[np.int64]


class Members(NamedTuple):
    """Which rows a set holds, sorted by ``ahead``, then ``source``."""

    source: Indices
    """(r,) index of the constraint; of the row of V where ``ahead`` is STEADY."""
    ahead: Indices
    """(r,) number of steps ahead."""


@dataclass(frozen=True, slots=True, eq=False)
class AdmissibleSet:
    """O_k = {(x, v) : state_rows x + reference_rows v <= bounds}.

    Attributes
    ----------
    state_rows : (r, n) array
    reference_rows : (r, q) array
    bounds : (r,) array
    constraint : (r,) int array
        Which constraint a row is of.
    ahead : (r,) int array
        In how many steps the row has that constraint kept; -1 in steady state.
    """

    state_rows: Array
    reference_rows: Array
    bounds: Array
    constraint: Indices
    ahead: Indices

    def slacks(self, state: Array, reference: Array) -> Array:
        """Return the slack (r,) of each row in its own unit; negative where it is broken."""
        return np.asarray(self.bounds - self.state_rows @ state - self.reference_rows @ reference)


@dataclass(frozen=True, slots=True, eq=False)
class AdmissibleSets:
    """The sets O_infinity,k of one period.

    Attributes
    ----------
    sets : tuple of AdmissibleSet, (p,)
    names : tuple of str, (m,)
        Names of the constraints.
    inside : (p, n + q) array
        A steady state and its reference inside each set.
    determined : bool
        Whether the recursion closed: the sets are invariant and hold all rows of O_infinity.
    steps : int
        Backward steps taken; rows at least ``steps - p`` steps ahead are in the sets.
    excess : float
        Certificate where not determined: share of its room at ``inside`` by which a row further
        ahead is exceeded at most; infinite if no bound is known. 0 where determined.
    """

    sets: tuple[AdmissibleSet, ...]
    names: tuple[str, ...]
    inside: Array
    determined: bool
    steps: int
    excess: float

    @property
    def period(self) -> int:
        """Number of steps of a period."""
        return len(self.sets)

    @property
    def horizon(self) -> int:
        """Largest number of steps ahead of a row."""
        return max(int(o.ahead.max(initial=STEADY)) for o in self.sets)

    def at(self, k: int) -> AdmissibleSet:
        """Return the set of step k, of any period."""
        return self.sets[k % self.period]

    def contains(self, k: int, state: object, reference: object, tolerance: float = 0.0) -> bool:
        """Tell whether (state, reference) belongs to the set of step k, to a tolerance."""
        o = self.at(k)
        x = as_shaped("state", state, (o.state_rows.shape[1],))
        v = as_shaped("reference", reference, (o.reference_rows.shape[1],))
        return bool((o.slacks(x, v) >= -tolerance).all())


def inside_points(loop: PeriodicLoop, steady: SteadyReferences) -> Array:
    """Return the periodic steady state of the reference inside V, and that reference (p, n + q)."""
    states = loop.steady_maps() @ steady.inside
    return np.hstack([states, np.tile(steady.inside, (loop.period, 1))])


def assembled(
    loop: PeriodicLoop,
    constraints: PeriodicConstraints,
    steady: SteadyReferences,
    members: Sequence[Members],
) -> tuple[AdmissibleSet, ...]:
    """Return the sets with these members; the same bits for sets found and sets read again."""
    horizon = max(int(m.ahead.max(initial=STEADY)) for m in members)
    flow = _flow(loop, loop.period - 1, horizon)
    found = []
    for k in reversed(range(loop.period)):
        found.append(_set_of(k, flow, constraints, steady, members[k]))
        flow[1:] = led_back(flow[:-1], loop.state_map[k - 1], loop.reference_map[k - 1])
    return tuple(reversed(found))


def _flow(loop: PeriodicLoop, k: int, horizon: int) -> Array:
    """Return the maps (horizon + 1, n, n + q) from (x_k, v) to x_{k+j}."""
    n, q = loop.n_states, loop.n_references
    flow = np.zeros((horizon + 2, n, n + q))
    flow[0, :, :n] = np.eye(n)
    for j in range(horizon + 1):
        i = (k + j) % loop.period
        flow[j + 1] = loop.state_map[i] @ flow[j]
        flow[j + 1, :, n:] += loop.reference_map[i]
    return flow


def led_back(rows: Array, state_map: Array, reference_map: Array) -> Array:
    """Return rows on (x_{k+1}, v) as rows on (x_k, v)."""
    n = len(state_map)
    return np.concatenate(
        [rows[..., :n] @ state_map, rows[..., :n] @ reference_map + rows[..., n:]], axis=-1
    )


def _set_of(
    k: int,
    flow: Array,
    constraints: PeriodicConstraints,
    steady: SteadyReferences,
    members: Members,
) -> AdmissibleSet:
    source, ahead = members
    n = constraints.state_rows.shape[2]
    rows, bounds = np.zeros((len(source), flow.shape[2])), np.empty(len(source))
    constraint = source.copy()
    settled = ahead == STEADY
    rows[settled, n:], bounds[settled] = (
        steady.rows[source[settled]],
        steady.bounds[source[settled]],
    )
    constraint[settled] = steady.constraint[source[settled]]
    starts = np.searchsorted(ahead, np.arange(len(flow) + 1))
    for j in range(len(flow)):
        part, phase = slice(starts[j], starts[j + 1]), (k + j) % len(constraints.bounds)
        rows[part] = constraints.state_rows[phase, source[part]] @ flow[j]
        rows[part, n:] += constraints.reference_rows[phase, source[part]]
        bounds[part] = constraints.bounds[phase, source[part]]
    constraint.setflags(write=False)
    ahead.setflags(write=False)
    return AdmissibleSet(
        read_only(np.ascontiguousarray(rows[:, :n])),
        read_only(np.ascontiguousarray(rows[:, n:])),
        read_only(bounds),
        constraint,
        ahead,
    )
