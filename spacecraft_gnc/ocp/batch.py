"""Many problems that differ in their initial state only, solved at kernel speed."""

from __future__ import annotations

from time import perf_counter
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arrays import as_finite, as_rows, as_stack
from spacecraft_gnc.errors import ParameterError, ShapeError
from spacecraft_gnc.ocp.problem import AttitudeOcp
from spacecraft_gnc.ocp.reference import Tracked, as_reference, is_moving, unreachable
from spacecraft_gnc.ocp.solution import PlanLayout
from spacecraft_gnc.types import Array, ArrayLike, Reference, as_rotation, as_vector3


class BatchSolver(Protocol):
    """What solves a batch: `ShootingSolver`."""

    @property
    def ocp(self) -> AttitudeOcp:
        """Problem solved."""

    @property
    def layout(self) -> PlanLayout:
        """Where the parts of its plans stand."""

    def run_batch(
        self,
        attitudes: Array,
        momenta: Array,
        reference: Reference,
        warm_starts: Array | None,
        plans: Array,
    ) -> NDArray[np.int64]:
        """Solve from every state in one call of compiled code; return the status of each."""


class BatchSolution(NamedTuple):
    """Solved horizons, one row for each of n states; the fields are those of `Solution`."""

    torques: Array
    """(n, N, 3) [N m]"""
    attitudes: Array
    """(n, N+1, 3, 3)"""
    momenta: Array
    """(n, N+1, 3) [N m s]"""
    costates: Array
    """(n, N, 6)"""
    status: NDArray[np.int64]
    """(n,) values of `Status`."""
    iterations: NDArray[np.int64]
    """(n,)"""
    residual: Array
    """(n,)"""
    cost: Array
    """(n,)"""
    min_curvature: Array
    """(n,)"""
    zone_margins: Array
    """(n, number of zones) [rad]"""
    solve_time: float
    """Wall time of all [s]."""

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(n,) whether each state was solved."""
        return np.asarray(self.status == 0)


def solve_many(
    solver: BatchSolver,
    attitudes: ArrayLike,
    momenta: ArrayLike,
    reference: Tracked | None,
    warm_starts: Array | None,
) -> BatchSolution:
    """Solve from every state; see `ShootingSolver.solve_batch`."""
    begun = perf_counter()
    R, Pi = _states(attitudes, momenta)
    target = as_reference(reference)
    n, steps, layout = len(R), solver.ocp.horizon, solver.layout
    if warm_starts is not None:  # a copy: one array of one type for the one compiled kernel
        shape = (n, steps, 6)
        warm_starts = np.array(as_finite("warm_starts", warm_starts, shape, f"multipliers {shape}"))
    plans = np.empty((n, layout.size))
    status = solver.run_batch(R, Pi, target, warm_starts, plans)
    for row in np.flatnonzero(status < 0):  # name the first state that is none
        as_rotation(f"attitudes[{row}]", R[row])
        as_vector3(f"momenta[{row}]", Pi[row])
        if is_moving(target):
            raise unreachable(target, solver.ocp.time_step)
        received = [*R[row].tolist(), Pi[row].tolist()]
        raise ParameterError(
            f"states[{row}]: received {received}; required a finite state; check its numbers"
        )
    found, momenta_, torques, lam, margins, numbers, _ = layout.parts(plans)
    return BatchSolution(
        torques=torques,
        attitudes=found,
        momenta=momenta_,
        costates=lam[:, :-1],
        status=status,
        iterations=numbers[:, 1].astype(np.int64),
        residual=numbers[:, 2],
        cost=numbers[:, 3],
        min_curvature=numbers[:, 4],
        zone_margins=margins,
        solve_time=perf_counter() - begun,
    )


def _states(attitudes: ArrayLike, momenta: ArrayLike) -> tuple[Array, Array]:
    R, Pi = as_stack("attitudes", attitudes), as_rows("momenta", momenta, 3)
    n = len(R) if R.ndim == 3 else 0
    if R.shape != (n, 3, 3) or Pi.shape != (n, 3) or n == 0:
        raise ShapeError(
            f"attitudes, momenta: received arrays of shapes {R.shape} and {Pi.shape}; required "
            "(n, 3, 3) and (n, 3) with n >= 1; stack one state in each row"
        )
    return np.array(R), np.array(Pi)  # copies, of the types that the kernel is compiled for
