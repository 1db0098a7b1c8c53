"""Standstills of the loop: stability certificate, and escape from an unstable one.

A stalled spacecraft can sit at a strict minimum of every horizon and still be at an unstable
equilibrium of the closed loop: behind a pointing zone that lies exactly across its way, or half a
turn from its target. No solve of one horizon sees that. Where motion has stopped away from the
target, the one-step closed loop is linearized with the neighboring-extremal gain, x+ = A x + d:

- its fixed point (I - A)^-1 d lies far off: the loop is only slow, nothing is said;
- a spectral radius above 1: the equilibrium is unstable, and the loop leaves it along the unstable
  eigenvector, by a torque added to the optimal one (see `_escape_torque` for its rule);
- below 1: the loop is stalled, and the constraint that it leans on is named.

Source: `docs/solver.md`; the closed loop of Gupta et al. 2015, Case II, which parks at 26.883 deg.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from spacecraft_gnc.dynamics import state_units
from spacecraft_gnc.ocp import AttitudeOcp, Solution
from spacecraft_gnc.ocp.linearization import deviation, linearize
from spacecraft_gnc.types import Array, Vector3
from spacecraft_gnc.vehicles.rigid_body.controllers.report import Standstill

QUIET = 1e-3  # share of the error that motion and torque would cover in one horizon
SLOW = 0.05  # share of the error that the plan turns, below which motion may have stopped
NEAR = 0.25  # share of the error within which the fixed point lies
MARGINAL = 1e-6  # radii up to 1 + this are stable: an idle axis has 1 twice, known to 1e-8 only
NOISE = 1e-6  # amplitude, in `state_units`, below which that of the unstable mode is rounding
PUSH = 1e-2  # share of the error that the escape torque covers in one horizon
TOUCHING = 1e-3  # angle [rad] to a zone, share of the torque limit, that counts as active

T = TypeVar("T", float, Array)


class Finding(NamedTuple):
    """What the monitor found at a standstill."""

    standstill: Standstill
    torque: Vector3
    """(3,) torque to fly [N m]: the optimal one, or its sum with the escape torque."""


class StandstillMonitor:
    """Examines the loop where it has stopped away from its target.

    Parameters
    ----------
    ocp : AttitudeOcp
    error_tolerance : float
        Attitude error [rad] below which the loop counts as arrived; 0 switches the monitor off.
    zone_names : sequence of str, optional
        Names of ``ocp.zones``, to name the constraint that a stall leans on.
    """

    def __init__(
        self, ocp: AttitudeOcp, error_tolerance: float, zone_names: Sequence[str] = ()
    ) -> None:
        self._ocp = ocp
        self._tolerance = error_tolerance if error_tolerance > 0.0 else math.inf
        self._names = tuple(zone_names) or tuple(f"zone {i}" for i in range(len(ocp.zones)))
        self._smallest_inertia = float(np.linalg.eigvalsh(np.asarray(ocp.inertia))[0])
        self._units = state_units(np.asarray(ocp.inertia), ocp.time_step)
        self._horizon_time = ocp.horizon * ocp.time_step

    @property
    def rest(self) -> tuple[float, float, float, float]:
        """What `may_stand` compares with.

        Tolerance [rad], share of the error that a plan turns, horizon [s], and the momentum that
        counts as rest, for an error of one radian [N m s^2].
        """
        share = QUIET * self._smallest_inertia
        return self._tolerance, SLOW, self._horizon_time, share

    def examine(self, solution: Solution) -> Finding | None:
        """Return what is to be said of a converged solution; None in ordinary flight.

        None, too, where the reference moves: there is no rest to come to.
        """
        error = solution.attitude_error
        if error <= self._tolerance or solution.travel > SLOW * error:  # before any norm
            return None
        momentum = math.sqrt(float(solution.momenta[0] @ solution.momenta[0]))
        torque = math.sqrt(float(solution.torques[0] @ solution.torques[0]))
        if not self.may_stand(error, solution.travel, momentum, torque):
            return None
        if solution.feedforward.any():  # what it is to follow does not stand still
            return None
        return self._certify(solution, error)

    def may_stand(self, error: T, travel: T, momentum: T, torque: T) -> Any:
        """Tell whether motion has stopped away from the target, of one horizon or of an array.

        Parameters
        ----------
        error, travel : float or (n,) array
            Angle from the reference, and the one turned over the horizon [rad].
        momentum, torque : float or (n,) array
            Norms at the start of the horizon [N m s], [N m].
        """
        tolerance, slow, span, share = self.rest
        stopped = momentum * span + 0.5 * torque * span**2 <= share * error
        return (error > tolerance) & (travel <= slow * error) & stopped

    def _certify(self, solution: Solution, error: float) -> Finding | None:
        units = self._units
        loop = linearize(solution).closed_loop * units / units[:, None]
        attitudes, momenta = solution.attitudes, solution.momenta
        drift = deviation(attitudes[1], momenta[1], attitudes[0], momenta[0]) / units
        to_fixed_point = np.asarray(np.linalg.lstsq(np.eye(6) - loop, drift, rcond=None)[0])
        if not np.isfinite(loop).all() or np.linalg.norm(to_fixed_point[:3]) > NEAR * error:
            return None
        values, vectors = np.linalg.eig(loop.T)  # left eigenvectors: w . x is a mode's amplitude
        worst = int(np.argmax(np.abs(values)))
        radius = float(np.abs(values[worst]))
        if radius <= 1.0 + MARGINAL:
            stalled = Standstill(radius, False, self._active(solution))
            return Finding(stalled, solution.torques[0])
        push = self._escape_torque(vectors[:, worst].real, -to_fixed_point, error)
        torque = self._ocp.realizable(solution.torques[0] + push)
        return Finding(Standstill(radius, bool(push.any()), self._active(solution)), torque)

    def _escape_torque(self, mode: Array, offset: Array, error: float) -> Vector3:
        """Torque that moves the unstable mode's amplitude the most; both are in `state_units`.

        Its sign keeps the way the loop has already left its fixed point; where that is below
        rounding, the largest component is positive. Its size would turn the body by `PUSH` of the
        error within one horizon, where the torque limit allows.
        """
        ocp = self._ocp
        direction = ocp.torque_map @ (ocp.allocation @ mode[3:])
        length = float(np.linalg.norm(direction))
        if length <= 1e-9 * float(np.linalg.norm(mode)):
            return np.zeros(3)  # no actuator reaches the mode
        direction = direction / length
        amplitude = float(mode @ offset)
        if abs(amplitude) <= NOISE * np.linalg.norm(mode):
            amplitude = float(direction[np.argmax(np.abs(direction))])
        size = PUSH * error * self._smallest_inertia / (ocp.time_step * self._horizon_time)
        return ocp.realizable(np.asarray(math.copysign(size, amplitude) * direction))

    def _active(self, solution: Solution) -> str:
        """Name of the constraint nearest to its bound; empty where none is active."""
        if len(solution.zone_margins):
            closest = int(np.argmin(solution.zone_margins))
            if solution.zone_margins[closest] < TOUCHING:
                return self._names[closest]
        limit = self._ocp.max_torque
        return "torque limit" if solution.torque_margin < TOUCHING * limit else ""
