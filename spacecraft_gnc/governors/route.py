"""Waypoints around a zone that lies across the shortest way.

A governor that moves its reference along one geodesic stops before a zone that lies across it. A
roadmap leads round: attitudes that keep clear of every zone, spread evenly over SO(3), and between
neighbors those geodesics that keep clear all along. The shortest way over them is then pulled
tight. Nothing is random, so equal questions get equal answers. `docs/governor.md` explains it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_real, require_kind
from spacecraft_gnc.governors._geodesics import closest_approach, geodesics, spread
from spacecraft_gnc.governors.reference_set import ReferenceSet
from spacecraft_gnc.types import Array, Matrix3, read_only

NODES = 1200
CANDIDATES = 40_000  # narrow sets, such as that of an inclusion zone, keep few of many
NEIGHBORS = 14
LONGEST_LEG = math.radians(150.0)  # further on, the shortest way may turn to the other side
CUT_POINT = math.pi - 1e-6  # angle from which two geodesics count as equally short
PULLS = 6  # rounds of pulling; each halves what is left of most corners
PULL_SHARES = np.linspace(1.0, 0.125, 8)


class RoutePlanner:
    """Finds intermediate references from one attitude to another, clear of every zone.

    Parameters
    ----------
    reference_set : ReferenceSet
        Zones, and the steady margin that every leg keeps.
    clearance : float
        Angle to every zone that intermediate references keep [rad], and every leg as far as its
        ends allow: one that starts nearer to a zone comes no nearer. At least the steady margin.

    Raises
    ------
    ParameterError
        If the clearance is less than the steady margin.

    Notes
    -----
    The roadmap is built at the first plan that needs one (about 0.1 s). A way through a gap that
    is narrower than the roadmap is dense (about 20 deg) may be missed; every way returned is
    checked all along, in closed form.
    """

    def __init__(self, reference_set: ReferenceSet, clearance: float) -> None:
        self._set = require_kind("reference_set", reference_set, ReferenceSet)
        least = reference_set.steady_margin
        self._clearance = as_real(
            "clearance", clearance, lambda x: least <= x < math.pi,
            f"a number [rad], at least the steady margin {least:.6g}, and less than half a turn",
            "raise it (route_clearance_deg), or lower steady_margin_deg",
        )  # fmt: skip
        self._roadmap: tuple[Array, csr_array] | None = None

    def is_clear(self, start: Matrix3, end: Matrix3) -> bool:
        """Tell whether the whole geodesic keeps the steady margin.

        Half a turn apart there are two; both have to.
        """
        steady = self._set.steady_margin
        axis, angle = _axis_angle(start, end)
        ways = (axis, -axis) if angle >= CUT_POINT else (axis,)
        return all(self._approach(start, way[None], np.array([angle]))[0] >= steady for way in ways)

    def plan(self, start: Matrix3, end: Matrix3) -> tuple[Matrix3, ...] | None:
        """Return the intermediate references of a way round, without its end.

        Parameters
        ----------
        start, end : (3, 3) arrays
            Attitudes, body to inertial, that keep the steady margin.

        Returns
        -------
        tuple of (3, 3) arrays, or None
            Empty where the geodesic is clear; None where no way is found.
        """
        if self.is_clear(start, end):
            return ()
        if min(self._set.margin(start)[0], self._set.margin(end)[0]) < self._set.steady_margin:
            return None
        path = self._search(np.asarray(start), np.asarray(end))
        if path is None:
            return None
        path = self._drop(path)
        for _ in range(PULLS):
            path = self._drop(self._pull(path))
        return tuple(read_only(attitude.copy()) for attitude in path[1:-1])

    def warm_up(self) -> None:
        """Build the roadmap."""
        self._nodes()

    # --- the roadmap --------------------------------------------------------------------------

    def _nodes(self) -> tuple[Array, csr_array]:
        """Attitudes (n, 3, 3) of the roadmap, and the lengths (n, n) of its legs [rad]."""
        if self._roadmap is None:
            attitudes, quaternions = spread(CANDIDATES)
            clear = np.flatnonzero(self._set.margins(attitudes) >= self._clearance)[:NODES]
            self._roadmap = attitudes[clear], self._legs(attitudes[clear], quaternions[clear])
        return self._roadmap

    def _legs(self, attitudes: Array, quaternions: Array) -> csr_array:
        n = len(attitudes)
        if n < 2:
            return csr_array((n, n))
        both = cKDTree(np.concatenate([quaternions, -quaternions]))  # q and -q are one attitude
        _, near = both.query(quaternions, min(NEIGHBORS + 1, n))
        i, j = np.repeat(np.arange(n), near.shape[1]), near.ravel() % n
        i, j = np.unique(np.stack([np.minimum(i, j), np.maximum(i, j)])[:, i != j], axis=1)
        axes, angles = geodesics(attitudes[i], attitudes[j])
        clear = self._approach(attitudes[i], axes, angles) >= self._clearance
        return csr_array((angles[clear], (i[clear], j[clear])), shape=(n, n))

    def _search(self, start: Matrix3, end: Matrix3) -> Array | None:
        """Shortest way (m, 3, 3) over the roadmap, ends included; None: there is none."""
        attitudes, legs = self._nodes()
        n = len(attitudes)
        first, last = self._reach(start, attitudes), self._reach(end, attitudes)
        rows, columns = legs.nonzero()
        i = np.concatenate([rows, np.full(len(first[0]), n), last[0]])
        j = np.concatenate([columns, first[0], np.full(len(last[0]), n + 1)])
        lengths = np.concatenate([legs.data, first[1], last[1]])
        graph = csr_array((lengths, (i, j)), shape=(n + 2, n + 2))
        _, before = dijkstra(graph, directed=False, indices=n, return_predecessors=True)
        way, at = [end], int(before[n + 1])
        if at < 0:
            return None
        while at != n:
            way.append(attitudes[at])
            at = int(before[at])
        return np.array([start, *reversed(way)])

    def _reach(self, attitude: Matrix3, nodes: Array) -> tuple[NDArray[np.int64], Array]:
        """Nodes that one leg reaches from an attitude, and the lengths of these legs."""
        if not len(nodes):
            return np.empty(0, np.int64), np.empty(0)
        clear, angles = self._keeps(attitude, nodes)
        return np.flatnonzero(clear).astype(np.int64), angles[clear]

    # --- one leg ------------------------------------------------------------------------------

    def _approach(self, start: Array, axes: Array, angles: Array) -> Array:
        return closest_approach(self._set.zones, start, axes, angles)

    def _keeps(self, start: Array, ends: Array) -> tuple[NDArray[np.bool_], Array]:
        """Whether each leg keeps the clearance, as far as its ends have it, and its length."""
        axes, angles = geodesics(start, ends)
        at_ends = np.minimum(self._set.margins(start[None]), self._set.margins(ends))
        needed = np.clip(at_ends - 1e-9, self._set.steady_margin, self._clearance)
        clear = self._approach(start, axes, angles) >= needed
        return clear & (angles <= LONGEST_LEG), angles

    # --- the path pulled tight ----------------------------------------------------------------

    def _drop(self, path: Array) -> Array:
        """Leave out the attitudes that the way does without: from each go as far as is clear."""
        kept, at = [0], 0
        while at < len(path) - 1:
            clear, _ = self._keeps(path[at], path[at + 1 :])
            at += 1 + int(np.flatnonzero(clear)[-1])
            kept.append(at)
        return path[kept]

    def _pull(self, path: Array) -> Array:
        """Move each intermediate attitude toward the geodesic between those beside it."""
        path = path.copy()
        for k in range(1, len(path) - 1):
            before, here, after = path[k - 1 : k + 2]
            to_here = lie.angle_between(before, here)
            share = to_here / (to_here + lie.angle_between(here, after))
            straight = before @ lie.exp(share * lie.log(before.T @ after))
            move = lie.log(here.T @ straight)
            trials = np.array([here @ lie.exp(s * move) for s in PULL_SHARES])
            first, length_1 = self._keeps(before, trials)
            second, length_2 = self._keeps(after, trials)
            shorter = length_1 + length_2 < to_here + lie.angle_between(here, after) - 1e-6
            roomy = self._set.margins(trials) >= self._clearance
            good = np.flatnonzero(first & second & shorter & roomy)
            if len(good):
                path[k] = trials[good[0]]
        return path


def _axis_angle(start: Matrix3, end: Matrix3) -> tuple[Array, float]:
    vector = lie.log(np.asarray(start).T @ np.asarray(end))
    angle = float(np.linalg.norm(vector))
    return (vector / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0])), angle
