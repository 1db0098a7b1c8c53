"""Closed loop of the formation as the audit predicts it: equations, limits and weights."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.audit.equations import (
    ellipse,
    gain,
    hill_map,
    mean_motion,
    samples,
    weights,
)
from spacecraft_gnc.vehicles.formation.scenario import Scenario

_ROUNDING: Final = 1e-9
"""Share of a limit: measured 1e-13."""


@dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """What the predictions of a scenario share.

    Attributes
    ----------
    n, p, horizon, checks : int
        Craft, shifts of each, steps predicted, instants of a step at which pairs are measured.
    A, K, Q, R : arrays
        Transition over a step, gain, weights.
    parts : (checks, 3, 6) array
        Positions at the instants of a step from the state after the impulse.
    path : (p, checks, 6) array
        Natural states at the same instants.
    phases : (n,) array
    delta_v, separation, angle : float
        Limits with their margins [m/s], [m], [rad].
    shift_weight : float
    """

    n: int
    p: int
    horizon: int
    checks: int
    A: Array
    K: Array
    Q: Array
    R: Array
    parts: Array
    path: Array
    phases: NDArray[np.int64]
    delta_v: float
    separation: float
    angle: float
    shift_weight: float

    @classmethod
    def of(cls, scenario: Scenario) -> Loop:
        """Return that of a scenario."""
        plant, g, period = scenario.plant, scenario.governor, scenario.period
        rate, p = mean_motion(plant), samples(plant, period)
        A, checks = hill_map(rate, period), g.prediction_substeps
        instants = np.arange(checks) / checks
        angles = 2.0 * math.pi / p * (np.arange(p)[:, None] + instants)
        asked = plant.max_communication_angle_deg - g.communication_angle_margin_deg
        return cls(
            len(plant.spacecraft), p, g.horizon, checks, A, gain(A, scenario.controller.weights),
            *weights(scenario.controller.weights),
            np.stack([hill_map(rate, period * t)[:3] for t in instants]), ellipse(plant, angles),
            np.asarray(g.phase, dtype=np.int64) % p, plant.max_delta_v - g.delta_v_margin,
            plant.min_separation + g.separation_margin,
            math.radians(asked) if asked < 180.0 else math.inf,
            g.shift_weight,
        )  # fmt: skip

    @property
    def slack(self) -> float:
        """Share of a limit within which two predictions may differ about a constraint.

        Beside rounding: a control period of which the orbit is a whole multiple within a tolerance
        alone has a natural motion that misses its own next sample.
        """
        around = self.path[:, 0]
        missed = np.abs(around @ self.A.T - np.roll(around, -1, axis=0))[:, :3].max()
        return _ROUNDING + 10.0 * self.horizon * float(missed) / self.separation

    def commanded(self, steps: NDArray[np.int64], shifts: NDArray[np.int64]) -> Array:
        """Return the natural states (m, n, 6) at steps (m,) under shifts (m, n)."""
        return np.asarray(self.path[(steps[:, None] + self.phases + shifts) % self.p, 0])

    def limit(self, name: str) -> float:
        """Return the limit of a constraint, with its margin [m/s], [m], [deg]."""
        limits = self.delta_v, self.separation, math.degrees(self.angle)
        return dict(zip(("delta-v", "separation", "angle"), limits, strict=True))[name]

    def apart(self) -> Array:
        """Return W of a pair (p, p)."""
        ahead = (np.arange(self.p)[:, None] - np.arange(self.p)) % self.p
        return np.asarray(self.shift_weight * np.minimum(ahead, self.p - ahead) ** 2.0)
