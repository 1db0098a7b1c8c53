"""Values of a scenario for the formulas of the defaults: numbers, matrices, scales."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.formulas import Missing
from spacecraft_gnc.types import Matrix3, read_only
from spacecraft_gnc.vehicles.rigid_body.chosen import own_method

_PLANT: Final = "plant"
_CONTROLLER: Final = "nmpc_controller"
SETTLING: Final = 8.0
"""omega times the settling time: (1 + 8) exp(-8) is 0.1 deg of 30 deg."""
SATURATION: Final = 4.0
"""J omega^2 over the torque limit: the law saturates beyond 0.25 rad, and its overshoot from half a
turn stays small."""
_NEGLIGIBLE: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Values:
    """The values that formulas read."""

    checked: Checked

    def number(self, section: str, name: str) -> float:
        """Return a number, as `Checked.number` does."""
        return self.checked.number(section, name)

    def numbers(self, section: str, name: str) -> list[float]:
        """Return a list of numbers, likewise."""
        return self.checked.numbers(section, name)

    def given(self, section: str, name: str) -> float:
        """Return a number that was given; 0 where none was."""
        return self.number(section, name) if name in self.checked.given.get(section, {}) else 0.0

    def is_given_and_read(self, name: str) -> bool:
        """Tell whether a parameter of the controller was given, and its method reads it."""
        method = own_method(self.checked)
        is_read = method is None or name in method.reads
        return is_read and name in self.checked.given.get(_CONTROLLER, {})

    def weight(self, name: str) -> Matrix3:
        """Return a weight as a matrix; a number s stands for s I."""
        value = self.checked.get(_CONTROLLER, f"weights.{name}")
        if value is None:
            raise Missing
        array = np.array(value, dtype=np.float64)
        return array.reshape(3, 3) if array.size == 9 else float(array) * np.eye(3)

    @property
    def inertia(self) -> Matrix3:
        """J that the controller believes; the identity where a node alone knows none."""
        own = self.numbers(_CONTROLLER, "inertia") or self.numbers(_PLANT, "inertia")
        return np.array(own or np.eye(3)).reshape(3, 3)

    @property
    def largest_moment(self) -> float:
        """J_max: what |u| = 1 accelerates the least, sqrt of the largest eigenvalue of J V J."""
        return math.sqrt(float(np.linalg.eigvalsh(self.acceleration_effort(np.eye(1)))[-1]))

    @property
    def largest_momentum(self) -> float:
        """J_1 omega + |Pi_0| [N m s] of the largest principal moment J_1: that of a fast slew."""
        largest = float(np.linalg.eigvalsh(self.inertia)[-1])
        return largest * self.bandwidth + self.momentum

    @property
    def momentum(self) -> float:
        """|Pi_0| [N m s]."""
        return math.hypot(*self.numbers(_PLANT, "initial_momentum"))

    @property
    def bandwidth(self) -> float:
        """Omega [rad/s]."""
        return SETTLING / self.number(_CONTROLLER, "settling_time")

    @property
    def period(self) -> float:
        """Control period h [s]."""
        return self.number(_CONTROLLER, "time_step") or self.number(_PLANT, "time_step")

    @property
    def limit(self) -> float:
        """Torque limit, else that which saturates where a default one would [N m]."""
        return self.number(_CONTROLLER, "max_torque") or self.torque_scale

    @property
    def torque_scale(self) -> float:
        """J_max omega^2 / 4 [N m]: max_torque, where the settling time follows from that."""
        return self.largest_moment * self.bandwidth**2 / SATURATION

    def effort(self, weight: Matrix3) -> Matrix3:
        """Return the weight W of a body torque: (B S^-1 B^T)^-1 with the weight S of the controls.

        ``weight``: S, (m, m), or (1, 1) for a multiple of the identity. A torque that no actuator
        makes weighs as much as the dearest that one does.
        """
        actuators = self.numbers(_CONTROLLER, "actuators")
        return _effort(np.array(actuators).tobytes(), weight.tobytes(), len(weight))

    def acceleration_effort(self, weight: Matrix3) -> Matrix3:
        """Return J W J, the weight of an angular acceleration."""
        inertia = self.inertia
        return np.asarray(inertia @ self.effort(weight) @ inertia)


@lru_cache(maxsize=64)
def _effort(actuators: bytes, numbers: bytes, size: int) -> Matrix3:
    """Return `Values.effort`, which seldom changes between the scenarios of one spacecraft.

    Of bytes, which tell 0.0 from -0.0.
    """
    weight = np.frombuffer(numbers).reshape(size, size)
    matrix = np.frombuffer(actuators).reshape(3, -1) if actuators else np.eye(3)
    count = matrix.shape[1]
    full = weight if len(weight) == count else float(weight[0, 0]) * np.eye(count)
    axes, gains, _ = np.linalg.svd(np.linalg.solve(np.linalg.cholesky(full), matrix.T).T)
    gains = np.append(gains, np.zeros(3 - len(gains)))
    if not gains[0] > 0.0:
        raise Missing  # actuators that the checks refuse
    gains[gains <= _NEGLIGIBLE * gains[0]] = gains[gains > _NEGLIGIBLE * gains[0]].min()
    return read_only((axes / gains**2) @ axes.T)
