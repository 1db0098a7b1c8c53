"""Continuation: reach a problem that does not solve from one that does.

Source: Gupta et al. 2015, Remark III, whose two scenarios these are: in the weight of the
penalties, and in the initial state.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import require_kind
from spacecraft_gnc.ocp.problem import AttitudeOcp
from spacecraft_gnc.ocp.shooting import ShootingOptions, ShootingSolver
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.types import Array, ArrayLike, as_rotation, as_vector3

SMALLEST_SHARE = 1e-8  # of the penalties, with which a penalty continuation starts
FACTOR = 100.0  # between two of its problems
SMALLEST_ADVANCE = 1.0 / 1024.0  # share of the way below which a state continuation gives up


class PenaltyContinuation:
    """Solve with soft penalties first, and harden them step by step.

    Parameters
    ----------
    ocp : AttitudeOcp
    options : ShootingOptions, optional
    """

    def __init__(self, ocp: AttitudeOcp, options: ShootingOptions | None = None) -> None:
        require_kind("ocp", ocp, AttitudeOcp)
        shares = [1.0]
        while shares[-1] > SMALLEST_SHARE * FACTOR:
            shares.append(shares[-1] / FACTOR)
        self._solvers = [
            ShootingSolver(_softened(ocp, share) if share < 1.0 else ocp, options=options)
            for share in reversed(shares)
        ]

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: ArrayLike | None = None
    ) -> Solution:
        """Return the solution at full penalties; its ``iterations`` count all problems' steps."""
        guess: Array | None = None
        iterations = 0
        for solver in self._solvers:
            solution = solver.solve(attitude, momentum, reference, guess)
            iterations += solution.iterations
            if np.isfinite(solution.costates).all():
                guess = solution.costates
        return solution._replace(iterations=iterations)


class StateContinuation:
    """Start at rest on the target, whose solution is zero, and move the initial state away.

    The state moves along the shortest rotation with a momentum that grows in proportion; the step
    is halved where a solve fails.

    Parameters
    ----------
    ocp : AttitudeOcp
    options : ShootingOptions, optional
    """

    def __init__(self, ocp: AttitudeOcp, options: ShootingOptions | None = None) -> None:
        self._solver = ShootingSolver(ocp, options=options)

    def solve(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: ArrayLike | None = None
    ) -> Solution:
        """Return the solution at the state asked for; its ``iterations`` count all steps made.

        Where the way is blocked it is the failed solve nearest to it.
        """
        target = as_rotation("reference", np.eye(3) if reference is None else reference)
        R, Pi = as_rotation("attitude", attitude), as_vector3("momentum", momentum)
        turn = lie.log(target.T @ R)
        share, advance, iterations = 0.0, 0.25, 0
        guess: Array | None = None
        while True:
            following = min(1.0, share + advance)
            start = R if following == 1.0 else target @ lie.exp(following * turn)
            solution = self._solver.solve(start, following * Pi, reference, guess)
            iterations += solution.iterations
            if solution.converged:
                share, guess = following, solution.costates
                advance *= 2.0
            else:
                advance *= 0.5
            if share == 1.0 or advance < SMALLEST_ADVANCE:
                return solution._replace(iterations=iterations)


def _softened(ocp: AttitudeOcp, share: float) -> AttitudeOcp:
    """Return the same problem with its penalties scaled down."""
    zones = tuple(replace(zone, penalty=share * zone.penalty) for zone in ocp.zones)
    return replace(ocp, torque_penalty=share * ocp.torque_penalty, zones=zones)
