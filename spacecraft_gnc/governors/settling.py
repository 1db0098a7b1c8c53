"""Settled set of a loop: a neighborhood of the reference that it never leaves again.

Any controller's loop is measured there, by differences, as a linear one: x+ = A x for the deviation
x = (eta, Pi) from rest at the reference, with R = R_ref exp(hat(eta)). Where it decays, the sum of
the squared attitude errors over all steps to come is a quadratic form x^T P x,

    P = A^T P A + diag(I, 0),

which never grows. Its level sets are left by no flight, and on each the largest attitude error,
momentum and torque are known: the settled set is the largest on which the zones and the limits
have room for them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody, state_units
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors.prediction import Controller
from spacecraft_gnc.ocp.linearization import deviation
from spacecraft_gnc.types import Array, Matrix3, Reference, State, Vector3

PROBE = 1e-4  # size of the differences [rad, and momentum of that angle in one period]
LARGEST_ERROR = math.radians(1.0)  # up to here, or less where measured, the loop counts as linear
NONLINEAR = 0.1  # share of one step's decay that the loop may differ from the linear one
ROOM = 0.9  # share of a limit's room that the settled set uses


class SettledSet(NamedTuple):
    """The states x^T P x <= level around a reference."""

    metric: Array
    """(6, 6) P, to (eta [rad], Pi [N m s])."""
    level: float
    """Largest level that the limits and the linearization allow [rad^2]."""
    error_gain: float
    """Largest attitude error on level 1 [-]."""
    radius: float
    """Spectral radius of one closed-loop step [-]."""

    @property
    def horizon(self) -> int:
        """Steps in which half a turn would decay to this set at the loop's linear rate."""
        decay = math.log(math.pi / (self.error_gain * math.sqrt(self.level)))
        return math.ceil(decay / -math.log(max(self.radius, 1e-12))) + 1

    def level_at(self, zone_margin: float) -> float:
        """Level [rad^2] on which no attitude error exceeds ``zone_margin`` [rad] either."""
        room = ROOM * max(0.0, zone_margin)
        return min(self.level, (room / self.error_gain) ** 2)


class OneStep(NamedTuple):
    """One step of the closed loop around rest at a reference."""

    controller: Controller
    body: RigidBody
    substeps: int
    reference: Matrix3

    def from_deviation(self, x: Array) -> tuple[Array, Vector3]:
        """Return the deviation (6,) one step on, and the torque (3,) of that step [N m]."""
        zero = np.zeros(3)
        self.controller.reset()
        attitude, momentum = self.reference @ lie.exp(x[:3]), np.array(x[3:])
        tracked = Reference(self.reference, zero, zero)
        torque = self.controller.command(State(0, attitude, momentum), tracked).control
        following = self.body.step(attitude, momentum, torque, self.substeps)
        return deviation(*following, self.reference, zero), torque

    @property
    def units(self) -> Array:
        """Units (6,) of a deviation in which its two halves are of one size."""
        return state_units(self.body.inertia, self.substeps * self.body.time_step)

    def linearize(self) -> tuple[Array, Array]:
        """Return d x+ / d x (6, 6) and d torque / d x (3, 6), by central differences."""
        sizes = PROBE * self.units
        loop, gain = np.empty((6, 6)), np.empty((3, 6))
        for i, probe in enumerate(np.diag(sizes)):
            (ahead, more), (behind, less) = self.from_deviation(probe), self.from_deviation(-probe)
            loop[:, i] = (ahead - behind) / (2.0 * sizes[i])
            gain[:, i] = (more - less) / (2.0 * sizes[i])
        return loop, gain


def settled_set(step: OneStep, max_torque: float = 0.0, max_momentum: float = 0.0) -> SettledSet:
    """Measure a controller's loop at a reference and return its settled set there.

    Parameters
    ----------
    step : OneStep
    max_torque, max_momentum : float
        Limits that hold all over the set [N m], [N m s]; 0: none.

    Raises
    ------
    ParameterError
        If the loop does not decay at the reference, or is not linear however near it is.
    """
    units = step.units
    loop, gain = step.linearize()
    loop, gain = loop * units / units[:, None], gain * units
    radius = float(np.abs(np.linalg.eigvals(loop)).max())
    if not radius < 1.0 - 1e-9:
        raise ParameterError(
            f"controller: received a loop with spectral radius {radius:.6g} at rest at the target; "
            "required less than 1, else no reference is ever reached and nothing can be "
            "predicted; change the weights, or a target that leans on a zone"
        )
    metric = solve_discrete_lyapunov(loop.T, np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]))
    metric = 0.5 * (metric + metric.T)
    shape = np.linalg.inv(metric)
    error_gain = _largest(shape[:3, :3])
    level = (LARGEST_ERROR / error_gain) ** 2
    if max_momentum > 0.0:
        largest = units[3] * _largest(shape[3:, 3:])
        level = min(level, (ROOM * max_momentum / largest) ** 2)
    if max_torque > 0.0:
        level = min(level, (ROOM * max_torque / _largest(gain @ shape @ gain.T)) ** 2)
    level = _linear_level(step, loop, metric, level, NONLINEAR * (1.0 - radius))
    return SettledSet(metric / np.outer(units, units), level, error_gain, radius)


def _linear_level(step: OneStep, loop: Array, metric: Array, level: float, share: float) -> float:
    """Halve sizes until the loop is linear at the ends of the level set's twelve semi-axes.

    ``loop`` and ``metric`` are in the units of the step.
    """
    units = step.units
    values, vectors = np.linalg.eigh(metric)
    axes = (vectors / np.sqrt(values)).T
    for _ in range(8):
        points = math.sqrt(level) * np.concatenate([axes, -axes])
        misses = [step.from_deviation(x * units)[0] / units - loop @ x for x in points]
        if all(miss @ metric @ miss <= share**2 * level for miss in misses):
            return level
        level *= 0.25
    raise ParameterError(
        "controller: received a loop that is not smooth at rest at the target; required one that "
        "a linear loop describes within "
        f"{math.degrees(LARGEST_ERROR / 2**8):.3g} deg, to tell where it has settled; tighten its "
        "tolerances, or move the target away from the border of a zone"
    )


def _largest(matrix: Array) -> float:
    """Square root of the largest eigenvalue."""
    return math.sqrt(float(np.linalg.eigvalsh(matrix)[-1]))
