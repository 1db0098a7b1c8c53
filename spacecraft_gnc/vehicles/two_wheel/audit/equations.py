"""Equations of motion for many steps at once, independent of the plant's code.

    R' = R hat(omega),   omega = J^-1 (R^T H - sum of a_i Js_i nu_i),
    nu_i' = u_i - (c_i nu_i + tau_i sign nu_i) / Js_i

with the wheels one by one from the scenario, u_i within the limits and by the health (`wheels`),
and the classical Runge-Kutta method of fourth order at a quarter of the plant's step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.audit.wheels import Wheels
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

ROUNDING: Final = 64.0 * 2.0**-53
"""Share of the largest magnitude that sums of a few products may be off."""
_FINER: Final = 4  # Runge-Kutta steps in one of the plant
_FLOOR: Final = 1e-12  # of an attitude, whatever the step
_KINK: Final = 0.5
"""Error of the mean speed over a step in which the acceleration of a wheel jumps, over the jump
times the step: below 0.08 for the trapezoids of the plant's stages, which pass it three times."""
_ERROR: Final = 1e-3
"""Error of an integrator step over the fifth power of its turn; some 1e-6 for the plant's method,
3e-5 for this one."""


@dataclass(frozen=True, slots=True, eq=False)
class Equations:
    """Bus and wheels of a scenario."""

    inertia: Array
    axes: tuple[Array, ...]
    """Unit vectors (3,)."""
    axial: tuple[float, ...]
    step_length: float
    """Of the plant's integrator [s]."""
    substeps: int
    wheels: Wheels

    @classmethod
    def of(cls, scenario: Scenario) -> Equations:
        """Return those of a scenario."""
        p = scenario.plant
        columns = [np.array(column) for column in p.wheel_axes.T]
        return cls(
            np.array(p.inertia),
            tuple(column / math.sqrt(float(column @ column)) for column in columns),
            tuple(p.wheel_inertias.tolist()),
            p.time_step,
            scenario.substeps,
            Wheels.of(p),
        )

    def momentum_defect(self, states: Sequence[WheelState]) -> tuple[Array, float]:
        """Return R (J omega + sum of a_i Js_i nu_i) - H (n, 3) of states, and its rounding."""
        attitudes, rates, speeds, total, _ = _stacked(states)
        stored = self._stored(speeds)
        body = rates @ self.inertia.T
        off = np.einsum("nij,nj->ni", attitudes, body + stored) - total
        sizes = (np.abs(part).max(initial=1e-300) for part in (body, stored, total))
        condition = float(np.linalg.cond(self.inertia))
        return off, ROUNDING * condition * max(sizes)

    def speed_rounding(self, speeds: Array) -> float:
        """Return how far sums of a control step may be from speeds (n, m) [rad/s]."""
        return ROUNDING * self.substeps * float(np.abs(speeds).max(initial=1e-300))

    def step(self, states: Sequence[WheelState], commands: Array) -> tuple[Array, Array, Array]:
        """Make one control step of each state under commanded accelerations (n, m).

        Returns
        -------
        attitudes, speeds, limits : (n, 3, 3), (n, m), (n,) arrays
            After the step, and what the plant's attitude may be off, by the order of its method.
        """
        attitudes, rates, speeds, total, healthy = _stacked(states)
        motion = self.wheels.motion(commands, healthy)
        most = motion.largest(speeds)
        fastest = np.linalg.norm(rates, axis=1)
        fastest += self._rate_scale(speeds, self.step_length * most, total)
        fastest += np.sqrt(self._rate_scale(np.zeros_like(most), most, 0.0 * total))
        limits = _ERROR * self.substeps * (self.step_length * fastest) ** 5 + _FLOOR
        h = self.step_length / _FINER
        for _ in range(self.substeps):
            nodes = [motion.after(speeds, 0.5 * i * h) for i in range(2 * _FINER + 1)]
            for i in range(_FINER):
                attitudes = self._advanced(attitudes, total, nodes[2 * i : 2 * i + 3], h)
            limits += self._kinks(motion.jump(speeds, nodes[-1]))
            speeds = nodes[-1]
        return attitudes, speeds, limits

    def _kinks(self, jumps: Array) -> Array:
        """Return the angle (n,) that jumps (n, m) of the wheels' accelerations in a step cost."""
        least = float(np.linalg.eigvalsh(self.inertia)[0])
        return np.asarray(_KINK * self.step_length**2 * (jumps @ np.array(self.axial)) / least)

    def _advanced(self, attitudes: Array, total: Array, nu: list[Array], h: float) -> Array:
        """Return attitudes (n, 3, 3) after one Runge-Kutta step.

        ``nu`` are the wheel speeds (n, m) at its start, middle and end.
        """
        k_1 = self._derivative(attitudes, total, nu[0])
        k_2 = self._derivative(attitudes + 0.5 * h * k_1, total, nu[1])
        k_3 = self._derivative(attitudes + 0.5 * h * k_2, total, nu[1])
        k_4 = self._derivative(attitudes + h * k_3, total, nu[2])
        return np.asarray(attitudes + h / 6.0 * (k_1 + 2.0 * k_2 + 2.0 * k_3 + k_4))

    def _derivative(self, attitudes: Array, total: Array, speeds: Array) -> Array:
        """Return R hat(omega) (n, 3, 3)."""
        body = np.einsum("nji,nj->ni", attitudes, total) - self._stored(speeds)
        rate = np.linalg.solve(self.inertia, body.T).T
        rows = np.broadcast_to(rate[:, None, :], attitudes.shape)
        return np.asarray(np.cross(attitudes, rows))  # v^T hat(omega) = (v x omega)^T

    def _stored(self, speeds: Array) -> Array:
        """Return the momentum of the wheels (n, 3) relative to the bus, body frame [N m s]."""
        parts = [
            inertia * speeds[:, i, None] * axis
            for i, (axis, inertia) in enumerate(zip(self.axes, self.axial, strict=True))
        ]
        return np.asarray(sum(parts))

    def _rate_scale(self, speeds: Array, change: Array, total: Array) -> Array:
        """Return the rate (n,) [rad/s] that all momentum there is could give to the bus."""
        least = float(np.linalg.eigvalsh(self.inertia)[0])
        stored = (np.abs(speeds) + self.substeps * np.abs(change)) @ np.array(self.axial)
        return np.asarray((np.linalg.norm(total, axis=1) + stored) / least)


def _stacked(
    states: Sequence[WheelState],
) -> tuple[Array, Array, Array, Array, NDArray[np.bool_]]:
    """Return attitudes, rates, wheel speeds, total momenta and health of states."""
    _, attitudes, rates, speeds, total, healthy, _ = zip(*states, strict=True)
    return tuple(map(np.array, (attitudes, rates, speeds, total, healthy)))  # type: ignore[return-value]
