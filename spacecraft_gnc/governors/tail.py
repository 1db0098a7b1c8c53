"""Length of a prediction: the tail set of the nominal loop and the steps to reach it.

Linearized at rest at the reference, with x = (log E, Pi), one control period of the loop is
x+ = M x. The tail set is {x . P x <= c} with M^T P M - r P = -r Q, where r is the spectral radius
of M and Q the energy: each period of the linear loop shrinks x . P x by r at least. The level c is
the largest at which

- torque, momentum, condition (4) and the invariant set are kept everywhere in it: by bounds,
- the true, nonlinear loop shrinks x . P x, by (1 + r)/2 at least: by `SAMPLES` samples on `SHELLS`
  shells.

Once a prediction is in the tail set it stays there, so that nothing beyond that step can violate.

The bounds: with e = sin(t) S n - (1 - cos(t)) n x S n for the angle t, axis n and S = tr(A) I - A,
|e - S eta| <= t^2 |S n| / 2, hence |T| <= |S eta + K Pi| + t^2 |S| / 2; W <= (eta . S eta +
Pi . J^-1 Pi) / 2; and no axis turns by more than t.

Source: Kalabic et al. 2014, section III: the T^* whose existence they assume.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_lyapunov, sqrtm

from spacecraft_gnc.dynamics import state_units
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors import _tail_kernels as kernels
from spacecraft_gnc.governors.feedback import AttitudeFeedback
from spacecraft_gnc.types import Array, read_only

SAMPLES: Final = 16_384
"""Samples of the tail set. If they were random, none failing would mean with 99.9 % confidence
that less than 0.05 % of the set (by the measure sampled) fails: 1 - 0.001^(1/SAMPLES)."""
SHELLS: Final = 16
"""Values of x . P x / c at which they lie, in equal steps of the square root."""
FLIGHTS: Final = 1_024
"""Samples of the border of {W <= level} that are flown into the tail set."""
MOST_STEPS: Final = 100_000
_KEPT: Final = 0.999  # share of each limit that the tail set uses: room for rounding
_WIDEST: Final = 1.0  # [rad] in which the logarithm is far from its branch


@dataclass(frozen=True, slots=True)
class Loop:
    """The nominal loop in discrete time."""

    feedback: AttitudeFeedback
    time_step: float
    """h, step of the integrator [s]."""
    substeps: int
    """Steps in one control period, over which the torque is held."""

    @property
    def arguments(self) -> tuple[Array, float, int, Array]:
        """First arguments of the kernels."""
        return self.feedback.body, self.time_step, self.substeps, self.feedback.law

    @property
    def units(self) -> Array:
        """Units (6,) of x in which its two halves are of one size."""
        return state_units(np.asarray(self.feedback.inertia), self.substeps * self.time_step)

    def matrix(self) -> Array:
        """Return M (6, 6) of the loop linearized at rest at the reference."""
        h, f = self.time_step, self.feedback
        inverse = np.linalg.inv(np.asarray(f.inertia))
        step = np.block([[np.eye(3), h * inverse], [np.zeros((3, 3)), np.eye(3)]])
        push = np.vstack([np.zeros((3, 3)), h * np.eye(3)])
        gain = -np.hstack([f.stiffness, np.asarray(f.momentum_gain)])
        free, forced = np.eye(6), np.zeros((6, 3))
        for _ in range(self.substeps):
            free, forced = step @ free, step @ forced + push
        return np.asarray(free + forced @ gain)


class Limits(NamedTuple):
    """What the loop must keep to; infinity where there is no limit."""

    torque: float
    """[N m]"""
    momentum: float
    """[N m s]"""
    level: float
    """Level of W [J]."""
    turn: float
    """Momentum up to which condition (4) holds in every direction [N m s]."""


@dataclass(frozen=True, slots=True)
class Tail:
    """The tail set {x . P x <= level} of one loop.

    Attributes
    ----------
    form : (6, 6) array
        P.
    level : float
        c.
    widest : float
        Largest angle of log E where x . P x = 1 [rad].
    radius : float
        Spectral radius of the linearized loop.
    growth : float
        Largest ratio of x . P x over one period that was met in the set.
    """

    form: Array
    level: float
    widest: float
    radius: float
    growth: float

    def level_within(self, angle: float) -> float:
        """Level of the largest subset in which the angle of E is at most ``angle`` [rad]."""
        return min(self.level, (angle / self.widest) ** 2)

    def packed(self) -> Array:
        """Return the array (7, 6) of the kernels."""
        rows = np.zeros((7, 6))
        rows[:6], rows[6, :2] = self.form, (self.level, self.widest)
        return read_only(rows)


def tail_of(loop: Loop, limits: Limits) -> Tail:
    """Return the largest tail set that the bounds and the samples allow.

    Raises
    ------
    ParameterError
        If the loop is not stable at its sampling.
    """
    units = loop.units
    matrix = loop.matrix() * units / units[:, None]
    radius = float(np.abs(np.linalg.eigvals(matrix)).max())
    if not radius < 1.0:
        raise ParameterError(
            f"feedback gains: received gains for which the sampled loop has spectral radius "
            f"{radius:.6g}; required less than 1; lower the gains, or the control period"
        )
    both = np.outer(units, units)
    form = solve_discrete_lyapunov(matrix.T / math.sqrt(radius), _energy(loop.feedback) * both)
    form = 0.5 * (form + form.T)
    # x = root y with |y| = 1 where x . P x = 1
    root = units[:, None] * np.real(sqrtm(np.linalg.inv(form)))
    form = form / both
    level = _bounded_level(loop.feedback, limits, root)
    points = root @ ball(SAMPLES, 6, SHELLS).T
    widest = float(np.linalg.norm(root[:3], 2))
    for _ in range(200):
        samples = np.ascontiguousarray((math.sqrt(level) * points).T)
        tail = Tail(form, level, widest, radius, 0.0)
        growth = float(kernels.worst_growth(*loop.arguments, tail.packed(), samples))
        if growth < 0.5 * (1.0 + radius):
            return Tail(form, level, widest, radius, growth)
        level *= 0.8
    raise ParameterError(
        "feedback gains: received gains for which no set around the reference is seen to shrink; "
        "required a loop that converges; lower the gains, or the control period"
    )


def horizon_of(loop: Loop, limits: Limits, tail: Tail, level: float) -> int:
    """Return a number of steps in which every start in {W <= limits.level} is in the tail set.

    Parameters
    ----------
    loop, limits, tail : Loop, Limits, Tail
    level : float
        The smallest level of the tail set that a reference needs, at most ``tail.level``.

    Notes
    -----
    x . P x is at most U in {W <= level} and the linearized loop shrinks it by the square of its
    spectral radius r, so log(c / U) / (2 log r) steps are due. Far from the reference the loop is
    slower; `FLIGHTS` flights from the border of {W <= level} are flown, and where one needs longer,
    the number is raised to that and a tenth.

    Raises
    ------
    ParameterError
        If a flight does not arrive.
    """
    f = loop.feedback
    stiffness = np.linalg.eigvalsh(f.stiffness)
    angle = math.acos(max(-1.0, 1.0 - limits.level / float(stiffness[0])))
    root_inertia = np.real(sqrtm(np.asarray(f.inertia)))
    fast = math.sqrt(2.0 * limits.level) * float(
        math.sqrt(np.linalg.norm(root_inertia @ tail.form[3:, 3:] @ root_inertia, 2))
    )
    turned = angle * math.sqrt(float(np.linalg.norm(tail.form[:3, :3], 2)))
    decay = 2.0 * math.log(tail.radius) if tail.radius > 0.0 else -math.inf
    due = math.ceil(math.log(level / (turned + fast) ** 2) / decay)
    starts = border(f, limits.level, FLIGHTS)
    flown = int(kernels.longest_arrival(*loop.arguments, tail.packed(), level, starts, MOST_STEPS))
    if flown < 0:
        raise ParameterError(
            f"lyapunov_level: received {limits.level:g} J, in which a flight does not settle in "
            f"{MOST_STEPS} steps, with limits that are sure to hold within "
            f"{math.degrees(tail.widest * math.sqrt(level)):.2g} deg; required a level, and a "
            "torque limit of the controller, at which the loop converges; lower lyapunov_level, "
            "set nmpc_controller.max_torque: 0.0, or raise max_torque and max_momentum"
        )
    return max(1, due, flown + 1 + flown // 10)


def border(feedback: AttitudeFeedback, level: float, n: int) -> Array:
    """Return ``n`` states x (n, 6) with W = ``level`` [J], spread over axes and shares of W."""
    numbers = kronecker(n, 7)
    axes, spins = _directions(numbers[:, :3]), _directions(numbers[:, 3:6])
    stiffness = np.einsum("ni,ij,nj->n", axes, feedback.stiffness, axes)
    share = numbers[:, 6] * level
    cosine = np.maximum(-1.0, 1.0 - share / stiffness)
    kinetic = level - (1.0 - cosine) * stiffness
    root = np.real(sqrtm(np.asarray(feedback.inertia)))
    eta = np.arccos(cosine)[:, None] * axes
    momenta = np.sqrt(2.0 * np.maximum(0.0, kinetic))[:, None] * (spins @ root)
    return np.ascontiguousarray(np.hstack([eta, momenta]))


def ball(n: int, d: int, shells: int) -> Array:
    """Return ``n`` points (n, d) of the unit ball, spread over ``shells`` spheres."""
    radii = (1.0 + np.arange(n) % shells) / shells
    return np.asarray(radii[:, None] * _directions(kronecker(n, d)))


def kronecker(n: int, d: int) -> Array:
    """Return ``n`` points (n, d) of (0, 1)^d that fill it evenly: the fractions of k / g^j.

    g is the root of g^(d+1) = g + 1, the golden ratio for d = 1 (Roberts' R-sequence).
    """
    g = 2.0
    for _ in range(60):
        g = (1.0 + g) ** (1.0 / (d + 1))
    steps = g ** -np.arange(1.0, d + 1.0)
    return np.asarray((0.5 + np.outer(np.arange(1, n + 1), steps)) % 1.0)


def _directions(numbers: Array) -> Array:
    """Turn points (n, d) of (0, 1)^d into unit vectors, by the inverse normal distribution."""
    from scipy.special import ndtri

    normal = ndtri(np.clip(numbers, 1e-12, 1.0 - 1e-12))
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def _energy(feedback: AttitudeFeedback) -> Array:
    """Return the matrix (6, 6) of W for small x, twice."""
    zero = np.zeros((3, 3))
    inverse = np.linalg.inv(np.asarray(feedback.inertia))
    return np.block([[feedback.stiffness, zero], [zero, inverse]])


def _bounded_level(feedback: AttitudeFeedback, limits: Limits, root: Array) -> float:
    """Return the largest level c at which the bounds of the module's docstring hold."""
    gain = np.hstack([feedback.stiffness, np.asarray(feedback.momentum_gain)])
    linear = float(np.linalg.norm(gain @ root, 2))
    angle = float(np.linalg.norm(root[:3], 2))
    momentum = float(np.linalg.norm(root[3:], 2))
    energy = 0.5 * float(np.linalg.norm(root.T @ _energy(feedback) @ root, 2))
    bend = 0.5 * angle**2 * float(np.linalg.norm(feedback.stiffness, 2))
    torque = _KEPT * min(limits.torque, float(feedback.law[18]))
    # linear r + bend r^2 <= torque for r = sqrt(c), solved without cancellation
    r = (
        math.inf
        if math.isinf(torque)
        else (2.0 * torque / (linear + math.sqrt(linear**2 + 4.0 * bend * torque)))
    )
    r = min(r, _KEPT * min(limits.momentum, limits.turn) / momentum, _WIDEST / angle)
    return min(r**2, _KEPT * limits.level / energy)
