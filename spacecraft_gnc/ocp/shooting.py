"""Indirect shooting: Newton's method on the first-order conditions, with analytic sensitivities.

The necessary conditions (31)-(38) of Gupta et al. 2015 form a two-point boundary value problem in
the multipliers lambda. Two formulations of Newton's method solve it:

- ``single_shooting``, the paper's (39)-(45): the unknowns are the multipliers of the first step,
  everything is run forward, and the terminal conditions (44) are the residual. The costates are
  unstable in that direction, so that accuracy is lost over long or stiff horizons.
- ``backward_sweep``: the unknowns are the multipliers lambda2_k of every step. Controls follow from
  (38), the states from a rollout, the costates from (34)-(37) run backward, where they are stable,
  and the residual is lambda2 - guess. The linear system is solved by a Riccati-like sweep, at a
  cost linear in the horizon. The residual is the gradient of the cost, so a line search on the
  cost (and Levenberg's term where the pivots are not positive) leads downhill, and the pivots
  tell minima from saddles.

``auto`` takes the backward sweep at every horizon: docs/solver.md has the measurements.
`Solution.formulation` says which one was used. (38) has no inner root finder: see
`_stage_kernels.control`.

Errata honored: Gupta (18), the sum over delta u_k starts at k = 0; (42), the multiplier rows are
multiplied only up to index N-2, because (45) needs delta lambda_{N-1}. Bagherzadeh et al. 2023
(33): "+2 mu S(u) S(du) S(u)" is -4 mu S(u) S(du) S(u), and only where the limit acts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from threading import Lock
from time import perf_counter
from typing import Any, Final, NoReturn

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc._kernels import GIVEN, OWN, entry
from spacecraft_gnc.arguments import (
    as_count,
    as_real,
    require_kind,
    require_positive,
    require_word,
)
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.ocp._solve_kernels import (
    BAD_REFERENCE,
    BAD_SHAPE,
    MOTION_AT,
    TAIL,
    make_arena,
    solve,
    solve_batch,
)
from spacecraft_gnc.ocp.batch import BatchSolution, solve_many
from spacecraft_gnc.ocp.problem import AttitudeOcp
from spacecraft_gnc.ocp.reference import (
    Tracked,
    as_reference,
    is_fixed,
    is_moving,
    motion_of,
    unreachable,
)
from spacecraft_gnc.ocp.solution import PlanLayout, Solution
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Reference,
    as_matrix3,
    as_rotation,
    as_vector3,
)

VARIANTS = ("exact", "estimated_du", "estimated_u")
FORMULATIONS = ("auto", "backward_sweep", "single_shooting")
AUTOMATIC = "backward_sweep"  # at every horizon the faster one, and the only one on long ones
STEP_RULES = ("backtracking", "full", "damped", "chord")
IDENTITY: Final = np.eye(3)
IDENTITY.setflags(write=False)


@dataclass(frozen=True, slots=True)
class ShootingOptions:
    """How Newton's method goes, and when it stops.

    Attributes
    ----------
    residual_tolerance : float
        Largest Euclidean norm of the residual that counts as solved, relative to max |lambda2|, and
        so the same in all units. What rounding leaves of the terms of lambda2 is allowed for.
    max_iterations : int
        Largest number of Newton steps.
    formulation : {"auto", "backward_sweep", "single_shooting"}
    step_rule : {"backtracking", "full", "damped", "chord"}
        backtracking: full steps, shortened until they make progress (the paper's "hybrid" step
        size). full, damped: steps of fixed length gamma in (43). chord (Newton-Kantorovich): the
        Jacobian is kept over iterations and solves as long as the residual halves with it, and
        made anew, with backtracking, where it does not.
    damping : float
        gamma of ``damped``, in (0, 1].
    """

    residual_tolerance: float = 1e-12
    max_iterations: int = 50
    formulation: str = "auto"
    step_rule: str = "backtracking"
    damping: float = 0.5

    def __post_init__(self) -> None:
        require_word("formulation", self.formulation, FORMULATIONS)
        require_word("step_rule", self.step_rule, STEP_RULES)
        checked = {
            "residual_tolerance": require_positive("residual_tolerance", self.residual_tolerance),
            "max_iterations": as_count("max_iterations", self.max_iterations, remedy="give 50"),
            "damping": as_real(
                "damping", self.damping, lambda x: 0.0 < x <= 1.0, "a step length in (0, 1]",
                "give 0.5",
            ),
        }  # fmt: skip
        for name, value in checked.items():
            object.__setattr__(self, name, value)


@cache
def solve_kernel() -> Any:
    """Return the compiled `solve`, for states and references of any layout."""
    vector, matrix = GIVEN
    return entry(solve, matrix, vector, matrix, matrix, OWN[0], *OWN)


class ShootingSolver:
    """Solve an `AttitudeOcp` by Newton's method on its first-order conditions.

    Parameters
    ----------
    ocp : AttitudeOcp
    variant : {"exact", "estimated_du", "estimated_u"}
        Sensitivity of the controls in Newton's method: that of (38) (exact), or Bagherzadeh's (40),
        which leaves out what the torque limit adds. ``estimated_u`` also finds the controls by (41)
        first and again by (26) where they exceed the limit; every variant here does, since (26) is
        solved in closed form, so that the two estimated variants make the same numbers.
    options : ShootingOptions, optional

    Attributes
    ----------
    formulation : str
        What ``auto`` came to.
    work
        Problem, settings and work space, as the kernels of this package share them.
    layout : PlanLayout
        Where the parts of the flat plans stand that they fill.

    Notes
    -----
    A solver owns work space; a second thread waits until the first has its solution, which is
    independent of that space. Only the step rule ``chord`` carries anything from one solve to the
    next.
    """

    def __init__(
        self, ocp: AttitudeOcp, variant: str = "exact", options: ShootingOptions | None = None
    ) -> None:
        require_word("variant", variant, VARIANTS)
        self.ocp = require_kind("ocp", ocp, AttitudeOcp)
        self.variant = variant
        options = ShootingOptions() if options is None else options
        self.options = require_kind("options", options, ShootingOptions)
        self.formulation = AUTOMATIC if options.formulation == "auto" else options.formulation
        settings = (
            self.formulation == "single_shooting",
            STEP_RULES.index(options.step_rule),
            options.damping,
            variant != "exact",
            options.residual_tolerance,
            options.max_iterations,
        )
        n = ocp.horizon
        arena = make_arena(ocp.body.packed, ocp.data, ocp.zone_rows, n, settings)
        self.work = (arena, np.zeros(4, np.int64))
        self.layout = PlanLayout(ocp, self.formulation)
        self._size, self._cold = self.layout.size, np.zeros((n, 6))
        self._motion = arena[len(arena) - TAIL + MOTION_AT :].reshape(2, 3)
        self._moved = False  # whether the last reference did
        self._at_rest: Reference | None = None  # the last one that never will
        self._lock = Lock()

    def __reduce__(self) -> tuple[type[ShootingSolver], tuple[AttitudeOcp, str, ShootingOptions]]:
        """Copy and pickle the settings; work space is no part of them."""
        return type(self), (self.ocp, self.variant, self.options)

    def __repr__(self) -> str:
        """Return what is solved, and how, in one line."""
        o = self.options
        return (
            f"ShootingSolver({self.ocp!r}, {self.variant}, {self.formulation}, {o.step_rule}, "
            f"residual <= {o.residual_tolerance:g} within {o.max_iterations} iterations)"
        )

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
            Attitude to track, body to inertial, at the first step; the identity if absent. A
            `Reference` goes on from there at its angular velocity, with its torque.
        warm_start : (N, 6) array, optional
            Multipliers to start from, as the previous step's `Solution.warm_start`; zero if absent.

        Returns
        -------
        Solution
            Whether it converged is in its ``status``; nothing is raised for that.

        Raises
        ------
        ShapeError, ParameterError
            If an argument is not a finite state, a rotation, or multipliers of this horizon.
        """
        started = perf_counter()
        target: ArrayLike = IDENTITY if reference is None else reference  # type: ignore[assignment]
        motion = None
        if isinstance(reference, Reference):
            target = reference.attitude
            if reference is not self._at_rest:  # governors give the same one again
                if is_moving(reference):
                    motion = motion_of(reference)
                elif is_fixed(reference):
                    self._at_rest = reference
        guess = self._cold if warm_start is None else warm_start
        plan = np.empty(self._size)
        with self._lock:
            if motion is not None or self._moved:
                self._moved = motion is not None
                self._motion[...] = 0.0 if motion is None else motion
            try:
                status = solve_kernel()(attitude, momentum, target, guess, plan, *self.work)
            except TypeError:  # a list, say
                status = BAD_SHAPE
            if status == BAD_SHAPE:
                attitude, momentum = (
                    as_matrix3("attitude", attitude),
                    as_vector3("momentum", momentum),
                )
                target, guess = as_matrix3("reference", target), self.ocp.checked_warm_start(guess)
                status = solve_kernel()(attitude, momentum, target, guess, plan, *self.work)
        if status < 0:
            self._refuse(status, attitude, momentum, reference)
        took = perf_counter() - started
        if motion is None:
            return Solution.of_plan(plan, self.layout, status, took)
        return Solution.of_plan(plan, self.layout, status, took, motion)

    def solve_batch(
        self,
        attitudes: ArrayLike,
        momenta: ArrayLike,
        reference: Tracked | None = None,
        warm_starts: Array | None = None,
    ) -> BatchSolution:
        """Solve from many states, each by itself, without leaving compiled code.

        Parameters
        ----------
        attitudes : (n, 3, 3) array
            Rotations, body to inertial.
        momenta : (n, 3) array
            Angular momenta, body frame [N m s].
        reference : (3, 3) array or Reference, optional
            What all of them track, as in `solve`; the identity if absent.
        warm_starts : (n, N, 6) array, optional
            Multipliers to start each solve from; zero if absent.

        Returns
        -------
        BatchSolution
            A row for each state; what did not converge says so in ``status``.

        Raises
        ------
        ShapeError, ParameterError
            If an argument has another shape, or any state is refused by `solve`.
        """
        return solve_many(self, attitudes, momenta, reference, warm_starts)

    def run_batch(
        self,
        attitudes: Array,
        momenta: Array,
        reference: Reference,
        warm_starts: Array | None,
        plans: Array,
    ) -> NDArray[np.int64]:
        """Run the batch kernel into flat ``plans``; return the status of each."""
        guesses = self._cold[None] if warm_starts is None else warm_starts
        status = np.empty(len(attitudes), np.int64)
        with self._lock:
            self._moved, self._motion[...] = True, np.asarray(reference[1:])
            target = np.array(reference.attitude)
            solve_batch(attitudes, momenta, target, guesses, plans, *self.work, status)
        return status

    @property
    def kept(self) -> NDArray[np.int64]:
        """(4,) whether the work space holds a factorization, and the limits that acted there."""
        return self.work[1]

    def memory(self) -> tuple[Any, ...]:
        """Return what the next solve takes over from those before: nothing without a chord."""
        return self.work if self.options.step_rule == "chord" else ()

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Solve next as the solver did whose `memory` it is."""
        for mine, kept in zip(self.work, memory, strict=False):
            mine[...] = kept

    def warm_up(self) -> None:
        """Compile or load the kernels, so that the first `solve` in flight costs no more."""
        self.solve(IDENTITY, np.zeros(3))

    def _refuse(
        self, code: int, attitude: ArrayLike, momentum: ArrayLike, reference: Tracked | None
    ) -> NoReturn:
        as_rotation("attitude", attitude)
        as_vector3("momentum", momentum)
        tracked = as_reference(reference)
        if code == BAD_REFERENCE:
            raise unreachable(tracked, self.ocp.time_step)
        raise ParameterError(
            "warm_start: received NaN or infinity; required finite multipliers; pass the "
            "warm_start of a converged solution, or None to start from zero"
        )
