"""What is flown of three spacecraft in formation in Kolmanovsky et al. 2016."""

from __future__ import annotations

import math
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.campaign.flyer import FAILED, PASSED
from spacecraft_gnc.studies.afrl2016_formation_starts import DEADLOCKS, Start
from spacecraft_gnc.studies.campaigns import column, flown_campaign
from spacecraft_gnc.studies.flights import Flown, Progress, fly, set_vector
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.flight import FormationFlight

SCENARIO: Final = "afrl_formation"
UNGOVERNED: Final = "afrl_formation_ungoverned"
LOSS: Final = "afrl_formation_loss"
NONLINEAR: Final = "afrl_formation_nonlinear"
MOTIONS: Final = ("hill", "two_body", "two_body_j2")
LIMITS: Final = ("delta-v", "separation", "communication angle")
UNRESOLVED: Final = ("reference_governor.resolves_deadlocks=false",)
DEADLOCK_DURATION: Final = 33_000.0
"""Of 300 control steps [s]."""
_REASONS: Final = {
    "min_separation": "two craft too near at the start",
    "delta-v of": "delta-v",
    "separation of": "separation on the way",
    "direction of": "communication angle",
}
"""Words of the reason why a start is refused, and what it is called here."""


@dataclass(frozen=True, slots=True)
class Case:
    """A flight with its metrics."""

    flown: Flown
    metrics: dict[str, Any]

    @property
    def flight(self) -> FormationFlight:
        """What was flown."""
        return cast("FormationFlight", self.flown.trajectory)

    def number(self, name: str) -> float:
        """Return a metric; NaN where it has no value."""
        value = self.metrics[name]
        return math.nan if value is None else float(value)

    @property
    def broken(self) -> dict[str, float]:
        """By how much each constraint is broken, 0 where it holds: m/s, m, deg."""
        p = self.flown.scenario.plant
        return {
            "delta-v": _over(self.number("max_delta_v"), p.max_delta_v),
            "separation": _over(p.min_separation, self.number("min_separation")),
            "communication angle": _over(
                self.number("max_communication_angle_deg"), p.max_communication_angle_deg
            ),
        }


class Deadlock(NamedTuple):
    """A start that ends in a permuted formation, without and with the way out."""

    unresolved: Case
    resolved: Case


@dataclass(frozen=True, slots=True)
class Formed:
    """What a campaign of starts shows; rows are starts.

    Attributes
    ----------
    status : list of str
    refused : dict of str to int
        Infeasible starts by what they break.
    formed_at, max_delta_v, total_delta_v, min_separation, max_angle : (n,) arrays
        Metrics: [control steps], [m/s], [m/s], [m], [deg]; NaN: no value.
    deadlocks, deadlocked : (n,) arrays
        Times that the craft were parked in another formation; whether they are at the end.
    """

    status: list[str]
    refused: dict[str, int]
    formed_at: Array
    max_delta_v: Array
    total_delta_v: Array
    min_separation: Array
    max_angle: Array
    deadlocks: Array
    deadlocked: Array

    @property
    def flown(self) -> NDArray[np.bool_]:
        """Whether each start (n,) was feasible."""
        return np.array([each in (PASSED, FAILED) for each in self.status], dtype=bool)

    @property
    def passed(self) -> NDArray[np.bool_]:
        """Whether each start (n,) ended formed, with every constraint kept."""
        return np.array([each == PASSED for each in self.status], dtype=bool)

    def values(self) -> dict[str, Any]:
        """Return the numbers, ready for JSON."""
        known = self.flown
        quantiles = {"median": 0.5, "p99": 0.99, "max": 1.0}
        return {
            "starts": len(self.status),
            "feasible": int(known.sum()),
            "passed": int(self.passed.sum()),
            "formed": int(np.isfinite(self.formed_at[known]).sum()),
            "refused": self.refused,
            "with_deadlock": int((self.deadlocks[known] > 0.0).sum()),
            "deadlocked": int((self.deadlocked[known] > 0.0).sum()),
            **{
                f"{name}_{of}": _quantile(getattr(self, name)[known], share)
                for name in ("formed_at", "max_delta_v", "total_delta_v")
                for of, share in quantiles.items()
            },
            "min_separation": _least(self.min_separation[known]),
            "max_communication_angle_deg": -_least(-self.max_angle[known]),
        }


@dataclass(frozen=True, slots=True)
class Study:
    """All that was flown."""

    governed: Case
    ungoverned: Case
    deadlocks: list[Deadlock]
    loss: Case
    motions: dict[str, Case]
    """By the motion that is flown."""
    campaign: Formed | None


def study_all(options: Options) -> Study:
    """Fly everything, and count."""
    progress = options.progress
    return Study(
        _case(SCENARIO, (), progress),
        _case(UNGOVERNED, (), progress),
        [_deadlock(start, progress) for start in DEADLOCKS],
        _case(LOSS, (), progress),
        {motion: _case(NONLINEAR, (f"plant.motion={motion}",), progress) for motion in MOTIONS},
        _campaign(options.folder, options.runs, progress),
    )


def overrides_of(start: Start) -> tuple[str, ...]:
    """Return what lays a start over a scenario."""
    return (
        set_vector("plant.initial_phase", np.array(start.phase)),
        set_vector("plant.initial_along_track_offset", np.array(start.along_track_offset)),
        set_vector("plant.initial_amplitude", np.array(start.amplitude)),
    )


def _deadlock(start: Start, progress: Progress) -> Deadlock:
    given = (*overrides_of(start), f"plant.duration={DEADLOCK_DURATION}")
    return Deadlock(
        _case(SCENARIO, (*given, *UNRESOLVED), progress), _case(SCENARIO, given, progress)
    )


def _case(name: str, overrides: tuple[str, ...], progress: Progress) -> Case:
    flown = fly(name, overrides, repeats=1, progress=progress)
    return Case(flown, summarize(flown.trajectory, flown.scenario))


def _campaign(folder: Path | None, runs: int | None, progress: Progress) -> Formed | None:
    if folder is None or runs == 0:
        return None
    found = flown_campaign(SCENARIO, SCENARIO, folder / SCENARIO, runs, progress)
    table = found.table(["status", "reason"])
    status, reasons = table["status"].to_pylist(), table["reason"].to_pylist()
    return Formed(
        status,
        refusals([reason for reason, each in zip(reasons, status, strict=True)
                  if each not in (PASSED, FAILED)]),
        *(
            column(found, name)
            for name in (
                "formed_at_step", "max_delta_v", "total_delta_v", "min_separation",
                "max_communication_angle_deg", "deadlocks", "deadlocked",
            )
        ),
    )  # fmt: skip


def refusals(reasons: list[str]) -> dict[str, int]:
    """Return how many starts were refused for each constraint; others by their words."""
    return dict(Counter(_constraint(reason) for reason in reasons))


def _constraint(reason: str) -> str:
    for words, name in _REASONS.items():
        if re.search(rf"\b{words}\b", reason):
            return name
    return reason


def _over(value: float, limit: float) -> float:
    """Return by how much a value exceeds a limit, 0 where it does not; NaN of NaN."""
    return float(np.maximum(value - limit, 0.0))


def _quantile(values: Array, share: float) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.quantile(known, share)) if known.size else None


def _least(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(known.min()) if known.size else math.nan
