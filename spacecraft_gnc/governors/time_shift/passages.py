"""Passages: ways from any parked formation to the desired one, a transition at a time.

Parked, all craft are on the natural motion. Which formation they are in, up to time, is a class:
the differences of their places to the first craft's. An edge leads from one class to another where
at some instant of the period one new combination of shifts, held, takes the craft over with every
constraint of the problem kept. The graph of all classes is searched once, from the desired
formation backward; it gives the number of transitions still needed from each class. The governor
then goes on to a class with fewer whenever the real state admits one. Nothing is relaxed.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.governors.time_shift import _choice_kernels, _passage_kernels
from spacecraft_gnc.governors.time_shift.prediction import Mask, Prediction, Predictor
from spacecraft_gnc.governors.time_shift.problem import Integers
from spacecraft_gnc.types import Array

_MOST_CLASSES: Final = 10_000  # of which each may have an edge to each: 100 MB
_MOST_PAIRS: Final = 10**8  # pairs of transitions of two craft: likewise
_MOST_WORK: Final = 10**11  # places before and after of all craft together

_MOST_KEPT: Final = 8  # searches of the process, of which each took seconds

NO_PASSAGE: Final = -1
"""Distance of a class from which no passage leads to the desired formation."""


class Passages:
    """Distances of parked formations from the desired one, in transitions.

    Parameters
    ----------
    predictor : Predictor
    lost : (n,) array of bool
        Craft that are left out.
    around : Prediction, optional
        From which lost craft drift: transitions keep away from them too, as they drift in the
        period after it. None, or too many craft: as if there were none.

    Attributes
    ----------
    distances : (c,) array of int
        Transitions from each class; `NO_PASSAGE` where there is none.
    is_whole : bool
        Whether the classes are the shifts of all craft, p^n, and not their differences, p^(n - 1).
    """

    def __init__(self, predictor: Predictor, lost: Mask, around: Prediction | None = None) -> None:
        problem = predictor.problem
        self._counted, self._phases, self._p = ~lost, problem.phases, problem.samples
        n = int(np.count_nonzero(self._counted))
        self.is_whole = around is not None
        count = self._p ** (n if self.is_whole else max(n - 1, 0))
        self.distances: Integers = np.full(count, NO_PASSAGE, dtype=np.int64)
        if not is_searchable(self._p, n) or count > _MOST_CLASSES:
            return
        edges = np.zeros((count, count), dtype=np.uint8)
        goals = np.zeros(count, dtype=np.bool_)
        transfers = _transfers(predictor)
        if around is None:
            _passage_kernels.mark_edges(transfers.joint, transfers.able, n, edges)
            goals[self._class_of(np.zeros(problem.n_craft, dtype=np.int64))] = True
        else:
            clear = _clear(predictor, transfers, around)
            _passage_kernels.mark_edges_around(
                transfers.joint, transfers.able, clear, around.step,
                np.ascontiguousarray(self._phases[self._counted]), edges, goals,
            )  # fmt: skip
        _passage_kernels.count_transitions(edges, goals, self.distances)

    def distance(self, shifts: Integers) -> int:
        """Return the transitions needed from a formation with these shifts (of all craft)."""
        return int(self.distances[self._class_of(shifts)])

    def _class_of(self, shifts: Integers) -> int:
        return int(
            _choice_kernels.class_of(shifts, self._counted, self._phases, self._p, self.is_whole)
        )


_kept: dict[tuple[object, ...], Passages] = {}


def passages(predictor: Predictor, lost: Mask) -> Passages:
    """Return the passages of a problem, searched once in a process: flights of a campaign share it.

    Arguments are those of `Passages`.
    """
    problem = predictor.problem
    arrays = (problem.state_map, problem.gain, problem.natural, problem.phases, lost)
    limits = (problem.max_delta_v, problem.min_separation, problem.max_angle)
    key = (*(array.tobytes() for array in arrays), *limits, problem.horizon, problem.substeps)
    if key not in _kept:
        while len(_kept) >= _MOST_KEPT:
            del _kept[next(iter(_kept))]
        _kept[key] = Passages(predictor, lost)
    return _kept[key]


def is_searchable(p: int, n: int) -> bool:
    """Tell whether the graph of n craft with p shifts each is small enough to be searched."""
    return (
        n >= 2
        and p ** (n - 1) <= _MOST_CLASSES
        and p**4 <= _MOST_PAIRS
        and p ** (2 * n) <= _MOST_WORK
    )


def warm_up_around() -> None:
    """Load the kernels that passages around lost craft add to the others."""
    one, none = np.ones((1, 1, 1), dtype=np.bool_), np.zeros((1, 1), dtype=np.uint8)
    joint = np.zeros((1, 1, 1, 1), dtype=np.uint8)
    _passage_kernels.mark_clear(np.zeros((1, 1, 3, 1)), np.zeros((3, 2)), 1, 1.0, one)
    _passage_kernels.mark_edges_around(
        joint, one[0], one, 0, np.zeros(2, dtype=np.int64), none, np.zeros(1, dtype=np.bool_)
    )


class _Transfers(NamedTuple):
    """Transitions of parked craft from a place f to a place g."""

    able: Mask
    """(p, p) [f, g] where one keeps its delta-v."""
    positions: Array
    """(p, p, 3, r) [m]"""
    joint: NDArray[np.uint8]
    """(p, p, p, p) [f, g, f', g'] where two keep all they have to."""


def _transfers(predictor: Predictor) -> _Transfers:
    problem, p = predictor.problem, predictor.problem.samples
    found = _Transfers(
        np.zeros((p, p), dtype=np.bool_),
        np.empty((p, p, 3, predictor.rows.shape[2])),
        np.zeros((p, p, p, p), dtype=np.uint8),
    )
    _passage_kernels.transfers(
        problem.natural, predictor.path, problem.substeps, predictor.pushes, predictor.rows,
        problem.max_delta_v**2, found.able, found.positions,
    )  # fmt: skip
    _passage_kernels.joint_transfers(
        found.able, found.positions, predictor.path, problem.substeps, problem.min_separation**2,
        predictor.cosine, found.joint,
    )  # fmt: skip
    return found


def _clear(predictor: Predictor, transfers: _Transfers, around: Prediction) -> Mask:
    """Return where (p, p, p) [s, f, g] a transition s steps from now keeps off all lost craft."""
    problem = predictor.problem
    p = problem.samples
    clear = np.ones((p, p, p), dtype=np.bool_)
    for i in np.flatnonzero(around.lost):
        drift = predictor.drift(around.states[i], p + problem.horizon)
        _passage_kernels.mark_clear(
            transfers.positions, drift, problem.substeps, problem.min_separation**2, clear
        )
    return clear
