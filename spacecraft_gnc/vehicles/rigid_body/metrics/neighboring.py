"""Accuracy of the neighboring extremals of a flight against exact solves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.loop.protocols import Reference, Source

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


def neighboring_metrics(trajectory: Flight, scenario: Scenario | None) -> dict[str, Any]:
    """Return the hit rate, and the largest error against the full re-solve.

    Parameters
    ----------
    trajectory
        What was flown.
    scenario
        Gives the problem to solve; without it the error is None.

    Returns
    -------
    dict
        ``neighboring_share`` of the steps answered by a neighboring extremal, and
        ``neighboring_error`` [N m], the largest norm of the difference between such a torque and
        the exact one from the same state. Both None where no step was.
    """
    answered = np.flatnonzero(trajectory.source == Source.NEIGHBORING_EXTREMAL)
    share = len(answered) / max(1, len(trajectory.source)) if len(answered) else None
    error = None
    if len(answered) and scenario is not None:
        from spacecraft_gnc.ocp import ShootingSolver
        from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import (
            problem_of,  # loads the kernels
        )

        solver = ShootingSolver(problem_of(scenario))
        largest = math.nan
        for k in answered[_recorded(trajectory)[answered]]:
            moving = trajectory.reference_rate[k], trajectory.reference_torque[k]
            reference = Reference(trajectory.reference[k], *moving)
            exact = solver.solve(trajectory.attitude[k], trajectory.momentum[k], reference)
            if exact.converged:
                off = float(np.linalg.norm(exact.torques[0] - trajectory.torque[k]))
                largest = np.fmax(largest, off)
        error = float(largest) if math.isfinite(largest) else None
    return {"neighboring_share": share, "neighboring_error": error}


def _recorded(trajectory: Flight) -> NDArray[np.bool_]:
    """Tell of the (n,) steps whether what their problem starts from was recorded."""
    n = trajectory.n_steps
    given = (trajectory.attitude.reshape(n, 9), trajectory.reference.reshape(n, 9))
    return np.asarray(np.isfinite(np.hstack([*given, trajectory.momentum])).all(axis=1))
