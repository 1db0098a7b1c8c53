"""Indirect single shooting with Newton's method and analytic sensitivities.

The necessary conditions (31)-(38) of Gupta et al. 2015 are run forward from guessed multipliers
lambda_0; Newton's method (43) on the terminal conditions (44) finds them, with the derivative
(39)-(45) carried along the horizon and a backtracking line search on the residual (the paper's
"hybrid" step size). (38) has no inner root finder: see `_stage_kernels.control`.

Errata honoured: (18) the sum over delta u_k starts at k = 0; (42) the multiplier rows are
multiplied only up to index N-2, because (45) needs delta lambda_{N-1}.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from time import perf_counter
from typing import NoReturn

import numpy as np

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp._shooting_kernels import BAD_REFERENCE, BAD_STATE, solve_shooting
from spacecraft_gnc.ocp._stage_kernels import WORK
from spacecraft_gnc.ocp.problem import AttitudeOcp
from spacecraft_gnc.ocp.solution import Solution, Status
from spacecraft_gnc.types import Array, ArrayLike, as_rotation, as_vector3, require_positive

STATUSES = tuple(Status)
VARIANTS = ("exact",)
COLD = np.zeros(6)
COLD.setflags(write=False)
IDENTITY = np.eye(3)
IDENTITY.setflags(write=False)


@dataclass(frozen=True, slots=True)
class ShootingOptions:
    """When Newton's method stops.

    Attributes
    ----------
    residual_tolerance : float
        Largest Euclidean norm of (44) that counts as solved.
    max_iterations : int
        Largest number of Newton steps.
    """

    residual_tolerance: float = 1e-12
    max_iterations: int = 50

    def __post_init__(self) -> None:
        require_positive("residual_tolerance", self.residual_tolerance)
        if self.max_iterations < 1:
            raise ParameterError(
                f"max_iterations: received {self.max_iterations}; required at least 1; give 50"
            )


class ShootingSolver:
    """Solve an `AttitudeOcp` by indirect single shooting.

    Parameters
    ----------
    ocp : AttitudeOcp
    variant : {"exact"}
        Sensitivities used by Newton's method.
    options : ShootingOptions, optional

    Notes
    -----
    A solver owns work space and is not meant for several threads at once; solutions are
    independent of it. The costate recursion is run forward, which amplifies rounding over long
    horizons: horizons of some tens of steps are its range.
    """

    def __init__(
        self, ocp: AttitudeOcp, variant: str = "exact", options: ShootingOptions | None = None
    ) -> None:
        if variant not in VARIANTS:
            raise ParameterError(
                f"variant: received {variant!r}; required one of {', '.join(VARIANTS)}; choose one"
            )
        self.ocp = ocp
        self.variant = variant
        self.options = options or ShootingOptions()
        n = ocp.horizon
        self._n = n
        self._constants = (ocp.body.packed, ocp.data, ocp.zone_rows)
        self._work = (np.zeros((n, WORK)), np.empty((2, 3, 3)), np.empty((3, 6, 12)))
        self._limits = (self.options.residual_tolerance, self.options.max_iterations)
        self._inputs = np.empty((9, 3))

    def solve(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        reference: ArrayLike | None = None,
        warm_start: Array | None = None,
    ) -> Solution:
        """Solve from a state.

        Parameters
        ----------
        attitude : (3, 3) array
            Rotation, body to inertial.
        momentum : (3,) array
            Angular momentum, body frame [N m s].
        reference : (3, 3) array, optional
            Attitude to track, body to inertial; the identity if absent.
        warm_start : (6,) array, optional
            Multipliers to start from, as `Solution.warm_start` of the previous step; else zero.

        Returns
        -------
        Solution
            Whether it converged is in its ``status``; nothing is raised for that.

        Raises
        ------
        ShapeError, ParameterError
            If an argument is not a finite state, a rotation, or six numbers.
        """
        started = perf_counter()
        n = self._n
        target = IDENTITY if reference is None else reference
        guess = COLD if warm_start is None else warm_start
        x = self._inputs  # one array of one type: one compiled kernel for every caller
        try:
            x[:3], x[3], x[4:7] = attitude, momentum, target
            x[7], x[8] = guess[:3], guess[3:]
        except (ValueError, TypeError, IndexError):
            self._refuse(attitude, momentum, target, guess)
        R, Pi, u, lam = (
            np.empty((n + 1, 3, 3)),
            np.empty((n + 1, 3)),
            np.empty((n, 3)),
            np.empty((n, 6)),
        )
        body, data, zones = self._constants
        W, track, scratch = self._work
        code, steps, residual, cost, largest = solve_shooting(
            body, data, zones, x, R, Pi, u, lam, W, track, scratch, *self._limits
        )
        if code in (BAD_STATE, BAD_REFERENCE):
            self._refuse(attitude, momentum, target, guess)
        limit = self.ocp.max_torque
        margin = limit - largest**0.5 if limit > 0.0 else float("inf")
        return Solution(
            u,
            R,
            Pi,
            lam,
            cost,
            STATUSES[code],
            steps,
            residual,
            perf_counter() - started,
            margin,
            x[4:7].copy(),
            self.ocp,
            "single_shooting",
            math.nan,
            np.array([zone.margin(R).min() for zone in self.ocp.zones]),
        )

    def warm_up(self) -> None:
        """Compile or load the kernels, so that the first `solve` in flight costs no more."""
        self.solve(IDENTITY, np.zeros(3))

    def _refuse(
        self, attitude: ArrayLike, momentum: ArrayLike, reference: ArrayLike, guess: ArrayLike
    ) -> NoReturn:
        as_rotation("attitude", attitude)
        as_vector3("momentum", momentum)
        as_rotation("reference", reference)
        raise ParameterError(
            f"warm_start: received {guess!r}; required 6 multipliers; pass the warm_start of a "
            "solution of the same problem"
        )
