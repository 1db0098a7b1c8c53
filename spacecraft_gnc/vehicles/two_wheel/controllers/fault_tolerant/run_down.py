"""Speed that a wheel which does not answer will have, from what its speed has done.

It is commanded to stop, and either obeys in part, nu' = s u; or is braked by what holds it,
|nu|' = -a; or keeps its speed (s = a = 0). Both are fitted to its last steps, and the one that fits
better foretells the next ones. A share that is known is made up for by a larger command.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.types import Array

_KNOWN: Final = 2
"""Steps to which a model is fitted."""
_NEGLIGIBLE: Final = 1e-6
"""Share of the fastest speed seen, or of a command, that counts as none."""


class _Step(NamedTuple):
    before: float
    told: float
    after: float


class Prediction(NamedTuple):
    """Speeds to come."""

    speeds: Array
    """(N + 1,) from the speed of now on [rad/s]."""
    final: float
    """Speed that is kept in the end: zero of a wheel that stops, else that of now [rad/s]."""


class RunDown:
    """One wheel that does not answer.

    Parameters
    ----------
    period : float
        Control period [s].
    max_acceleration : float
        Limit of a command [rad/s^2]; infinity: none.
    """

    def __init__(self, period: float, max_acceleration: float) -> None:
        self.period, self.most = period, max_acceleration
        self._steps: list[_Step] = []
        self._fastest = 0.0

    def memory(self) -> tuple[Any, ...]:
        """Return the steps known, and the fastest speed."""
        return tuple(self._steps), self._fastest

    def recall(self, memory: tuple[Any, ...]) -> None:
        """Go on from a `memory`."""
        steps, self._fastest = memory
        self._steps = [_Step(*step) for step in steps]

    def observe(self, before: float, told: float, after: float) -> None:
        """Take in the speeds at both ends of a step [rad/s] and the command over it [rad/s^2]."""
        self._steps = [*self._steps, _Step(before, told, after)][-_KNOWN:]
        self._fastest = max(self._fastest, abs(before), abs(after))

    def stop(self, speed: float) -> float:
        """Return the acceleration to command at a speed, to bring the wheel to rest [rad/s^2]."""
        share = self._fitted()[1] or 1.0
        return min(max(-speed / (share * self.period), -self.most), self.most)

    def predict(self, speed: float, steps: int) -> Prediction:
        """Return what becomes of a speed [rad/s] over a number of steps."""
        braking, share = self._fitted()
        found = [speed]
        for _ in range(steps):
            nu = found[-1]
            nu += share * self.period * self.stop(nu)
            nu = math.copysign(max(abs(nu) - self.period * braking, 0.0), nu)
            found.append(0.0 if abs(nu) <= _NEGLIGIBLE * self._fastest else nu)
        return Prediction(np.array(found), 0.0 if found[-1] == 0.0 else speed)

    def _fitted(self) -> tuple[float, float]:
        """Return the braking a [rad/s^2] and the share s, of which one is zero."""
        braking, share = self._braking(), self._share()
        if share and self._misfit(0.0, share) <= self._misfit(braking, 0.0):
            return 0.0, share
        return braking, 0.0

    def _braking(self) -> float:
        """Return the mean fall of the speed's size over the steps that did not end at rest."""
        falls = [abs(s.before) - abs(s.after) for s in self._steps if s.after]
        mean = sum(falls) / len(falls) if falls else 0.0
        return mean / self.period if mean > _NEGLIGIBLE * self._fastest else 0.0

    def _share(self) -> float:
        """Return the share of its commands that came, by least squares."""
        told = sum(s.told * s.told for s in self._steps) * self.period
        came = sum((s.after - s.before) * s.told for s in self._steps)
        return min(came / told, 1.0) if told > 0.0 and came > _NEGLIGIBLE * told else 0.0

    def _misfit(self, braking: float, share: float) -> float:
        """Return the largest error of the speeds that a model gives for the steps known [rad/s]."""
        errors = [0.0]
        for before, told, after in self._steps:
            nu = before + share * self.period * told
            nu = math.copysign(max(abs(nu) - self.period * braking, 0.0), nu)
            errors.append(abs(after - nu))
        return max(errors)
