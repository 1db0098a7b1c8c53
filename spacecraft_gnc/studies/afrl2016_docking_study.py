"""What is flown of docking with a rotating chief in Kolmanovsky et al. 2016."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any, Final, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.scenario import load
from spacecraft_gnc.studies.campaigns import column, flown_campaign
from spacecraft_gnc.studies.flights import Flown, Progress, fly, set_vector
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.flight import DockingFlight

SCENARIO: Final = "afrl_docking"
UNGOVERNED: Final = "afrl_docking_ungoverned"
TILTED: Final = "afrl_docking_tilted"
FAILED: Final = "afrl_docking_thruster_failed"
FIGURE_DURATION: Final = 750.0  # of the report's Figs. 6 to 8 [s]


TILTED_DURATION: Final = 1400.0
"""Long enough to see what goes on with each rotation of 500 s [s]."""


class Start(NamedTuple):
    """Where the deputy begins, at rest in the chief frame."""

    port_offset: tuple[float, float, float]
    """[m]"""
    rotation_vector: tuple[float, float, float]
    """[rad]"""
    latest: float
    """By when it has to be docked [s]."""

    @property
    def words(self) -> str:
        """Both, in words."""
        return f"{self._told(self.port_offset)} m, {self._told(self.rotation_vector)} rad"

    @staticmethod
    def _told(vector: tuple[float, ...]) -> str:
        return f"({', '.join(f'{part:g}' for part in vector)})"


STARTS: Final = (
    Start((20.0, 4.0, -3.0), (0.3, -0.2, 0.25), 300.0),
    Start((10.0, -3.0, 2.0), (-0.2, 0.3, 0.4), 290.0),
    Start((30.0, 8.0, 6.0), (0.1, 0.5, -0.3), 380.0),
)
TIME_INVARIANT: Final = (
    "nmpc_controller.method=time_invariant_lqr",
    "reference_governor.governor=time_invariant",
)
"""Laid over a scenario: the same laws without their periodicity."""


@dataclass(frozen=True, slots=True)
class Case:
    """A flight with its metrics."""

    flown: Flown
    metrics: dict[str, Any]

    @property
    def flight(self) -> DockingFlight:
        """What was flown."""
        return cast("DockingFlight", self.flown.trajectory)

    @property
    def docked_at(self) -> float:
        """Time from which on it is docked for good [s]; NaN: never."""
        return self.number("docked_at")

    def number(self, name: str) -> float:
        """Return a metric; NaN where it has no value."""
        value = self.metrics[name]
        return math.nan if value is None else float(value)

    @property
    def broken(self) -> dict[str, float]:
        """By how much each constraint is broken, 0 where it holds: force, moment, distances."""
        plant = self.flown.scenario.plant
        return {
            "force": _over(self.number("max_force"), plant.max_force),
            "moment": _over(self.number("max_moment"), plant.max_moment),
            "line of sight": _over(-self.number("min_line_of_sight_margin"), 0.0),
            "clearance": _over(-self.number("min_clearance"), plant.clearance_tolerance),
        }


@dataclass(frozen=True, slots=True)
class Docked:
    """What a campaign of starts shows.

    Attributes
    ----------
    port_offset : (n, 3) array
        At the start [m].
    docked_at : (n,) array
        Time from which on it is docked for good [s]; NaN: never.
    passed : (n,) array of bool
        Whether every constraint was kept, and it docked.
    status : list of str
        Of each row.
    period : float
        Control period, of which times are multiples [s].
    """

    port_offset: Array
    docked_at: Array
    passed: NDArray[np.bool_]
    status: list[str]
    period: float

    def values(self) -> dict[str, Any]:
        """Return the numbers, ready for JSON."""
        known = self.docked_at[np.isfinite(self.docked_at)]
        quantiles = {"median": 0.5, "p99": 0.99, "max": 1.0}
        return {
            "starts": len(self.status),
            "passed": int(self.passed.sum()),
            "docked": int(known.size),
            **{
                f"docked_at_{name}": float(np.quantile(known, share)) if known.size else math.nan
                for name, share in quantiles.items()
            },
        }


@dataclass(frozen=True, slots=True)
class Study:
    """All that was flown."""

    governed: dict[Start, Case]
    ungoverned: dict[Start, Case]
    shown: Case
    """The first start, as long as the report's figures."""
    tilted: dict[str, Case]
    """By law: periodic, time-invariant."""
    failed: Case
    build_time: float
    """Of the loop of the first start, its sets from the cache [s]."""
    campaign: Docked | None


def study_all(options: Options) -> Study:
    """Fly everything, and count."""
    progress, longer = options.progress, (f"plant.duration={TILTED_DURATION}",)
    shown = _case(SCENARIO, (f"plant.duration={FIGURE_DURATION}",), progress)
    begun = perf_counter()
    load(SCENARIO).build()
    build_time = perf_counter() - begun
    return Study(
        {start: _case(SCENARIO, _from(start), progress) for start in STARTS},
        {start: _case(UNGOVERNED, _from(start), progress) for start in STARTS},
        shown,
        {
            "periodic": _case(TILTED, longer, progress),
            "time-invariant": _case(TILTED, (*longer, *TIME_INVARIANT), progress),
        },
        _case(FAILED, (), progress),
        build_time,
        _campaign(options.folder, options.runs, progress),
    )


def _from(start: Start) -> tuple[str, ...]:
    return (
        set_vector("plant.initial_port_offset", np.array(start.port_offset)),
        set_vector("plant.initial_rotation_vector", np.array(start.rotation_vector)),
    )


def _case(name: str, overrides: tuple[str, ...], progress: Progress) -> Case:
    flown = fly(name, overrides, repeats=1, progress=progress)
    return Case(flown, summarize(flown.trajectory, flown.scenario))


def _campaign(folder: Path | None, runs: int | None, progress: Progress) -> Docked | None:
    if folder is None or runs == 0:
        return None
    found = flown_campaign(SCENARIO, SCENARIO, folder / SCENARIO, runs, progress)
    status = found.table(["status"])["status"].to_pylist()
    passed = np.array([each == "passed" for each in status])
    start = column(found, "plant.initial_port_offset")
    return Docked(start, column(found, "docked_at"), passed, status, load(SCENARIO).period)


def _over(value: float, limit: float) -> float:
    """Return by how much a value exceeds a limit, 0 where it does not; NaN of NaN."""
    return float(np.maximum(value - limit, 0.0))
