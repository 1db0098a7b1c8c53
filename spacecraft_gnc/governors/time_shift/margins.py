"""Margins of the constraints of a formation: what is nearest to its limit, where and when."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

from spacecraft_gnc.governors.time_shift.problem import TimeShiftProblem


class Constraint(IntEnum):
    """What a margin is of."""

    DELTA_V = 0
    SEPARATION = 1
    ANGLE = 2

    @property
    def text(self) -> str:
        """The name in words."""
        return ("delta-v", "separation", "angle between actual and commanded direction")[self]


class Margin(NamedTuple):
    """Extreme of one constraint along a prediction, beside its limit."""

    constraint: Constraint
    craft: tuple[int, ...]
    """Indices of the craft: one, or a pair."""
    ahead: float
    """When, counted from the step of the decision [steps]; whole for substeps = 1."""
    value: float
    """[m/s], [m] or [rad]"""
    limit: float
    """In the same unit."""
    share: float
    """Room left as a share of the limit; negative where it is exceeded, infinite without limit."""

    @property
    def is_kept(self) -> bool:
        """Whether the limit is kept."""
        return self.share >= 0.0

    def text(self, names: tuple[str, ...] = ()) -> str:
        """Return for example ``separation of craft 1 and 3: 812.4 m, limit 1000 m, in 7 steps``."""
        told = " and ".join(names[i] if names else str(i + 1) for i in self.craft)
        unit, factor = (("m/s", 1.0), ("m", 1.0), ("deg", math.degrees(1.0)))[self.constraint]
        when = "now" if self.ahead == 0.0 else f"in {self.ahead:g} steps"
        return (
            f"{self.constraint.text} of {'' if names else 'craft '}{told}: "
            f"{factor * self.value:.4g} {unit}, limit {factor * self.limit:.4g} {unit}, {when}"
        )


def of_delta_v(problem: TimeShiftProblem, i: int, square: float, ahead: int) -> Margin:
    """Return the margin of the largest delta-v of a craft, given by its square."""
    value, limit = math.sqrt(square), problem.max_delta_v
    share = math.inf if limit == math.inf else (limit - value) / limit
    return Margin(Constraint.DELTA_V, (i,), float(ahead), value, limit, share)


def of_separation(
    problem: TimeShiftProblem, pair: tuple[int, int], square: float, instant: int
) -> Margin:
    """Return the margin of the least distance of a pair, given by its square."""
    value, limit = math.sqrt(square), problem.min_separation
    share = math.inf if limit == 0.0 else (value - limit) / limit
    return Margin(Constraint.SEPARATION, pair, instant / problem.substeps, value, limit, share)


def of_angle(
    problem: TimeShiftProblem, pair: tuple[int, int], cosine: float, instant: int
) -> Margin:
    """Return the margin of the largest angle of a pair, given by its cosine (2: there is none)."""
    value = 0.0 if cosine > 1.0 else math.acos(max(-1.0, cosine))
    limit = problem.max_angle
    share = math.inf if limit == math.pi else (limit - value) / limit
    return Margin(Constraint.ANGLE, pair, instant / problem.substeps, value, limit, share)
