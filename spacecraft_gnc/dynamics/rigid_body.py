"""Rigid-body attitude dynamics by a Lie group variational integrator.

With R the attitude (body to inertial), Pi the angular momentum in the body frame [N m s], u the
body torque [N m], h the time step [s] and Jd = tr(J)/2 I - J:

    h hat(Pi_k) = F_k Jd - Jd F_k^T,   R_{k+1} = R_k F_k,   Pi_{k+1} = F_k^T Pi_k + h u_k.

In the quaternion (q0, q) of F_k the first equation reads 2 q0 J q + 2 q x (J q) = h Pi_k and is
solved by Newton's method without trigonometry.

Source: Gupta et al. 2015, (2)-(4); Kalabic et al. 2014, (1) and the solvability condition (3).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from spacecraft_gnc.arguments import as_count, require_positive
from spacecraft_gnc.arrays import FLOAT64, as_rows, as_shaped
from spacecraft_gnc.dynamics._lgvi_kernels import advance, propagate, solvable
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.solvability import largest_free_step
from spacecraft_gnc.types import (
    Array,
    ArrayLike,
    Matrix3,
    Vector3,
    as_inertia,
    as_rotation,
    as_vector3,
    read_only,
)


def pack_inertia(inertia: Matrix3) -> Array:
    """Return J, J^-1, Jd (row-major) and the smallest eigenvalue of Jd as one array (28,)."""
    nonstandard = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    smallest = float(np.linalg.eigvalsh(nonstandard)[0])
    parts = (inertia.ravel(), np.linalg.inv(inertia).ravel(), nonstandard.ravel(), [smallest])
    return read_only(np.concatenate(parts))


def state_units(inertia: Matrix3, period: float) -> Array:
    """Return units (6,) of (eta [rad], Pi [N m s]) that give both halves similar magnitudes.

    One radian, and the momentum that turns the body by about one radian in one period [s]. Norms,
    eigenvectors and linear systems that mix attitude and momentum use these units, so that they are
    well conditioned and do not depend on the units of mass and time.
    """
    moment = float(np.linalg.eigvalsh(inertia)[0])
    return np.repeat([1.0, moment / period], 3)


@dataclass(frozen=True, slots=True)
class RigidBody:
    """A free rigid body and its integration time step.

    Attributes
    ----------
    inertia : (3, 3) array
        Symmetric positive definite inertia matrix, body frame [kg m^2]; need not be diagonal.
    time_step : float
        Integrator step h [s].

    Raises
    ------
    ShapeError, ParameterError
        If no body with volume has this inertia, or the time step is not positive.
    """

    inertia: Matrix3
    time_step: float
    packed: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "inertia", as_inertia("inertia", self.inertia))
        object.__setattr__(self, "time_step", require_positive("time_step", self.time_step))
        object.__setattr__(self, "packed", pack_inertia(self.inertia))

    def is_solvable(self, momentum: Vector3) -> bool:
        """Tell whether ``momentum`` (3,) [N m s] satisfies the step condition, Kalabic (3).

        (h hat(Pi))^2 + 4 Jd^2 must be positive semi-definite; for a sphere this means less than a
        quarter turn per step. The step then exists; for bodies far from a sphere the condition is
        stricter than necessary.
        """
        x, y, z = as_shaped("momentum", momentum, (3,)).tolist()
        return bool(solvable(self.packed, self.time_step, (x, y, z)))

    def require_solvable(self, name: str, momentum: Vector3) -> None:
        """Raise ParameterError with the largest possible time step if no step exists."""
        if self.is_solvable(momentum):
            return
        moment = " ".join(f"{value:.6g}" for value in momentum)
        works = (1.0 - 1e-6) * self.largest_time_step(momentum)  # holds after rounding to 6 digits
        raise ParameterError(
            f"{name}: received [{moment}] N m s with time step {self.time_step:g} s; required "
            "(h hat(Pi))^2 + 4 Jd^2 >= 0 (Kalabic et al. 2014, (3)), else the body turns too far "
            f"in one step; use a time step of at most {works:.6g} s, which holds for the free "
            "motion that follows"
        )

    def largest_time_step(self, momentum: Vector3) -> float:
        """Return the largest time step [s] for free motion from ``momentum`` (3,) [N m s].

        With it every step of the free body exists while the momentum rotates in the body frame;
        `is_solvable` tests one step only. A torque that adds momentum lowers the limit:
        h |Pi| <= 2 d, with d the smallest eigenvalue of Jd, suffices for any momentum of that size.

        Source: Kalabic et al. 2014, (3), on the curve of constant momentum and energy.
        """
        return largest_free_step(self.inertia, as_vector3("momentum", momentum))

    def step(
        self, attitude: Matrix3, momentum: Vector3, torque: Vector3, n_steps: int = 1
    ) -> tuple[Matrix3, Vector3]:
        """Advance by ``n_steps`` time steps under a constant body torque.

        Parameters
        ----------
        attitude : (3, 3) array
            Rotation, body to inertial.
        momentum : (3,) array
            Angular momentum, body frame [N m s].
        torque : (3,) array
            Body torque [N m].
        n_steps : int
            Number of time steps.

        Returns
        -------
        attitude, momentum : (3, 3) and (3,) arrays
            The state after the last step.

        Raises
        ------
        ParameterError
            If a step does not exist (Kalabic (3)), or an argument is invalid.

        Notes
        -----
        Hot path: shapes, types and the existence of a step are checked, but not that the attitude
        is a rotation; `simulate` checks that too. One Newton-Schulz step keeps R^T R = I to
        rounding.
        """
        try:
            plain = attitude.shape == (3, 3) and momentum.shape == torque.shape == (3,)
            plain = plain and attitude.dtype is momentum.dtype is torque.dtype is FLOAT64
        except AttributeError:  # a list, for example
            plain = False
        if not plain or type(n_steps) is not int or n_steps < 1:
            attitude, n_steps = (
                as_shaped("attitude", attitude, (3, 3)),
                as_count("n_steps", n_steps),
            )
            momentum, torque = as_vector3("momentum", momentum), as_vector3("torque", torque)
        state = np.empty((5, 3))  # one array type: one compiled kernel for all callers
        state[:3], state[3], state[4] = attitude, momentum, torque
        if advance(self.packed, self.time_step, state, n_steps) != n_steps:
            self.require_solvable("momentum", np.asarray(momentum))
            self._fail_inside(attitude, momentum, torque, n_steps)
        return state[:3], state[3]

    def simulate(
        self,
        attitude: ArrayLike,
        momentum: ArrayLike,
        torques: ArrayLike,
        n_steps: int | None = None,
    ) -> tuple[Array, Array]:
        """Integrate a torque history.

        Parameters
        ----------
        attitude : (3, 3) array
            Initial rotation, body to inertial.
        momentum : (3,) array
            Initial angular momentum, body frame [N m s].
        torques : (n, 3) or (3,) array
            Body torque of each step, or one torque held throughout [N m].
        n_steps : int, optional
            Number of steps; required if one torque is held, otherwise n.

        Returns
        -------
        attitudes, momenta : (n+1, 3, 3) and (n+1, 3) arrays
            States including the initial one.

        Raises
        ------
        ShapeError, ParameterError
            If an argument is invalid, or a step does not exist (Kalabic (3)).
        """
        u = as_rows("torques", torques, 3)
        n = len(u) if n_steps is None else as_count("n_steps", n_steps)
        attitudes = np.empty((n + 1, 3, 3))
        momenta = np.empty((n + 1, 3))
        attitudes[0] = as_rotation("attitude", attitude)
        momenta[0] = as_vector3("momentum", momentum)
        if len(u) not in (1, n) or not np.isfinite(u).all():
            raise ParameterError(
                f"torques: received an array of shape {u.shape}; required ({n}, 3) or (3,) finite "
                "numbers [N m]; give one torque for each step"
            )
        done = propagate(self.packed, self.time_step, attitudes, momenta, u, n)
        if done != n:
            self.require_solvable(f"momentum at step {done}", momenta[done])
            self._fail_inside(attitudes[done], momenta[done], u[0], 1)
        return attitudes, momenta

    def kinetic_energy(self, momentum: Vector3) -> float:
        """Return Pi . J^-1 Pi / 2 [J] of ``momentum`` (3,), body frame."""
        rate = self.angular_velocity(momentum)
        return 0.5 * float(np.dot(momentum, rate))

    def angular_velocity(self, momentum: Vector3) -> Vector3:
        """Return the body rate J^-1 Pi (3,) [rad/s] of ``momentum`` (3,), body frame."""
        return np.asarray(self.packed[9:18].reshape(3, 3) @ as_shaped("momentum", momentum, (3,)))

    def _fail_inside(
        self, attitude: Matrix3, momentum: Vector3, torque: Vector3, n_steps: int
    ) -> None:
        raise ParameterError(
            f"momentum: no step of {self.time_step:g} s exists within {n_steps} step(s) from "
            f"{np.asarray(momentum).tolist()} N m s under torque {np.asarray(torque).tolist()} "
            "N m; required (h hat(Pi))^2 + 4 Jd^2 >= 0 (Kalabic et al. 2014, (3)); use a smaller "
            "time step"
        )
