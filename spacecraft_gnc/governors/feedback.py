"""Nominal controller: almost globally stabilizing feedback on SO(3), and its Lyapunov function.

    E = V^T C,   hat(e) = A E - E^T A,   T = -K Pi - e,   W = Pi . J^-1 Pi / 2 + tr(A (I - E))

C is the attitude, V the reference, Pi the momentum. In continuous time dW/dt = -Omega . K J Omega
for the body rate Omega, so E = I is approached from all but a set of measure zero; at the other
equilibria E is half a turn about an eigenvector of A.

A reference that turns at omega with the torque tau, both in its own frame, is tracked by

    T = E^T tau - K (Pi - J E^T omega) - e

where the body is continuous; the integrator's momentum and torque of such a turn differ a little
(docs/solver.md, "A moving reference").

Source: Kalabic et al. 2014, (8)-(10), which print one letter for the matrix E and the vector e.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from spacecraft_gnc.arguments import as_limit, require_positive
from spacecraft_gnc.arrays import as_shaped
from spacecraft_gnc.dynamics.rigid_body import pack_inertia
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors import _feedback_kernels as kernels
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Matrix3,
    Reference,
    State,
    Vector3,
    as_inertia,
    as_matrix3,
    as_semidefinite,
    read_only,
)

# Bandwidth of the fallback's gains in units of 1/period: slow enough for a sampled body.
BANDWIDTH = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeFeedback:
    """T = -K Pi - e, or that of a moving reference, scaled down to the torque limit.

    Attributes
    ----------
    attitude_gain : (3, 3) array
        A, symmetric positive definite, body frame [N m].
    momentum_gain : (3, 3) array
        K, with positive definite symmetric part, body frame [1/s].
    inertia : (3, 3) array
        Body frame [kg m^2].
    max_torque : float
        Limit on the norm of T [N m]; 0 means none. Where it acts, W may grow.
    plant_step : float
        Step [s] of the integrator whose momentum is measured; 0 for a continuous body. Read for
        moving references only.

    Raises
    ------
    ShapeError, ParameterError
        If a gain is not positive definite, or the inertia none of a body with volume.
    """

    attitude_gain: ArrayLike
    momentum_gain: ArrayLike
    inertia: ArrayLike
    max_torque: float = 0.0
    plant_step: float = 0.0
    law: Array = field(init=False, repr=False)
    body: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        attitude = as_semidefinite("attitude_gain", self.attitude_gain)
        momentum = as_matrix3("momentum_gain", self.momentum_gain)
        for name, gain in (("attitude_gain", attitude), ("momentum_gain", momentum)):
            smallest = float(np.linalg.eigvalsh(0.5 * (gain + gain.T))[0])
            if smallest <= 0.0:
                raise ParameterError(
                    f"{name}: received a matrix with eigenvalue {smallest:g}; required a positive "
                    "definite gain, else the loop is not stable; use for example 0.2"
                )
        max_torque = as_limit("max_torque", self.max_torque)
        inertia = as_inertia("inertia", self.inertia)
        limit = max_torque if max_torque > 0.0 else math.inf
        law = read_only(np.concatenate([attitude.ravel(), momentum.ravel(), [limit]]))
        for name, value in (
            ("attitude_gain", attitude), ("momentum_gain", momentum), ("inertia", inertia),
            ("max_torque", max_torque), ("law", law), ("body", pack_inertia(inertia)),
            ("plant_step", as_limit("plant_step", self.plant_step)),
        ):  # fmt: skip
            object.__setattr__(self, name, value)

    @classmethod
    def critically_damped(
        cls, inertia: Matrix3, period: float, max_torque: float = 0.0, plant_step: float = 0.0
    ) -> AttitudeFeedback:
        """Return the law with A = J omega^2 / 2, K = 2 omega I and omega = `BANDWIDTH` / period."""
        bandwidth = BANDWIDTH / require_positive("period", period)
        gain = 0.5 * bandwidth**2 * as_inertia("inertia", inertia)
        return cls(gain, 2.0 * bandwidth, inertia, max_torque, plant_step)

    @property
    def stiffness(self) -> Matrix3:
        """tr(A) I - A (3, 3) [N m]: e = stiffness eta for a small rotation vector eta of E."""
        gain = np.asarray(self.attitude_gain)
        return np.asarray(np.trace(gain) * np.eye(3) - gain)

    @property
    def unstable_level(self) -> float:
        """W [J] of the lowest unstable equilibrium: twice the two smallest eigenvalues of A.

        At half a turn about the eigenvector of a_i, W = 2 (tr(A) - a_i).
        """
        eigenvalues = np.linalg.eigvalsh(np.asarray(self.attitude_gain))
        return 2.0 * float(eigenvalues[0] + eigenvalues[1])

    def torque(self, state: State, reference: Matrix3 | Reference) -> Vector3:
        """Return the body torque (3,) [N m] at ``state`` toward a (3, 3) attitude or Reference."""
        torque, rows = np.empty((1, 3)), np.zeros((9, 3))
        if isinstance(reference, Reference):
            reference, rate, feedforward = reference
            rows[7] = as_shaped("reference.angular_velocity", rate, (3,))
            rows[8] = as_shaped("reference.torque", feedforward, (3,))
        rows[:7] = _packed(state, reference)
        kernels.command(self.law, self.body, self.plant_step, rows, torque)
        return np.asarray(torque[0])

    def lyapunov(self, state: State, reference: Matrix3) -> float:
        """Return W [J] at ``state`` for ``reference`` (3, 3); 0 at rest at the reference.

        Notes
        -----
        W falls along the continuous motion. Under a torque that is held for a time h it does not
        always: from rest it first grows, by h^2 e . J^-1 e / 2 in one step of the integrator.
        """
        return float(kernels.level_at(self.law, self.body, _packed(state, reference)))


def _packed(state: State, reference: Matrix3) -> Array:
    rows = np.empty((7, 3))
    rows[:3] = as_shaped("state.attitude", state.attitude, (3, 3))
    rows[3] = as_shaped("state.momentum", state.momentum, (3,))
    rows[4:] = as_shaped("reference", reference, (3, 3))
    return rows
