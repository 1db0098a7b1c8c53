"""What an enumeration of all candidates finds of one control step."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.vehicles.formation.audit.candidates import Candidates
from spacecraft_gnc.vehicles.formation.audit.graph import Ways
from spacecraft_gnc.vehicles.formation.audit.loop import Loop
from spacecraft_gnc.vehicles.formation.audit.rooms import Room, rooms_of, worst_of
from spacecraft_gnc.vehicles.formation.audit.told import Told
from spacecraft_gnc.vehicles.formation.decision import Answer


class Lasting(NamedTuple):
    """How long candidates keep all limits [instants of the prediction]; -1: no delta-v is kept."""

    chosen: int
    """The shifts chosen, limits met within rounding included."""
    certain: int
    """The best candidate, beyond rounding."""
    possible: int
    """The best candidate, limits met within rounding included."""
    cheapest: float
    """Least cost of those that keep them as long as the chosen, beyond rounding."""


class Found(NamedTuple):
    """What the enumeration of one step found."""

    shift_cost: float
    state_cost: float
    share: float
    """Worst of the chosen shifts."""
    last: float
    """Worst of the shifts of the step before; NaN: not known."""
    cheapest: float
    """Cost of the cheapest candidate that is admissible beyond rounding; infinite: none."""
    certain: int
    """Candidates that are admissible beyond rounding."""
    possible: int
    """Those that may be."""
    least: float
    """Least worst share of all candidates; NaN: it is positive, or not looked for."""
    rooms: tuple[Room, ...]
    """Of the chosen shifts."""
    wish: tuple[Room, ...]
    """Of the cheapest candidate of all."""
    saved: float
    """By how much that costs less than the chosen shifts."""
    lasting: Lasting
    """How long limits are kept, where none is admissible after a loss."""
    nearest: bool
    """Of PASSAGE alone: whether no admissible candidate has fewer transitions left, or costs less
    at as many; where none has fewer than the last shifts, whether these are kept."""


_AFTER_LOSS: Final = (Answer.LONGEST_KEPT, Answer.LEAST_VIOLATING)
_NOT_ASKED: Final = Lasting(0, 0, 0, math.inf)


def enumerate_step(told: Told, loop: Loop, ways: Ways, i: int) -> Found:
    """Return what is true of one step."""
    step, shifts, lost = int(told.steps[i]), told.shifts[i], told.lost[i]
    answer = told.field("status")[i]
    slack = loop.slack
    most = math.inf if answer == Answer.LEAST_VIOLATING else slack
    made = Candidates.at(loop, step, told.states[i], lost, shifts, most)
    certain, possible = made.worst <= -slack, made.worst <= slack
    open_to = np.where(_closed(lost, shifts, loop.p), np.inf, made.cost)
    wish = np.array(np.unravel_index(open_to.argmin(), open_to.shape))
    rooms, costs = rooms_of(made, shifts), made.costs(shifts)
    return Found(
        *costs,
        worst_of(rooms),
        _of_last(made, told, i),
        float(made.cost[certain].min(initial=math.inf)),
        int(certain.sum()),
        int(possible.sum()),
        float(made.worst.min()) if most == math.inf else math.nan,
        rooms,
        rooms_of(made, wish),
        sum(costs) - float(open_to.min()),
        _lasting(made, shifts, slack) if lost.any() and answer in _AFTER_LOSS else _NOT_ASKED,
        _nearest(made, told, ways, i) if answer == Answer.PASSAGE else True,
    )


def _nearest(made: Candidates, told: Told, ways: Ways, i: int) -> bool:
    chosen, last, slack = told.shifts[i], told.shifts[i - 1], made.limits.loop.slack
    known = told.follows[i] and (last < made.limits.loop.p).all()
    left = ways.of_candidates(told.lost[i]) if known else None
    if left is None:
        return True
    here, most = left[tuple(chosen)], max(left[tuple(last)] - 1, 0)
    certain = (made.worst <= -slack) & (left >= 0) & (left <= most)
    if here < 0 or here > most:
        return bool((chosen == last).all() and not certain.any())
    cost = made.cost[tuple(chosen)]
    cheapest = made.cost[certain & (left == here)].min(initial=math.inf)
    nearer = (certain & (left < here)).any()
    return bool(not nearer and cost <= cheapest + slack * (1.0 + cost))


def _of_last(made: Candidates, told: Told, i: int) -> float:
    last = told.shifts[i - 1]
    known = told.follows[i] and (last < made.limits.loop.p).all()
    return worst_of(rooms_of(made, last)) if known else math.nan


def _lasting(made: Candidates, shifts: NDArray[np.int64], slack: float) -> Lasting:
    possible, certain = made.kept_until(slack), made.kept_until(-slack)
    until = int(possible[tuple(shifts)])
    cheapest = made.cost[certain >= max(until, 0)].min(initial=math.inf)
    return Lasting(until, int(certain.max()), int(possible.max()), float(cheapest))


def _closed(lost: NDArray[np.bool_], shifts: NDArray[np.int64], p: int) -> NDArray[np.bool_]:
    """Return which of all combinations give a lost craft another shift than it has."""
    n = len(shifts)
    other = np.zeros((p,) * n, dtype=bool)
    for i in np.flatnonzero(lost).tolist():
        shape = [1] * n
        shape[i] = p
        other |= (np.arange(p) != shifts[i]).reshape(shape)
    return other
