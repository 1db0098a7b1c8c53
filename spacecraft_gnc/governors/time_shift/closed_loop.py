"""Flight of a formation under the governor on the modeled loop, for studies and campaigns."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacecraft_gnc.arguments import as_count
from spacecraft_gnc.governors.time_shift.decision import TimeShiftDecision
from spacecraft_gnc.governors.time_shift.governor import TimeShiftGovernor
from spacecraft_gnc.governors.time_shift.problem import Integers, TimeShiftProblem
from spacecraft_gnc.types import Array

NEVER = -1
"""Step of a failure that does not happen."""


class FormationFlight(NamedTuple):
    """Flight of n craft over s steps; q pairs in the order 12, 13, ..., 1n, 23, ..."""

    states: Array
    """(s, n, 6) at the start of each step, before the impulse."""
    delta_v: Array
    """(s, n, 3) given [m/s]"""
    shifts: Integers
    """(s, n)"""
    separation: Array
    """(s, q) [m]"""
    angle: Array
    """(s, q) between actual and commanded relative position [rad]; 0 where none is commanded."""
    decisions: tuple[TimeShiftDecision, ...]
    """(s,); empty without a governor"""

    @property
    def formed_at(self) -> int:
        """First step at which the formation is reached for good; -1: it is not."""
        formed = [decision.formed for decision in self.decisions]
        if not formed or not formed[-1]:
            return NEVER
        return len(formed) - formed[::-1].index(False) if False in formed else 0

    @property
    def largest_delta_v(self) -> float:
        """Largest length of a craft's delta-v [m/s]."""
        return float(np.sqrt(np.einsum("sij,sij->si", self.delta_v, self.delta_v)).max())


def fly(
    governor: TimeShiftGovernor,
    states: Array,
    steps: int,
    *,
    failures: Integers | None = None,
    stops: bool = True,
) -> FormationFlight:
    """Fly from the states (n, 6) of step 0, at most a number of steps.

    Parameters
    ----------
    governor : TimeShiftGovernor
        Reset first.
    failures : (n,) array of int, optional
        Step from which on each craft gives no delta-v; `NEVER`: it always does.
    stops : bool
        Whether to stop once the formation is reached, all failures having been noticed.
    """
    problem, decisions = governor.problem, []
    dead = np.full(problem.n_craft, NEVER) if failures is None else np.asarray(failures)
    governor.reset()
    x, flown, given = states, [], []
    for k in range(as_count("steps", steps)):
        decision = governor.decide(k, x)
        push = problem.delta_v(k, x, decision.shifts)
        push[(dead >= 0) & (k >= dead)] = 0.0
        decisions.append(decision)
        flown.append(x)
        given.append(push)
        if stops and decision.formed and (decision.lost | (dead == NEVER)).all():
            break
        x = problem.step(x, push)
    shifts = np.array([decision.shifts for decision in decisions])
    return _measured(problem, np.array(flown), np.array(given), shifts, tuple(decisions))


def fly_unshifted(problem: TimeShiftProblem, states: Array, steps: int) -> FormationFlight:
    """Fly without a governor: all shifts are 0."""
    shifts = np.zeros((as_count("steps", steps), problem.n_craft), dtype=np.int64)
    x, flown, given = states, [], []
    for k in range(steps):
        flown.append(x)
        given.append(problem.delta_v(k, x, shifts[k]))
        x = problem.step(x, given[-1])
    return _measured(problem, np.array(flown), np.array(given), shifts, ())


def _measured(
    problem: TimeShiftProblem,
    states: Array,
    delta_v: Array,
    shifts: Integers,
    decisions: tuple[TimeShiftDecision, ...],
) -> FormationFlight:
    first, second = np.triu_indices(problem.n_craft, 1)
    told = np.array([problem.commanded(k, tau) for k, tau in enumerate(shifts)])[..., :3]
    apart = states[:, first, :3] - states[:, second, :3]
    wanted = told[:, first] - told[:, second]
    across = np.linalg.norm(np.cross(apart, wanted), axis=-1)
    angle = np.arctan2(across, np.einsum("sqj,sqj->sq", apart, wanted))
    angle[(wanted == 0.0).all(axis=-1)] = 0.0
    return FormationFlight(
        states, delta_v, shifts, np.linalg.norm(apart, axis=-1), angle, decisions
    )
