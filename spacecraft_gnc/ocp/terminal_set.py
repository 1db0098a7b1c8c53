"""Solver of the terminal-set NMPC: a hard torque limit and a terminal set.

Newton's method on the first-order conditions, by the backward sweep of `shooting`: the torque limit
enters the control law, T = argmin T . M T / 2 - lam . T over |T| <= max_torque, whose derivative is
exact too, so that a limit that acts is kept to rounding. The terminal set |x_N|_P^2 <= c shares its
function with the terminal cost F: its multiplier nu >= 0 only makes (1 + nu) F of it, and is found
by a search for the root of log(|x_N|_P^2 / c), which falls in nu. Where even the largest nu leaves
the end of the horizon outside, the problem is infeasible: F(nu) is then within (J_1 - J_2) / nu of
the least F that the torque limit allows, J being the sums of stage costs. Source: Kalabic et al.
2014, (24)-(32).
"""

from __future__ import annotations

import math
from threading import Lock
from time import perf_counter
from typing import TypeAlias

import numpy as np

from spacecraft_gnc.arguments import as_count, require_kind
from spacecraft_gnc.dynamics._lgvi_kernels import BODY_SIZE
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp._data_kernels import MADE_OF, MU0, P_LOG
from spacecraft_gnc.ocp.reference import Tracked, is_moving
from spacecraft_gnc.ocp.shooting import IDENTITY, ShootingOptions, ShootingSolver
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.ocp.terminal_problem import TerminalSetOcp
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, ArrayLike, Reference

LARGEST = math.log(1e8)  # of log(1 + nu)
PENALTIES = 10.0 ** np.arange(-2.0, 9.0)  # of the torque limit, as it is hardened
ON_BORDER = 1e-9  # the level found lies between (1 - this) c and c
SEARCHES = 60
LARGEST_HORIZON = 4096
Problem: TypeAlias = tuple[ArrayLike, ArrayLike, Tracked | None]


class TerminalSetSolver:
    """Solve a `TerminalSetOcp`.

    Parameters
    ----------
    ocp : TerminalSetOcp
    options : ShootingOptions, optional
        Tolerance and largest number of Newton steps.

    Notes
    -----
    A warm solve also starts from the multiplier of the terminal set that the last one found. A
    second thread waits until the first has its solution.
    """

    def __init__(self, ocp: TerminalSetOcp, options: ShootingOptions | None = None) -> None:
        self.ocp = require_kind("ocp", ocp, TerminalSetOcp)
        self._newton = ShootingSolver(ocp, "exact", options)
        at = BODY_SIZE + P_LOG
        self._weight = self._newton.work[0][at : at + 36]
        self._riccati = ocp.terminal.riccati.ravel()
        at = BODY_SIZE + MADE_OF
        self._made_of, self._terms = self._newton.work[0][at : at + 2], ocp.data[MADE_OF:][:2]
        self._last = 0.0
        self._lock = Lock()

    def __reduce__(self) -> tuple[type[TerminalSetSolver], tuple[TerminalSetOcp, ShootingOptions]]:
        """Copy and pickle the settings; work space is no part of them."""
        return type(self), (self.ocp, self._newton.options)

    def solve(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
        warm_start: Array | None = None,
    ) -> Solution:
        """Solve from a state.

        Parameters
        ----------
        attitude : (3, 3) array
            Rotation, body to inertial.
        momentum : (3,) array
            Angular momentum, body frame [N m s].
        reference : (3, 3) array or Reference, optional
            Attitude to track, body to inertial; the identity if absent. It must be at rest: the
            terminal set is invariant around rest only.
        warm_start : (N, 6) array, optional
            Multipliers to start from, as the previous step's `Solution.warm_start`; zero if absent.

        Returns
        -------
        Solution
            Whether it converged is in its ``status``; INFEASIBLE where no torque within the limit
            reaches the terminal set: the solution is then the one that comes nearest to it, and its
            ``terminal_level`` the least that can be reached.

        Raises
        ------
        ShapeError, ParameterError
            If an argument is not a finite state, a rotation, or multipliers of this horizon, or
            the reference moves.
        """
        started = perf_counter()
        search = _Search(self, (attitude, momentum, reference), warm_start)
        with self._lock:
            found = search.run(self._last if warm_start is not None else 0.0)
            self._last = math.log1p(found.terminal_multiplier) if found.converged else 0.0
        if not self.ocp.body.is_solvable(found.momenta[-1]) and found.converged:
            found = found.replace(status=Status.UNSOLVABLE_STEP)
        return found.replace(solve_time=perf_counter() - started)

    def least_level(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None = None
    ) -> Solution:
        """Return the solution that ends as near to the target as the torque limit allows.

        Its ``terminal_level`` is the least |x_N|_P^2 that the horizon can reach.
        """
        search = _Search(self, (attitude, momentum, reference), None)
        with self._lock:
            found = search.at(0.0)
            for s in np.linspace(0.0, LARGEST, 5)[1:]:
                if found.converged:
                    found = search.at(float(s))
        return found

    def sufficient_horizon(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: Tracked | None = None,
        largest: int = LARGEST_HORIZON,
    ) -> int | None:
        """Return the least horizon that reaches the terminal set; None if none up to ``largest``.

        By bisection, which finds the least one where a longer horizon reaches no less: from rest it
        does.
        """
        problem = (attitude, momentum, reference)
        largest = as_count("largest", largest)
        too_short, n = 0, 1
        while not self._reaches(problem, n):
            if n == largest:
                return None
            too_short, n = n, min(2 * n, largest)
        while n - too_short > 1:
            middle = (n + too_short) // 2
            if self._reaches(problem, middle):
                n = middle
            else:
                too_short = middle
        return n

    def _reaches(self, problem: Problem, horizon: int) -> bool:
        other = TerminalSetSolver(self.ocp.with_horizon(horizon), self._newton.options)
        return other.solve(*problem).converged

    def memory(self) -> tuple[float]:
        """Return what the next solve takes over from those before: log(1 + nu)."""
        return (self._last,)

    def recall(self, memory: tuple[float]) -> None:
        """Solve next as the solver did whose `memory` it is."""
        (self._last,) = memory

    def warm_up(self) -> None:
        """Compile or load the kernels, so that the first `solve` in flight costs no more."""
        self.solve(IDENTITY, np.zeros(3))

    def newton(self, problem: Problem, guess: Array | None, s: float) -> Solution:
        """Solve with the terminal cost exp(s) F.

        Where Newton's method fails cold, the torque limit is softened and hardened again.
        """
        self._weight[:] = math.exp(s) * self._riccati
        self._made_of[:] = math.exp(s) * self._terms
        found = self._newton.solve(*problem, guess)
        steps = found.iterations
        if not found.converged and guess is not None:
            found = self._newton.solve(*problem)
            steps += found.iterations
        if not found.converged and self.ocp.max_torque > 0.0:
            limit, guess = self._newton.work[0], None
            hardest = float(self.ocp.control_weights[0]) / self.ocp.max_torque**2
            for penalty in (*(hardest * PENALTIES), math.inf):
                limit[BODY_SIZE + MU0] = penalty
                found = self._newton.solve(*problem, guess)
                steps += found.iterations
                guess = found.costates if found.converged else guess
            limit[BODY_SIZE + MU0] = math.inf
        return found.replace(iterations=steps)


class _Search:
    """The search for log(1 + nu) in one solve."""

    def __init__(
        self,
        solver: TerminalSetSolver,
        problem: Problem,
        guess: Array | None,
    ) -> None:
        _require_rest(problem[2])
        self._solver = solver
        self._problem = problem
        self._guess = guess
        self._guess_at: float | None = None
        self._steps = 0

    def at(self, s: float) -> Solution:
        """Solve with exp(s) F, from what was found last; its costates grow with the weight."""
        guess = self._guess
        if guess is not None and self._guess_at is not None:
            guess = guess * math.exp(s - self._guess_at)
        found = self._solver.newton(self._problem, guess, s)
        self._steps += found.iterations
        if found.converged:
            self._guess, self._guess_at = found.costates, s
        ocp = self._solver.ocp
        level = math.nan
        if found.converged or math.isfinite(found.cost):
            state = ocp.terminal_state(found.attitudes, found.momenta, found.reference)
            level = ocp.level_of(state)
        nu = math.expm1(s)
        return found.replace(
            iterations=self._steps,
            terminal_level=level,
            terminal_multiplier=nu,
            ocp=ocp.weighted(nu) if nu > 0.0 else ocp,
            cost=found.cost - 0.5 * nu * level if nu > 0.0 else found.cost,
        )

    def _is_out_of_reach(self, found: Solution, level: float) -> bool:
        """Tell whether no trajectory could do with so little F, however much its stages cost."""
        F = 0.5 * found.terminal_level
        dearer = self._solver.ocp.largest_stage_cost(found.momenta[0]) - (found.cost - F)
        return F - 0.5 * level > dearer / (1.0 + found.terminal_multiplier)

    def run(self, s: float) -> Solution:
        """Return the solution with the multiplier at which the terminal set holds."""
        level = self._solver.ocp.level
        found = self.at(s)
        if level is None or not found.converged:
            return found
        inside: tuple[float, float, Solution] | None = None
        outside: tuple[float, float] | None = None
        stride = 1.0
        for _ in range(SEARCHES):
            f = math.log(max(found.terminal_level, 1e-300) / level.value)
            if f <= 0.0 and (s == 0.0 or f >= -ON_BORDER):
                return found
            if f <= 0.0:
                inside = (s, f, found)
            elif s >= LARGEST or self._is_out_of_reach(found, level.value):
                return found.replace(status=Status.INFEASIBLE)
            else:
                outside = (s, f)
            if inside is None:
                s = min(s + stride, LARGEST)
                stride *= 2.0
            elif outside is None:
                s = max(s - stride, 0.0)
                stride *= 2.0
            else:
                s = _between(outside, inside)
            found = self.at(s)
            if not found.converged:
                return found
        return inside[2] if inside is not None else found


def _require_rest(reference: Tracked | None) -> None:
    if isinstance(reference, Reference) and is_moving(reference):
        rate, torque = (" ".join(f"{x:.6g}" for x in row) for row in reference[1:])
        raise ParameterError(
            f"reference: received angular velocity [{rate}] rad/s and torque [{torque}] N m; "
            "required a reference at rest, around which alone the terminal set is invariant "
            "(Kalabic et al. 2014, (29)); track it with method shooting"
        )


def _between(outside: tuple[float, float], inside: tuple[float, float, Solution]) -> float:
    """Next point by the secant, aimed at the middle of the border, kept off the ends."""
    a, fa = outside
    b, fb = inside[:2]
    target = -0.5 * ON_BORDER
    s = a + (b - a) * (fa - target) / (fa - fb)
    edge = 1e-3 * (b - a)
    return min(max(s, a + edge), b - edge) if b - a > 1e-9 else s
