"""Neighboring extremals on line: carry the last optimum over to the new state, solve when needed.

Between two control steps the problem changes in its initial state only. To first order its solution
follows from one substitution with the factorization of the last exact solve. One evaluation of the
conditions and another substitution give a correction. How far it would move the torques, and the
factor by which such corrections shrink, bound what is left (`error_bound`). The factor is known
from earlier steps; where it is not, or the bound is not good enough, the correction is made and
the next one worked out, which measures it. An exact solve is made instead where

- the bound still exceeds the tolerance,
- other limits act than when the factorization was made, or a resting reference has changed,
- the factorization is older than ``max_age`` steps, or there is none.

The torque follows from the multipliers by (38), as in an exact solve, so the torque limit holds;
what the penalty leaves beyond it is cut off. Source: Bagherzadeh et al. 2023, section 5, with the
multipliers, instead of the torques, as what is corrected; Gupta et al. 2015, Remark III.

A moving reference is another one at every step. There the last optimum is first turned by as much
as the reference has turned, which is exact where the problem looks the same from every direction
(no zones, attitude weights c I); what is left of it otherwise, the corrections have to make good.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from threading import Lock
from time import perf_counter
from typing import Any

import numpy as np

from spacecraft_gnc.arguments import as_count, require_kind, require_positive
from spacecraft_gnc.arrays import FLOAT64
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp._neighboring_kernels import LAST, LAST_REFERENCE, SEEN, correct
from spacecraft_gnc.ocp.problem import AttitudeOcp
from spacecraft_gnc.ocp.reference import RESTING, Tracked, as_reference, is_moving
from spacecraft_gnc.ocp.shooting import IDENTITY, ShootingOptions, ShootingSolver
from spacecraft_gnc.ocp.solution import PlanLayout, Solution
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Matrix3,
    Reference,
    as_matrix3,
    as_vector3,
    read_only,
)

FORMULATION = "neighboring_extremal"
CONVERGED = Status.CONVERGED


@dataclass(frozen=True, slots=True)
class NeighboringOptions:
    """When a neighboring extremal is good enough.

    Attributes
    ----------
    tolerance : float
        Largest bound of the error of the planned torques, together, as a share of max_torque, or
        without a limit of the largest torque of the last exact plan.
    max_age : int
        Steps after which an exact solve is made anyway.
    """

    tolerance: float = 1e-3
    max_age: int = 10

    def __post_init__(self) -> None:
        object.__setattr__(self, "tolerance", require_positive("tolerance", self.tolerance))
        object.__setattr__(self, "max_age", as_count("max_age", self.max_age, remedy="give 10"))


class NeighboringExtremal:
    """Solve a sequence of neighboring problems, exactly only where that is needed.

    Parameters
    ----------
    ocp : AttitudeOcp
    neighboring : NeighboringOptions, optional
    options : ShootingOptions, optional
        Of the exact solves, which go by the backward sweep.

    Attributes
    ----------
    corrected, solved : int
        Steps answered by a neighboring extremal, and by an exact solve.
    largest_error : float
        What the tolerance allows [N m]; without a torque limit, since the last exact solve.
    error_bound : float
        Bound [N m] of the error of the last plan's torques, sqrt(sum_k |u_k - exact u_k|^2); zero
        after an exact solve. An estimate from the contraction seen, doubled: docs/solver.md has how
        often it was measured to hold.
    """

    def __init__(
        self,
        ocp: AttitudeOcp,
        neighboring: NeighboringOptions | None = None,
        options: ShootingOptions | None = None,
    ) -> None:
        self.ocp = ocp
        neighboring = NeighboringOptions() if neighboring is None else neighboring
        self.neighboring = require_kind("neighboring", neighboring, NeighboringOptions)
        self.solver = ShootingSolver(ocp, options=options)
        if self.solver.formulation != "backward_sweep":
            raise ParameterError(
                f"formulation: received {self.solver.formulation!r}; required the backward sweep, "
                "whose factorization the correction needs; give 'auto'"
            )
        self.largest_error = self.neighboring.tolerance * ocp.max_torque
        self._layout = PlanLayout(ocp, FORMULATION)
        self._max_age, self._limit = self.neighboring.max_age, ocp.max_torque
        self._work = self.solver.work
        self._rows = rows = np.zeros((17, 3))
        self._attitude, self._momentum = rows[:3], rows[3]
        self._lock = Lock()
        self.reset()

    def __reduce__(
        self,
    ) -> tuple[type[NeighboringExtremal], tuple[AttitudeOcp, NeighboringOptions, ShootingOptions]]:
        """Copy and pickle the settings; the last optimum is no part of them."""
        return type(self), (self.ocp, self.neighboring, self.solver.options)

    def reset(self) -> None:
        """Forget the last optimum and the counts."""
        self._age = self._max_age
        self._curvature = math.nan
        self._target, self._target_bytes = np.eye(3), b""
        self._motion, self._moved = RESTING, False
        self.corrected = self.solved = 0
        self.error_bound = 0.0

    def forget(self) -> None:
        """Forget the last optimum, as where another solution was flown; keep the counts."""
        self._age = self._max_age

    def memory(self) -> tuple[Any, ...]:
        """Return what the next step takes over: the last optimum and its factorization."""
        counts = (self._age, self.corrected, self.solved)
        numbers = (self._curvature, self.error_bound, self.largest_error)
        return (*self._work, self._rows, self._target, self._motion, counts, numbers)

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the sequence did whose `memory` it is."""
        *work, rows, target, motion, counts, numbers = memory
        for mine, kept in zip((*self._work, self._rows), (*work, rows), strict=True):
            mine[...] = kept
        self._age, self.corrected, self.solved = counts
        self._curvature, self.error_bound, self.largest_error = numbers
        self._remember(target, motion)

    @property
    def hit_rate(self) -> float:
        """Share of the steps that a neighboring extremal answered."""
        return self.corrected / max(1, self.corrected + self.solved)

    def solve(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
        warm_start: Array | None = None,
    ) -> Solution:
        """Return a neighboring extremal or an exact solution, as `ShootingSolver.solve`.

        `Solution.formulation` tells which; a neighboring extremal has ``iterations`` 0, and its
        ``residual`` is what it leaves of the first-order conditions; ``min_curvature`` is that of
        the exact solve whose factorization it uses.
        """
        try:
            plain = attitude.shape == (3, 3) and momentum.shape == (3,)  # type: ignore[union-attr]
            plain = plain and attitude.dtype is momentum.dtype is FLOAT64  # type: ignore[union-attr]
        except AttributeError:  # a list, say
            plain = False
        if not plain:
            attitude, momentum = as_matrix3("attitude", attitude), as_vector3("momentum", momentum)
        with self._lock:
            corrected = None
            if self._age < self._max_age:
                corrected = self._correct(attitude, momentum, reference)
            return corrected or self._exact(attitude, momentum, reference, warm_start)

    def _exact(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None,
        warm_start: Array | None,
    ) -> Solution:
        solution = self.solver.solve(attitude, momentum, reference, warm_start)
        self.solved += 1
        self.error_bound = 0.0
        usable = solution.converged and self.solver.kept[0] == 1
        if usable and self._limit == 0.0:
            largest = float(np.linalg.norm(solution.torques, axis=1).max())
            self.largest_error = self.neighboring.tolerance * largest
        self._age = 0 if usable else self._max_age
        self._curvature = solution.min_curvature
        self._remember(solution.reference, solution.feedforward)
        rows = self._rows
        rows[4:7] = rows[LAST_REFERENCE:] = solution.reference
        rows[7:9] = solution.feedforward
        rows[SEEN] = math.inf, 0.0, 0.0
        rows[LAST : LAST + 3], rows[LAST + 3] = solution.attitudes[0], solution.momenta[0]
        return solution

    def warm_up(self) -> None:
        """Compile or load the kernels."""
        for _ in range(2):
            self.solve(np.eye(3), np.zeros(3))
        self.reset()

    def _correct(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None
    ) -> Solution | None:
        started = perf_counter()
        moving = self._moved
        target: ArrayLike = IDENTITY if reference is None else reference  # type: ignore[assignment]
        if isinstance(reference, Reference):
            target, moving = reference[0], moving or is_moving(reference)
        if moving:
            self._take(reference)
        elif not self._is_last(target):
            return None
        rows = self._rows
        self._attitude[...], self._momentum[...] = attitude, momentum
        plan, layout = np.empty(self._layout.size), self._layout
        good, bound = correct(rows, moving, self.largest_error, plan, *self._work)
        if not good:
            return None
        self._age += 1
        self.corrected += 1
        self.error_bound = bound
        layout.part(plan, 5)[4] = self._curvature
        if moving:
            self._remember(rows[4:7], rows[7:9])
        took = perf_counter() - started
        return Solution.of_plan(plan, layout, CONVERGED, took, self._motion)

    def _is_last(self, target: ArrayLike) -> bool:
        try:
            return bool(target.tobytes() == self._target_bytes)  # type: ignore[union-attr]
        except AttributeError:  # a list, say
            return np.asarray(target, dtype=np.float64).tobytes() == self._target_bytes

    def _take(self, reference: Tracked | None) -> None:
        """Put a moving reference, or what follows one, into ``rows``."""
        tracked = as_reference(reference)
        self._rows[4:7], self._rows[7:9] = tracked.attitude, tracked[1:]

    def _remember(self, attitude: Matrix3, motion: Array) -> None:
        """Keep what was tracked last, in arrays that later solves leave alone."""
        self._target = read_only(attitude.copy())
        self._target_bytes = self._target.tobytes()
        self._motion, self._moved = RESTING, False
        if motion is not RESTING and motion.any():
            self._motion, self._moved = read_only(motion.copy()), True
