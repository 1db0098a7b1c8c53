"""Simulated craft of a formation, advanced one control step at a time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.arguments import as_count, as_real, as_tuple, require_kind, require_positive
from spacecraft_gnc.arrays import as_finite
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.plant.actuators import Actuators, norm_limit
from spacecraft_gnc.signals import Signal
from spacecraft_gnc.types import Array, read_only
from spacecraft_gnc.vehicles.formation.dynamics import FormationMotion
from spacecraft_gnc.vehicles.formation.flight import FormationFlight
from spacecraft_gnc.vehicles.formation.signals import STATE, Motion
from spacecraft_gnc.vehicles.formation.state import FormationState


class FormationPlant:
    """Craft beside a circular orbit that change their velocities at the start of a control step.

    Parameters
    ----------
    motion : FormationMotion
        Orbit, control period and equations.
    position, velocity : (n, 3) arrays
        Of the craft at the start, Hill's frame [m], [m/s].
    n_steps : int
        Control steps of the scenario.
    max_delta_v : float
        Limit of the Euclidean norm of a craft's change of velocity [m/s].
    saturates : bool
        Whether the craft keep to the limit, in the direction asked for; else they do what is asked
        for.
    lost : sequence of int
        Rows of the craft that are lost: they no longer change their velocities.
    lost_at : float
        Time [s] from which on; it takes effect at the first control step that does not start
        before it.

    Raises
    ------
    ShapeError, ParameterError
        If an argument is refused.
    """

    flight = FormationFlight

    def __init__(
        self,
        motion: FormationMotion,
        position: Array,
        velocity: Array,
        n_steps: int,
        max_delta_v: float,
        *,
        saturates: bool = True,
        lost: Sequence[int] = (),
        lost_at: float = 0.0,
    ) -> None:
        remedy = "lengthen the duration to one control period or more"
        self.motion = require_kind("motion", motion, FormationMotion)
        self.period = motion.control_period
        self.n_steps = as_count("n_steps", n_steps, remedy=remedy)
        limit = require_positive("max_delta_v", max_delta_v)
        self.actuators = Actuators(norm_limit(limit if saturates else math.inf), "m/s")
        n = as_count("position, in craft", len(position), remedy="give 3 numbers for each craft")
        start = (
            as_finite("position", position, (n, 3), "3 numbers for each craft [m]"),
            as_finite("velocity", velocity, (n, 3), f"3 numbers for each of {n} craft [m/s]"),
        )
        self._idle = read_only(np.zeros((n, 3)))
        self._healthy, self._left = _craft(n, ()), _craft(n, as_tuple("lost", lost, "rows"))
        self._lost_from = self._first_step(lost_at)
        self._initial = self._told(0, *start, self._idle)
        self._state = self._initial

    @property
    def state(self) -> FormationState:
        """State at the start of the current control step."""
        return self._state

    @property
    def idle_control(self) -> Array:
        """Changes of velocity (n, 3) where no command came: none."""
        return self._idle

    def step(self, delta_v: Array) -> FormationState:
        """Change the velocities, move freely for one control period, and return the new state.

        ``delta_v`` (n, 3): Hill's frame [m/s].

        Raises
        ------
        ShapeError, ParameterError
            If it is not 3 finite numbers for each craft.
        """
        need = f"3 numbers for each of {len(self._idle)} craft [m/s]"
        command = as_finite("delta_v", delta_v, self._idle.shape, need)
        s = self._state
        given = self.actuators.drive(s.step, command)
        after = self.motion.advance(s.step, s.position, s.velocity, given, s.healthy)
        self._state = self._told(s.step + 1, *after, command)
        return self._state

    def outputs(self, applied: tuple[Array, Source | Sequence[Source]]) -> list[tuple[Signal, Any]]:
        """Return what a node publishes at the start of the current step: the state.

        ``applied``: changes of velocity (n, 3) of the step that ended now, and the source of each
        craft's, or one for all.
        """
        source = applied[1]
        sources = (source,) * len(self._idle) if isinstance(source, Source) else tuple(source)
        return [(STATE, Motion(self._state, sources))]

    def warm_up(self) -> None:
        """Load the integrator's kernels."""
        s = self._initial
        self.motion.advance(0, s.position, s.velocity, self._idle)

    def reset(self) -> None:
        """Return to the initial state."""
        self._state = self._initial
        self.actuators.reset()

    def _told(self, step: int, position: Array, velocity: Array, applied: Array) -> FormationState:
        """Return a state with what is true of the craft."""
        healthy = self._healthy if step < self._lost_from else self._left
        return FormationState(step, position, velocity, healthy, applied)

    def _first_step(self, at: float) -> int:
        """Return the first control step that does not start before a time [s]."""
        time = as_real("lost_at", at, lambda x: x >= 0.0, "a time >= 0 s", "give that of the loss")
        # A hair of slack: 3 * 109.8457 s are 3 periods of 109.8457 s whatever the last bit.
        return math.ceil(time / self.period * (1.0 - 1e-12))


def _craft(n: int, lost: Sequence[int]) -> NDArray[np.bool_]:
    """Return which of n craft answer (n,), all but those in some rows."""
    healthy = np.ones(n, dtype=bool)
    for row in lost:
        healthy[as_count("lost", row, 0, f"give a row below {n}", n - 1)] = False
    healthy.setflags(write=False)
    return healthy
