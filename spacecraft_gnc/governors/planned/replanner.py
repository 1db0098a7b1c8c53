"""Another plan from where the body will be, sought in a thread of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Final

import numpy as np

from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.ocp.transfer import (
    AttitudeTransfer,
    TransferSolution,
    TransferSolver,
    shortest_possible_steps,
)
from spacecraft_gnc.types import Matrix3, Vector3

_LONGER: Final = 1.15
_MOST_DURATIONS: Final = 12
_MOST_WORK: Final = 1e6
"""`TransferSolution.work` of a search, some 0.5 s: no clock, so that flights are repeatable."""
_PASSES: Final = 250  # of one duration; a transfer that exists takes some 40 from a start
_TOO_FEW: Final = 40


class Replanner:
    """Seek transfers like the first one from other states, one at a time.

    Parameters
    ----------
    transfer : AttitudeTransfer
        The first one; its body, bounds and final momentum are those of all.
    solver : TransferSolver, optional
    """

    def __init__(self, transfer: AttitudeTransfer, solver: TransferSolver | None = None) -> None:
        self._transfer = require_kind("transfer", transfer, AttitudeTransfer)
        self._solver = solver or TransferSolver()
        self._pool: ThreadPoolExecutor | None = None

    def ask(
        self, attitude: Matrix3, momentum: Vector3, goal: Matrix3, n_steps: int
    ) -> Future[TransferSolution | None]:
        """Begin to seek in the thread; the arguments are those of `find`."""
        if self._pool is None:
            self._pool = ThreadPoolExecutor(1, "planner")
        return self._pool.submit(self.find, attitude, momentum, goal, n_steps)

    def find(
        self, attitude: Matrix3, momentum: Vector3, goal: Matrix3, n_steps: int
    ) -> TransferSolution | None:
        """Return the first plan that is found, of ``n_steps`` or longer; None: none was found.

        The work of a search is bounded, whatever the state is.

        Parameters
        ----------
        attitude, momentum : (3, 3), (3,) arrays
            Where it starts. A momentum outside the bounds widens them to it.
        goal : (3, 3) array
            Where it ends, body to inertial.
        n_steps : int
            Steps that are tried first, if that many can suffice.
        """
        low_u, high_u, low_p, high_p = self._transfer.limits
        try:
            transfer = replace(
                self._transfer,
                start=attitude,
                start_momentum=momentum,
                goal=goal,
                torque=(low_u, high_u),
                momentum=(np.minimum(low_p, momentum), np.maximum(high_p, momentum)),
            )
            left = _MOST_WORK
            for steps in _durations(max(n_steps, shortest_possible_steps(transfer), 2)):
                if left < _TOO_FEW * steps:
                    break
                work = min(left, _PASSES * steps)
                found = self._solver.solve(replace(transfer, n_steps=steps), max_work=work)
                if found.converged:
                    return found
                left -= found.work
        except GncError:  # a state from which no step exists, say
            pass
        return None


def _durations(first: int) -> Iterator[int]:
    for _ in range(_MOST_DURATIONS):
        yield first
        first = math.ceil(_LONGER * first)
