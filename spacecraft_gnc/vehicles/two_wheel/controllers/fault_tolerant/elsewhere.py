"""Plans of two wheels to an attitude of rest of a spacecraft with total momentum.

    J omega = (p - h - B nu_R) - B (nu - nu_R),   p = R^T H,   B nu_R the part of p - h that B makes

The first bracket is along n, and zero at rest. With the speeds counted from nu_R it is the drift of
a spacecraft without momentum, which the planner knows how to fly; but it depends on the attitude.
It is taken along the plan of the step before, whose end is the same. The tilt of H then helps
instead of having to do all about the third axis, which makes `holding.go_to_rest` slow.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.controllers.fault_tolerant.holding import TwoWheels
from spacecraft_gnc.vehicles.two_wheel.controllers.underactuated.pilot import TwoWheelPilot
from spacecraft_gnc.vehicles.two_wheel.hold import Held
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

_NEAR: Final = 0.05
"""Angle [rad] off the attitude of rest below which the regulator is better."""
_MOST: Final = 0.4
"""Turn [rad] by H over a horizon up to which the drift of one plan serves the next."""


class PlannedRest:
    """Bring two wheels' spacecraft near an attitude of rest.

    Parameters
    ----------
    wheels : TwoWheels
    pilot : TwoWheelPilot
        Of the same wheels.
    """

    def __init__(self, wheels: TwoWheels, pilot: TwoWheelPilot) -> None:
        self._wheels, self._pilot = wheels, pilot
        self._attitudes: Array | None = None
        self._failed = False

    def memory(self) -> tuple[Any, ...]:
        """Return the attitudes of the last plan, and whether none was found."""
        return self._attitudes, self._failed

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on from a `memory`; the pilot has its own."""
        self._attitudes, self._failed = memory

    def accelerations(self, state: WheelState, held: Held, speeds: Array) -> Array | None:
        """Return accelerations (m,); None where the regulator has to fly.

        ``speeds`` (N + 1, m): those expected, of which the wheels that do not answer count.
        """
        if self._failed or not self._serves(state, held):
            self._attitudes = None
            return None
        wheels, period = self._wheels, self._wheels.gyrostat.time_step
        along = self._along(state)
        dead = speeds[:, ~wheels.healthy] @ wheels.gyrostat.wheels[:, ~wheels.healthy].T
        excess = np.einsum("kij,i->kj", along, state.total_momentum) - dead
        still = excess @ np.linalg.pinv(wheels.own).T
        drift = np.linalg.solve(wheels.gyrostat.inertia, (excess - still @ wheels.own.T).T).T
        own = state.wheel_speed[wheels.healthy] - still[0]
        try:
            plan = self._pilot.planner.plan(
                state.step, state.attitude, own, held.attitude, np.ascontiguousarray(drift)
            )
        except GncError:  # faster than the planner believes that wheels can be
            self._failed = True
            return None
        self._failed = plan.source is not Source.OPTIMAL
        if self._failed:
            return None
        found = plan.solution.attitudes
        self._attitudes = np.concatenate([found[1:], found[-1:]])
        wanted = plan.acceleration + (still[1] - still[0]) / period
        return wheels.accelerations(state.wheel_speed, wanted)

    def _serves(self, state: WheelState, held: Held) -> bool:
        """Tell whether the attitude is far from rest, and H turns the bus slowly."""
        wheels = self._wheels
        slowly = float(np.linalg.norm(state.total_momentum) / np.linalg.norm(wheels.across))
        span = self._pilot.horizon * wheels.gyrostat.time_step
        return lie.angle_between(state.attitude, held.attitude) > _NEAR and slowly * span < _MOST

    def _along(self, state: WheelState) -> Array:
        """Return the attitudes (N + 1, 3, 3) along which the drift is taken."""
        if self._attitudes is None:
            return np.tile(state.attitude, (self._pilot.horizon + 1, 1, 1))
        return np.concatenate([state.attitude[None], self._attitudes[1:]])
