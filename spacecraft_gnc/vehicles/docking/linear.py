"""Linear periodic model of the relative motion about the docked state.

The docked state is rho = 0, rho' = 0, R_CD = 1, w = 0 on the rotating chief. With the coordinates
x = (rho, rho', delta, w), R_CD = exp(hat(delta)), and U = (F, M) held over a control period T,

    x_k+1 = A_k x_k + B_k (U_k - U0_k) + e_k,   U0_k = mean of the wrench that holds the port,

where e_k, which that mean cannot take away, is tiny. A port held at rho and delta needs U0_k +
Gamma_k (rho, delta) to first order. All are periodic where the rotation takes p control periods.
docs/docking.md derives the equations.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_count
from spacecraft_gnc.types import Array, Matrix3, Vector3, read_only
from spacecraft_gnc.vehicles.docking.chief import ChiefMotion
from spacecraft_gnc.vehicles.docking.dynamics import RelativeMotion

HELD: Final = np.zeros((12, 6))
"""E (12, 6): the state E v of a port held at the reference v = (rho, delta)."""
HELD[:3, :3] = HELD[6:9, 3:] = np.eye(3)
HELD.setflags(write=False)
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True, slots=True, eq=False)
class LinearMotion:
    """Discrete model x_k+1 = A_k x_k + B_k (U_k - U0_k) + e_k of period p; k counts modulo p.

    Attributes
    ----------
    transition, control : (p, 12, 12), (p, 12, 6) arrays
        A_k and B_k.
    feedforward : (p, 6) array
        U0_k [N], [N m], chief frame.
    reference_feedforward : (p, 6, 6) array
        Gamma_k.
    residual : (p, 12) array
        e_k: where the docked state is after one step of U0_k.
    """

    transition: Array
    control: Array
    feedforward: Array
    reference_feedforward: Array
    residual: Array

    @property
    def period(self) -> int:
        """Number of control periods p after which the model repeats."""
        return len(self.transition)

    def averaged(self) -> LinearMotion:
        """Return the time-invariant model, p = 1: each matrix averaged over the period."""
        parts = (getattr(self, name) for name in self.__slots__)
        return LinearMotion(*(read_only(part.mean(axis=0, keepdims=True)) for part in parts))

    def predict(self, step: int, coordinates: Array, wrench: Array) -> Array:
        """Return x_k+1 (12,) after a step with a wrench (6,) held."""
        k = step % self.period
        change = self.control[k] @ (wrench - self.feedforward[k])
        return np.asarray(self.transition[k] @ coordinates + change + self.residual[k])

    def wrench(self, step: int, coordinates: Array, reference: Array, gains: Array) -> Array:
        """Return U = U0_k + Gamma_k v - K_k (x - E v) (6,) with gains (p, 6, 12)."""
        k = step % self.period
        held = self.feedforward[k] + self.reference_feedforward[k] @ reference
        return np.asarray(held - gains[k] @ (coordinates - HELD @ reference))


def coordinates(
    port_offset: Vector3, port_velocity: Vector3, attitude: Matrix3, angular_velocity: Vector3
) -> Array:
    """Return x = (rho, rho', delta, w) (12,) of a state."""
    return np.concatenate([port_offset, port_velocity, lie.log(attitude), angular_velocity])


def linearize(motion: RelativeMotion, period: int) -> LinearMotion:
    """Return the linear model about the docked state.

    Parameters
    ----------
    motion : RelativeMotion
        Deputy and chief. Gravity is linear in the model in any case.
    period : int
        Number p of control periods that the rotation of the chief takes; 1 where it does not
        rotate in Hill's frame.

    Returns
    -------
    LinearMotion
        From the variational equations, integrated by the classical method of fourth order on the
        integrator steps of ``motion``.
    """
    span = motion.control_period * as_count("period", period)
    times = np.linspace(0.0, span, period, endpoint=False)
    h = motion.control_period / motion.substeps
    flow = np.zeros((period, 12, 19))  # derivatives by x and U, and the state itself
    flow[:, :, :12] = np.eye(12)
    wrench = np.zeros((period, 6, 7))  # the mean, by the rule of Gauss and Legendre
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        later = 0.5 * motion.control_period * (1.0 + float(node))
        wrench += 0.5 * float(weight) * _Docked(motion, times + later).needed()
    feedforward = wrench[:, :, 6]
    now = _Docked(motion, times)
    for i in range(motion.substeps):
        middle, end = (_Docked(motion, times + (i + d) * h) for d in (0.5, 1.0))
        k1 = now.slope(flow, feedforward)
        k2 = middle.slope(flow + 0.5 * h * k1, feedforward)
        k3 = middle.slope(flow + 0.5 * h * k2, feedforward)
        k4 = end.slope(flow + h * k3, feedforward)
        flow, now = flow + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4), end
    parts = flow[:, :, :12], flow[:, :, 12:18], feedforward, wrench[:, :, :6], flow[:, :, 18]
    return LinearMotion(*(read_only(np.ascontiguousarray(part)) for part in parts))


class _Docked:
    """Coefficients of the motion near the docked state at times (p,), stacked."""

    def __init__(self, motion: RelativeMotion, times: Array) -> None:
        R_CH, rate, change = _chief(motion.chief, times)
        n2 = motion.chief.mean_motion**2
        e = R_CH[:, :, 0]  # outward
        tide = n2 * (3.0 * e[:, :, None] * e[:, None, :] - np.eye(3))
        W, W_dot, J, p = _hats(rate), _hats(change), motion.inertia, motion.deputy.port
        rest, arm = motion.chief_body.port - p, lie.hat(p)
        self.mass, self.inverse, self.arm = motion.mass, np.linalg.inv(J), arm
        # Acceleration less that of F and w': here -2 Omega x v + pull r, at v and r of the center.
        pull = tide - W_dot - W @ W
        self.offset, self.tilt = pull, pull @ arm
        self.velocity, self.turning = -2.0 * W, -2.0 * W @ arm
        self.rest = pull @ rest
        # J w' = M + stiffness delta + damping w + torque
        h, h_dot = rate @ J, change @ J
        self.damping = _hats(h) + J @ -W - W @ J
        first = _hats(h_dot) + J @ -W_dot
        self.stiffness = first + W @ (_hats(h) - J @ W)
        self.torque = -h_dot - np.cross(rate, h)
        if motion.gravity_gradient:
            outward, g = _hats(e), e @ J
            self.stiffness = self.stiffness + 3.0 * n2 * outward @ (J @ _hats(e) - _hats(g))
            self.torque = self.torque + 3.0 * n2 * np.cross(e, g)

    def needed(self) -> Array:
        """Return the wrench that holds the port: its derivative by (rho, delta), and at zero."""
        wrench = np.zeros((len(self.rest), 6, 7))
        wrench[:, :3, :3], wrench[:, :3, 3:6] = -self.mass * self.offset, -self.mass * self.tilt
        wrench[:, :3, 6] = -self.mass * self.rest
        wrench[:, 3:, 3:6], wrench[:, 3:, 6] = -self.stiffness, -self.torque
        return wrench

    def slope(self, flow: Array, wrench: Array) -> Array:
        """Return the rate of (dx/dx0, dx/dU, x) with the wrench (p, 6) held."""
        rho, velocity, delta, w = (flow[:, i : i + 3] for i in range(0, 12, 3))
        force, moment = np.zeros((2, *rho.shape))
        force[:, :, 12:15] = moment[:, :, 15:18] = np.eye(3)
        force[:, :, 18] = wrench[:, :3] + self.mass * self.rest
        moment[:, :, 18] = wrench[:, 3:] + self.torque
        spin = self.inverse @ (moment + self.stiffness @ delta + self.damping @ w)
        drift = self.offset @ rho + self.velocity @ velocity
        drift += self.tilt @ delta + self.turning @ w
        push = force / self.mass - self.arm @ spin  # w' x p
        return np.concatenate([velocity, push + drift, w, spin], axis=1)


def _chief(chief: ChiefMotion, times: Array) -> tuple[Array, Array, Array]:
    """Return R_CH (p, 3, 3), Omega and Omega' (p, 3) at times (p,)."""
    axis, angle = lie.hat(chief.spin_axis), (chief.spin_rate * times)[:, None, None]
    turn_back = np.eye(3) - np.sin(angle) * axis + 2.0 * np.sin(0.5 * angle) ** 2 * (axis @ axis)
    R_CH = chief.initial_attitude.T @ turn_back
    normal, spin = np.array([0.0, 0.0, chief.mean_motion]), chief.spin_rate * chief.spin_axis
    return R_CH, R_CH @ (spin + normal), -R_CH @ np.cross(spin, normal)


def _hats(vectors: Array) -> Array:
    """Return `lie.hat` of vectors (p, 3)."""
    return np.cross(vectors[:, None], np.eye(3)).transpose(0, 2, 1)
