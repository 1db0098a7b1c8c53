"""The linear terminal controller of the terminal-set NMPC, and its quadratic cost.

Source: Kalabic et al. 2014, (16)-(28).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from spacecraft_gnc.dynamics import state_units
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array, Matrix3


class TerminalController(NamedTuple):
    """kappa = K x for x = (Z, Pi), and F = x . P x / 2, the cost to go of the linearized loop."""

    riccati: Array
    """(6, 6) P of (27)."""
    gain: Array
    """(3, 6) K of (28) [N m/rad, 1/s]."""

    @classmethod
    def design(
        cls,
        inertia: Matrix3,
        time_step: float,
        stage_attitude: Matrix3,
        stage_rate: Matrix3,
        stage_torque: Matrix3,
    ) -> TerminalController:
        """Solve the Riccati equation (27), in `state_units` and units of the attitude's weight.

        Parameters
        ----------
        inertia : (3, 3) array
            Body frame [kg m^2].
        time_step : float
            [s]
        stage_attitude, stage_rate, stage_torque : (3, 3) array
            Q1, Q2 and M of (25).

        Raises
        ------
        ParameterError
            If it has no stabilizing solution.
        """
        import scipy.linalg  # loads for long, and for this method only

        inverse, zero = np.linalg.inv(inertia), np.zeros((3, 3))
        units, cost = state_units(inertia, time_step), float(np.abs(stage_attitude).max())
        momentum, torque = units[3], units[3] / time_step
        A = np.block([[np.eye(3), time_step * momentum * inverse], [zero, np.eye(3)]])
        B = np.vstack([zero, np.eye(3)])
        attitude, rate = _trace_minus(stage_attitude), inverse @ _trace_minus(stage_rate) @ inverse
        rate *= 0.5 * momentum**2
        Q = np.block([[attitude, zero], [zero, rate + rate.T]]) / cost
        M = stage_torque * (torque**2 / cost)
        try:
            P = scipy.linalg.solve_discrete_are(A, B, Q, M)
        except np.linalg.LinAlgError as error:
            raise ParameterError(
                f"weights: received weights for which the Riccati equation (27) fails ({error}); "
                "required a stabilizing solution; use a positive definite stage_attitude, and "
                "weights of similar size"
            ) from error
        P = 0.5 * (P + P.T)
        K = -np.linalg.solve(M + B.T @ P @ B, B.T @ P @ A)
        return cls(np.asarray(P * (cost / np.outer(units, units))), np.asarray(K * torque / units))

    def torque_level(self, max_torque: float) -> float:
        """Return the largest c with |K x| <= max_torque wherever x . P x <= c: exact."""
        if max_torque <= 0.0:
            return float("inf")
        spread = self.gain @ np.linalg.solve(self.riccati, self.gain.T)
        return max_torque**2 / float(np.linalg.eigvalsh(0.5 * (spread + spread.T))[-1])

    def half_turn_level(self) -> float:
        """Return the largest c with |Z| <= pi wherever x . P x <= c: exact."""
        P = self.riccati
        least = P[:3, :3] - P[:3, 3:] @ np.linalg.solve(P[3:, 3:], P[3:, :3])
        return float(np.pi**2 * np.linalg.eigvalsh(0.5 * (least + least.T))[0])


def _trace_minus(weight: Matrix3) -> Matrix3:
    """Return tr(Q) I - Q, which turns tr(Q (I - exp(hat(a)))) into a . (.) a / 2 (18)-(23)."""
    return np.asarray(np.trace(weight) * np.eye(3) - weight)
