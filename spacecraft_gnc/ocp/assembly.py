"""Solutions of methods that are not kernels of their own."""

from __future__ import annotations

import math

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.problem import AttitudeOcp
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Reference


def assemble(
    ocp: AttitudeOcp,
    horizon: tuple[Array, Array, Array, Array],
    reference: Reference,
    outcome: tuple[Status, int, float, float],
    largest_control: float,
    formulation: str,
) -> Solution:
    """Return the `Solution` of a finished solve, with margins and angles computed from its plan.

    ``horizon`` is (attitudes, momenta, torques, costates), ``outcome`` (status, iterations,
    residual, cost). Curvature and solve time are left to the caller.
    """
    attitudes, momenta, torques, costates = horizon
    status, iterations, residual, cost = outcome
    limit = ocp.max_torque
    return Solution(
        torques=torques,
        attitudes=attitudes,
        momenta=momenta,
        multipliers=np.vstack([costates, costates[-1:]]),
        cost=cost,
        status=status,
        iterations=iterations,
        residual=residual,
        solve_time=math.nan,
        torque_margin=limit - largest_control if limit > 0.0 else math.inf,
        reference=np.asarray(reference.attitude),
        ocp=ocp,
        formulation=formulation,
        min_curvature=math.nan,
        zone_margins=np.array([zone.margin(attitudes).min() for zone in ocp.zones]),
        attitude_error=lie.angle_between(reference.attitude, attitudes[0]),
        travel=lie.angle_between(attitudes[0], attitudes[-1]),
        feedforward=np.array(reference[1:]),
    )


def failed(
    ocp: AttitudeOcp, state: tuple[Array, Array], reference: Reference, status: Status, method: str
) -> Solution:
    """Return the `Solution` of a solve that left no plan: NaN beyond the initial state."""
    n = ocp.horizon
    attitudes, momenta = np.full((n + 1, 3, 3), math.nan), np.full((n + 1, 3), math.nan)
    attitudes[0], momenta[0] = state
    plan = (attitudes, momenta, np.full((n, 3), math.nan), np.full((n, 6), math.nan))
    outcome = (status, 0, math.inf, math.nan)
    return assemble(ocp, plan, reference, outcome, math.nan, method)
