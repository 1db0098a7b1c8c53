"""Linear feedback of the relative motion, as controller and governor share it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacecraft_gnc.governors.periodic import PeriodicLoop
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.linear import HELD, LinearMotion


@dataclass(frozen=True, slots=True, eq=False)
class FeedbackLaw:
    """U = U0_k + Gamma_k v - K_k (x - E v) about a linear model of period p.

    Attributes
    ----------
    model : LinearMotion
        A_k, B_k, U0_k and Gamma_k.
    gains : (p, 6, 12) array
        K_k.
    """

    model: LinearMotion
    gains: Array

    @property
    def period(self) -> int:
        """Number of control steps p of a period."""
        return self.model.period

    @property
    def reference_gains(self) -> Array:
        """Gamma_k + K_k E (p, 6, 6): the wrench that a reference adds at once."""
        return np.asarray(self.model.reference_feedforward + self.gains @ HELD)

    def loop(self) -> PeriodicLoop:
        """Return x_{k+1} = (A_k - B_k K_k) x_k + B_k (Gamma_k + K_k E) v."""
        through = self.model.control
        return PeriodicLoop(
            self.model.transition - through @ self.gains, through @ self.reference_gains
        )

    def wrench(self, step: int, state: Array, reference: Array) -> Array:
        """Return U (6,) of a control step for the state x (12,) and the reference v (6,)."""
        return self.model.wrench(step, state, reference, self.gains)

    def reference(self, step: int, state: Array, wrench: Array) -> Array:
        """Return the reference v (6,) for which `wrench` returns a given one."""
        k = step % self.period
        model = self.model
        short = wrench - model.feedforward[k] + self.gains[k] @ state
        return np.asarray(np.linalg.solve(self.reference_gains[k], short))
