"""Diagnosis of a lost thruster direction from the change of velocity over one control step.

The center of mass moves by A_k and B_k of the linear model, which holds for it exactly but for the
small part of gravity that is not linear. What it misses of the velocity foretold is the impulse
that did not come. A direction i of the deputy frame is concluded lost where that is more than the
threshold and is what the loss of i explains.

Threshold: `_MODEL` for what the model leaves out, and `_DEVIATIONS` standard deviations of the
noise of two measurements. A false alarm in a component is then once in some 10^9 steps of noise.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.arguments import as_limit
from spacecraft_gnc.types import Array, Vector3
from spacecraft_gnc.vehicles.docking.linear import LinearMotion
from spacecraft_gnc.vehicles.docking.state import Navigation, RelativeState

_MODEL: Final = 1e-6  # [m/s] in a step: some 40 times the largest miss measured without noise
_DEVIATIONS: Final = 6.5
_EXPLAINED: Final = 0.3  # of the miss that may be left when a loss explains it
AXES: Final = np.vstack([np.eye(3), -np.eye(3)])
"""(6, 3) of `state.DIRECTIONS`, deputy frame."""


class Noise(NamedTuple):
    """Standard deviations of what navigation tells, each component."""

    position: float = 0.0
    """[m]"""
    velocity: float = 0.0
    """[m/s]"""
    attitude: float = 0.0
    """[rad]"""
    rate: float = 0.0
    """[rad/s]"""


class _Seen(NamedTuple):
    step: int
    center: Array
    """(6,) offset and velocity of the center of mass from where it is docked."""
    motion: Navigation


class ThrusterMonitor:
    """Compares the response to each wrench with the one foretold.

    Parameters
    ----------
    model : LinearMotion
        As believed.
    port : (3,) array
        Docking port of the deputy, deputy frame [m].
    limit : float
        Largest component of the force that the thrusters give, chief frame [N].
    period : float
        Control period [s].
    noise : Noise
    """

    def __init__(
        self, model: LinearMotion, port: Vector3, limit: float, period: float, noise: Noise
    ) -> None:
        self._model, self._port = model, port
        self._limit = as_limit("limit", limit)
        self._period = period
        self.threshold = _MODEL + _DEVIATIONS * self._deviation(noise)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen and concluded."""
        self._before: _Seen | None = None
        self._lost = -1
        self._error = math.nan

    def memory(self) -> tuple[Any, ...]:
        """Return what was seen last, and what was concluded."""
        return self._before, self._lost, self._error

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on as the monitor did whose `memory` it is."""
        before, self._lost, self._error = memory
        if before is not None:
            step, center, motion = before
            self._before = _Seen(step, center, Navigation(*motion))

    def look(self, state: RelativeState) -> tuple[int, float]:
        """Return the direction concluded lost, -1: none, and the miss over the last step [m/s]."""
        motion = state.measured
        now = _Seen(state.step, center_of(motion, self._port), motion)
        before = self._before
        if before is None or now.step != before.step:  # a state told again changes nothing
            self._error = math.nan
            if before is not None and now.step == before.step + 1:
                self._compare(before, now, state.applied)
            self._before = now
        return self._lost, self._error

    def _compare(self, before: _Seen, now: _Seen, wrench: Array) -> None:
        k = before.step % self._model.period
        force = np.clip(wrench[:3], -self._limit, self._limit)
        push = self._model.control[k][:6, :3]
        foretold = self._model.transition[k][:6, :6] @ before.center
        foretold += push @ (force - self._model.feedforward[k, :3])
        miss = (now.center - foretold)[3:]
        self._error = float(np.abs(miss).max())
        if self._lost < 0 and self._error > self.threshold:
            self._lost = self._explain(miss, force, push[3:], before, now)

    def _explain(
        self, miss: Vector3, force: Vector3, push: Array, before: _Seen, now: _Seen
    ) -> int:
        """Return the direction whose loss leaves the least of the miss, -1: too much is left."""
        middle = lie.exp(0.5 * lie.log(now.motion.attitude @ before.motion.attitude.T))
        axes = AXES @ (middle @ before.motion.attitude).T  # chief frame
        left = [miss + push @ (max(0.0, axis @ force) * axis) for axis in axes]
        sizes = np.linalg.norm(left, axis=1)
        best = int(sizes.argmin())
        most = self.threshold + _EXPLAINED * float(np.linalg.norm(miss))
        return best if sizes[best] <= most else -1

    def _deviation(self, noise: Noise) -> float:
        """Return the standard deviation of a component of the miss by the noise."""
        arm = float(np.linalg.norm(self._port))
        step = np.abs(self._model.transition[:, 3:6, :3]).max()
        velocity = math.hypot(noise.velocity, arm * noise.rate)
        position = math.hypot(noise.position, arm * noise.attitude)
        return math.hypot(math.sqrt(2.0) * velocity, step * position)


def center_of(motion: Navigation, port: Vector3) -> Array:
    """Return offset and velocity (6,) of the deputy's center of mass from where it is docked.

    The port offset less (R - 1) port, and its rate; chief frame [m], [m/s].
    """
    turned = motion.attitude @ port
    offset = motion.port_offset - turned + port
    return np.concatenate(
        [offset, motion.port_velocity - np.cross(motion.angular_velocity, turned)]
    )
