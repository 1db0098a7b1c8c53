"""Control method ``pd``: proportional to the rotation vector of the error, and to its rate."""

from __future__ import annotations

from typing import Any

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.loop import Command, Reference, State
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.vehicle import MethodTraits


class PdController:
    """Torque u = -J (w^2 eta + 2 z w (omega - omega_ref)), cut off at the torque limit.

    eta is the rotation vector of R_ref' R. Near the target every axis is an oscillator of frequency
    w and damping ratio z.

    Parameters
    ----------
    inertia : (3, 3) array
        Of the spacecraft, body frame [kg m^2].
    period : float
        Control period [s].
    bandwidth : float
        w [rad/s].
    damping : float
        z [-].
    max_torque : float
        Largest norm of the torque [N m]; 0: no limit.
    """

    name = "pd"
    slow = False
    traits = MethodTraits(memoryless=True)

    def __init__(
        self, inertia: Matrix3, period: float, bandwidth: float, damping: float, max_torque: float
    ) -> None:
        self.period = period
        self._inertia, self._inverse = inertia, np.linalg.inv(inertia)
        self._stiffness, self._damping = bandwidth**2, 2.0 * damping * bandwidth
        self._limit = max_torque

    @classmethod
    def from_scenario(cls, scenario: Any) -> PdController:
        """Build the controller from ``plugin.bandwidth`` and ``plugin.damping``."""
        section = scenario.controller
        values = {"bandwidth": 0.1, "damping": 0.8, **section.plugin}
        for name in ("bandwidth", "damping"):
            if not isinstance(values[name], float) or not values[name] > 0.0:
                raise ParameterError(
                    f"plugin.{name}: received {values[name]!r}; required a number > 0; give 0.1"
                )
        return cls(
            section.inertia,
            scenario.period,
            values["bandwidth"],
            values["damping"],
            section.max_torque,
        )

    def warm_up(self) -> None:
        """Compile or load the kernels of `lie`."""
        lie.log(np.eye(3))

    def reset(self) -> None:
        """Do nothing: the law has no memory."""

    def command(self, state: State, reference: Reference) -> Command:
        """Return the torque for the control step that starts at ``state``."""
        error = lie.log(reference.attitude.T @ state.attitude)
        rate = self._inverse @ state.momentum - reference.angular_velocity
        torque = -self._inertia @ (self._stiffness * error + self._damping * rate)
        return Command(self._limited(torque + reference.torque))

    def _limited(self, torque: Array) -> Array:
        size = float(np.linalg.norm(torque))
        return torque * (self._limit / size) if 0.0 < self._limit < size else torque
