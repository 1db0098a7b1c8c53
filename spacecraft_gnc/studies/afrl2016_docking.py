"""Docking of Kolmanovsky et al. 2016, sections 3.2 and 4.2: periodic LQR and reference governor.

The report prints sizes, masses and the mean motion; rates, limits, ports, weights and starts are of
an independent implementation (docs/reproduce.md), as are the expected figures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from spacecraft_gnc.campaign.statistics import clopper_pearson
from spacecraft_gnc.studies.afrl2016_docking_study import STARTS, Case, Docked, Study, study_all
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.report import NONE, Check, Report, Table, seconds, times
from spacecraft_gnc.studies.speed import machine, machine_line
from spacecraft_gnc.vehicles.docking.decision import Phase
from spacecraft_gnc.vehicles.docking.facts import rotation_steps

NAME: Final = "afrl2016_docking"
TITLE: Final = "Docking with a rotating chief: periodic LQR and periodic reference governor"
DOCKS: Final = 285.0  # from the first start, by the independent implementation [s]
UNGOVERNED_FORCE: Final = 1.70  # likewise, without the governor [N]
_ROUNDING: Final = 1e-9
"""Of a constraint: what the integrator and the saturation leave of a limit that is met."""


def run(options: Options) -> Report:
    """Fly and count; return the report."""
    study = study_all(options)
    checks = [*_governed_checks(study), *_ungoverned_checks(study), *_other_checks(study)]
    tables = [_starts_table(study), _tilted_table(study), _abort_table(study), _times_table(study)]
    if study.campaign is not None:
        checks += _campaign_checks(study.campaign)
        tables.append(_campaign_table(study.campaign))
    drawn = (study.shown, study.governed, study.ungoverned, study.tilted, study.failed,
             study.campaign)  # fmt: skip
    return Report(NAME, TITLE, tables, checks, _values(study), drawn)


def _governed_checks(study: Study) -> Iterator[Check]:
    """Check docking in time within every constraint, between control steps as well."""
    first = study.governed[STARTS[0]]
    yield Check("first start: docked at", DOCKS, first.docked_at, 10.0, "s")
    for start, case in study.governed.items():
        late = float(np.maximum(case.docked_at - start.latest, 0.0))
        yield Check(f"{start.words}: docked after {start.latest:g}", 0.0, late, 0.0, "s")
    for start, case in study.governed.items():
        yield from _kept(start.words, case)


def _kept(words: str, case: Case) -> Iterator[Check]:
    units = {"force": "N", "moment": "N m"}
    for name, excess in case.broken.items():
        yield Check(f"{words}: {name} broken by", 0.0, excess, _ROUNDING, units.get(name, "m"))


def _ungoverned_checks(study: Study) -> Iterator[Check]:
    """Check that the governor is needed: what the first and third start break without it."""
    first = study.ungoverned[STARTS[0]]
    force = first.number("max_force")
    yield Check("ungoverned, first start: largest force", UNGOVERNED_FORCE, force, 0.02, "N")
    for start in (STARTS[0], STARTS[2]):
        broken = study.ungoverned[start].broken
        kept = sum(not broken[name] > 0.0 for name in ("force", "line of sight", "clearance"))
        yield Check(f"ungoverned, {start.words}: of 3 constraints kept", 0, kept, 0)


def _other_checks(study: Study) -> Iterator[Check]:
    """Check the tilted spin axis and the abort."""
    yield from _kept("tilted, periodic", study.tilted["periodic"])
    worse = _is_worse(study.tilted["time-invariant"], study.tilted["periodic"])
    yield Check("tilted: time-invariant laws do worse", 1, int(worse), 0)
    failed = study.failed
    behind = failed.broken["clearance"]
    yield Check("thruster lost: behind the docking face by", 0.0, behind, _ROUNDING, "m")
    yield Check("thruster lost: line of sight broken by", 0.0, failed.broken["line of sight"],
                _ROUNDING, "m")  # fmt: skip
    held = failed.flight.phase[-1] == Phase.HOLDING
    yield Check("thruster lost: held at the hold point", 1, int(held), 0)


def _is_worse(one: Case, other: Case) -> bool:
    """Tell whether a flight breaks what the other keeps, or docks later or never."""
    broken = any(
        excess > _ROUNDING >= other.broken[name] for name, excess in one.broken.items()
    )  # fmt: skip
    never = math.isnan(one.docked_at) and not math.isnan(other.docked_at)
    return broken or never or one.docked_at > other.docked_at


def _campaign_checks(found: Docked) -> Iterator[Check]:
    yield Check(
        "random starts: not docked within the constraints", 0, int((~found.passed).sum()), 0
    )


_COLUMNS: Final = ("docked at", "force", "moment", "line of sight", "clearance")


def _row(case: Case) -> tuple[str, ...]:
    m = case.metrics
    return (
        _time(case.docked_at),
        f"{m['max_force']:.4f} N",
        f"{m['max_moment']:.4f} N m",
        f"{m['min_line_of_sight_margin']:+.3f} m",
        f"{m['min_clearance']:+.4f} m",
    )


def _time(value: float) -> str:
    return "never" if math.isnan(value) else f"{value:.0f} s"


def _starts_table(study: Study) -> Table:
    header = ("start: port offset, rotation vector", "", *_COLUMNS, "wanted")
    rows = []
    for start in STARTS:
        rows.append(
            (start.words, "governed", *_row(study.governed[start]), f"{start.latest:.0f} s")
        )
        rows.append((start.words, "ungoverned", *_row(study.ungoverned[start]), NONE))
    plant = study.shown.flown.scenario.plant
    notes = [
        f"Limits: {plant.max_force:g} N and {plant.max_moment:g} N m by component; line of sight",
        f"above 0, clearance above -{plant.clearance_tolerance:g} m.",
        "Docked for good: 2 cm and 1 deg. Least and largest of all integrator steps of 0.25 s.",
        "Ungoverned: thrusters without saturation, so that what the law asks for is flown.",
    ]
    return Table("The three starts", header, rows, notes)


def _tilted_table(study: Study) -> Table:
    rows = [(name, *_row(case)) for name, case in study.tilted.items()]
    p = study.tilted["periodic"].flown.scenario.plant
    axis = p.chief_spin_axis / np.linalg.norm(p.chief_spin_axis)
    tilt = math.degrees(math.acos(float(np.clip(axis[2], -1.0, 1.0))))
    notes = [f"Spin axis {tilt:.0f} deg off the orbit normal, {p.chief_spin_rate:.4g} rad/s."]
    return Table("Tilted spin axis: LQR and governor", ("laws", *_COLUMNS), rows, notes)


def _abort_table(study: Study) -> Table:
    case, plant = study.failed, study.failed.flown.scenario.plant
    lost = np.flatnonzero(case.flight.lost_thruster >= 0)
    noticed = math.nan if not lost.size else float(case.flight.time[lost[0]])
    held = np.flatnonzero(case.flight.phase == Phase.HOLDING)
    holding = math.nan if not held.size else float(case.flight.time[held[0]])
    header = ("lost", "at", "noticed at", "holding from", *_COLUMNS[1:])
    row = (plant.thruster_lost, f"{plant.thruster_lost_at:g} s", _time(noticed), _time(holding),
           *_row(case)[1:])  # fmt: skip
    return Table("A thruster direction is lost", header, [row])


def _times_table(study: Study) -> Table:
    header = ("governor step", "mean", "median", "longest")
    rows = [
        (start.words, *_three(case.flown.decision_times)) for start, case in study.governed.items()
    ]
    rows.append(("tilted", *_three(study.tilted["periodic"].flown.decision_times)))
    notes = [
        f"Wanted: median below 10 ms, longest below 50 ms. Sets of {_steps(study)} steps; the loop",
        f"is built in {seconds(study.build_time)} with these from the cache.",
        "This machine: " + machine_line(),
    ]
    return Table("Times of the governor", header, rows, notes)


def _steps(study: Study) -> int:
    return rotation_steps(study.shown.flown.scenario)


def _three(row: Any) -> tuple[str, str, str]:
    found = times(row)
    return seconds(found["mean"]), seconds(found["median"]), seconds(found["max"])


def _campaign_table(found: Docked) -> Table:
    values = found.values()
    low, high = clopper_pearson(values["passed"], values["starts"])
    header = ("flown", "passed", "share, 95 %", "docked: median", "99 %", "latest")
    parts = (_time(values[f"docked_at_{name}"]) for name in ("median", "p99", "max"))
    share = f"{100 * low:.1f} to {100 * high:.1f} %"
    row = (str(values["starts"]), str(values["passed"]), share, *parts)
    notes = ["Passed: docked, and every constraint kept at every integrator step."]
    return Table("Random starts in the box of config/campaigns/afrl_docking.yaml", header, [row],
                 notes)  # fmt: skip


def _values(study: Study) -> dict[str, Any]:
    return {
        "machine": machine(),
        "governed": _told(study.governed),
        "ungoverned": _told(study.ungoverned),
        "tilted": {name: case.metrics for name, case in study.tilted.items()},
        "thruster_failed": study.failed.metrics,
        "build_time": study.build_time,
        "campaign": None if study.campaign is None else study.campaign.values(),
    }


def _told(cases: Mapping[Any, Case]) -> dict[str, Any]:
    return {
        start.words: {"times": times(case.flown.decision_times), "metrics": case.metrics}
        for start, case in cases.items()
    }
