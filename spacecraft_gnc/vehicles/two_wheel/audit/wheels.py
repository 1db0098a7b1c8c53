"""Motion of the wheels' speeds for many steps at once, independent of the plant's code.

    nu' = a - k nu - d sign(nu),   k = c / Js,   d = tau / Js,   |nu| <= N

The speed is the one on its branch, 0 once that would have changed its sign, and then, where the
motor is stronger than the bearing, the one on the other branch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.parameters.plant import PlantParameters


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Wheels (n, m) whose accelerations are held."""

    acceleration: Array
    """(n, m) that the motors give [rad/s^2]."""
    viscous: Array
    """(n, m) k [1/s]."""
    coulomb: Array
    """(n, m) d [rad/s^2]."""
    max_speed: float

    def after(self, speeds: Array, time: float) -> Array:
        """Return the speeds (n, m) after a time [s]."""
        a, k, d = self.acceleration, self.viscous, self.coulomb
        side = np.where(speeds == 0.0, np.sign(a), np.sign(speeds))
        drive = a - side * d
        free = speeds * np.exp(-k * time) + drive * _integral(k, np.full_like(k, time))
        # Time at which the branch comes to 0: exp(k t) = 1 - k nu / b.
        against = side * drive < 0.0
        ratio = np.divide(-speeds, drive, out=np.zeros_like(speeds), where=against)
        at_rest = np.divide(np.log1p(k * ratio), k, out=ratio.copy(), where=k > 0.0)
        left = np.maximum(time - at_rest, 0.0)
        turned = np.where(np.abs(a) > d, (a + side * d) * _integral(k, left), 0.0)
        found = np.where(against & (time >= at_rest), turned, free)
        found = np.where((speeds == 0.0) & (np.abs(a) <= d), 0.0, found)
        top = np.maximum(self.max_speed, np.abs(speeds))
        return np.asarray(np.clip(found, -top, top))

    def largest(self, speeds: Array) -> Array:
        """Return bounds (n, m) on the size of the accelerations from ``speeds`` on [rad/s^2]."""
        return np.abs(self.acceleration) + self.coulomb + self.viscous * np.abs(speeds)

    def jump(self, before: Array, after: Array) -> Array:
        """Return bounds (n, m) on the jumps of the accelerations between two speeds [rad/s^2]."""
        turns = (before * after <= 0.0) & (before != 0.0) & (self.coulomb > 0.0)
        stops = (np.abs(after) >= self.max_speed) & (before != after)
        size = self.largest(np.maximum(np.abs(before), np.abs(after))) + self.coulomb
        return np.where(turns | stops, size, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Wheels:
    """Limits, friction and losses of a scenario's wheels."""

    viscous: Array
    coulomb: Array
    lost_coulomb: float
    """What brakes a lost wheel beside its bearing, of all wheels [N m]."""
    axial: Array
    lost_share: float
    max_speed: float
    max_acceleration: float

    @classmethod
    def of(cls, plant: PlantParameters) -> Wheels:
        """Return those of a scenario's section ``plant``."""
        none = np.zeros(plant.wheel_inertias.size)
        viscous, coulomb = plant.wheel_viscous_friction, plant.wheel_coulomb_friction
        return cls(
            viscous if viscous.size else none,
            coulomb if coulomb.size else none,
            plant.lost_wheel_friction if plant.wheel_loss == "friction" else 0.0,
            plant.wheel_inertias,
            plant.lost_wheel_share if plant.wheel_loss == "partial" else 0.0,
            plant.max_wheel_speed or math.inf,
            plant.max_wheel_acceleration or math.inf,
        )

    def motion(self, commands: Array, healthy: NDArray[np.bool_]) -> Motion:
        """Return the motion under commands (n, m) of wheels of which some (n, m) answer."""
        wanted = np.clip(commands, -self.max_acceleration, self.max_acceleration)
        torque = self.coulomb + np.where(healthy, 0.0, self.lost_coulomb)
        return Motion(
            np.where(healthy, wanted, self.lost_share * wanted),
            np.broadcast_to(self.viscous / self.axial, wanted.shape),
            torque / self.axial,
            self.max_speed,
        )


def _integral(rate: Array, time: Array) -> Array:
    """Return the integral of exp(-k s) over s from 0 to a time, elementwise."""
    return np.divide(-np.expm1(-rate * time), rate, out=time.copy(), where=rate > 0.0)
