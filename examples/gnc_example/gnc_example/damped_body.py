"""Vehicle ``damped_body``: a rigid body with a ball of fuel that turns against friction.

The ball adds no product of inertia. Its viscous torque takes energy out of the motion, so that a
spin about any axis but the one of the largest moment of inertia ends there: the flat spin of
Explorer 1. The controller does not know of it.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.loop import State
from spacecraft_gnc.types import Vector3, read_only
from spacecraft_gnc.vehicles.rigid_body.descriptor import VEHICLE as RIGID_BODY
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant

_DEFAULTS = {"ball_inertia": 0.02, "viscosity": 0.002}
"""``plugin.ball_inertia`` [kg m^2] and ``plugin.viscosity`` [N m s]."""


class DampedBody(RigidBodyPlant):
    """A rigid body with a ball of fuel inside.

    Over a control period T the torque of the ball is held at what slows the relative rate down
    exactly while the body keeps its own: J_b (1 - exp(-c T / J_b)) (omega_b - omega) / T.
    """

    ball_inertia = _DEFAULTS["ball_inertia"]
    viscosity = _DEFAULTS["viscosity"]

    @classmethod
    def from_scenario(cls, scenario: Any) -> DampedBody:
        """Build the body as a rigid one, and the ball from ``plugin.*``; both turn together."""
        plant = super().from_scenario(scenario)
        for name, default in _DEFAULTS.items():
            value = scenario.plant.plugin.get(name, default)
            if not isinstance(value, float) or not value > 0.0:
                raise ParameterError(
                    f"plugin.{name}: received {value!r}; required a number > 0; give {default}"
                )
            setattr(plant, name, value)
        plant.reset()
        return plant

    def reset(self) -> None:
        """Return to the initial state, in which the ball turns with the body."""
        super().reset()
        self._ball_rate = self.angular_velocity()

    def step(self, torque: Vector3) -> State:
        """Hold ``torque`` (3,) [N m] and that of the ball for one control period."""
        share = 1.0 - math.exp(-self.viscosity * self.period / self.ball_inertia)
        impulse = self.ball_inertia * share * (self._ball_rate - self.angular_velocity())
        before = self.state.attitude
        state = super().step(torque + impulse / self.period)
        turned = state.attitude.T @ before  # components of the old body frame in the new one
        self._ball_rate = read_only(turned @ (self._ball_rate - impulse / self.ball_inertia))
        return state


VEHICLE = replace(
    RIGID_BODY,
    name="damped_body",
    description="rigid body with a ball of fuel that turns against friction",
    plant=Lazy(f"{__name__}:DampedBody.from_scenario"),
    audit=None,  # the rigid body's integrates a motion without the ball
)
