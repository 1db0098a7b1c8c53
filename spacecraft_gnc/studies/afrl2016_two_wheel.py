"""Two wheels of Kolmanovsky et al. 2016, sections 3.1 and 4.1: NMPC when underactuated.

The report prints neither weights nor a start, and of numbers only times and the boxes of "settled":
the rest is of an independent implementation (docs/reproduce.md), as are the expected figures. The
largest yaws expected are the best of twelve maximizations by IPOPT from random starts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from spacecraft_gnc.campaign.statistics import clopper_pearson
from spacecraft_gnc.studies import afrl2016_laws as laws
from spacecraft_gnc.studies.afrl2016_region import Region
from spacecraft_gnc.studies.afrl2016_solves import Comparison
from spacecraft_gnc.studies.afrl2016_two_wheel_study import (
    COUNTED,
    FLOWN,
    HALF_WIDTH,
    RADII,
    REPORT,
    STARTS,
    YAWS,
    Study,
    study_all,
)
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.report import NONE, Check, Report, Table, seconds, times
from spacecraft_gnc.studies.speed import machine, machine_line

NAME: Final = "afrl2016_two_wheel"
TITLE: Final = "Two wheels: NMPC of an underactuated spacecraft"
REPORT_SETTLES: Final = 550.0  # from the first start, by the independent implementation [s]
PAPER_TIMES: Final = (1.2, 2.4)  # mean and longest solve [s]
WANTED: Final = 0.9  # share of random starts that converge
_LISTED: Final = 12  # starts that do not converge, in the table


def run(options: Options) -> Report:
    """Solve, fly and count; return the report."""
    study = study_all(options)
    checks = [*_law_checks(study), *_flight_checks(study)]
    tables = [_jump_table(study), _settled_table(study), _times_table(study)]
    if study.comparison is not None:
        checks += _comparison_checks(study.comparison)
    if study.region is not None and study.near is not None:
        checks += _region_checks(study.region, study.near)
        tables += _region_tables(study.region, study.near)
    drawn = (study.circles, study.plane, study.of(REPORT), study.region)
    return Report(NAME, TITLE, tables, checks, _values(study), drawn)


def _law_checks(study: Study) -> Iterator[Check]:
    """Check what the report's Figs. 1 and 2 show, and how far 30 steps and more reach."""
    before, behind = study.jump
    small, large = study.circles
    limit = laws.MAX_ACCELERATION
    yield Check("u1 behind phi = 0, radius 0.25", -limit, behind, 1e-6, "rad/s^2")
    yield Check("u1 before phi = 0, radius 0.25", limit, before, 1e-6, "rad/s^2")
    yield Check("radius 0.25: points without a plan", 0, small.infeasible, 0)
    missing = int(np.isnan(large.acceleration[:: len(large.angle) // COUNTED]).sum())
    yield Check("radius 0.5: points of 24 without a plan", 10, missing, 0)
    for laws_of in study.circles:
        name = f"radius {laws_of.radius:g}: mirrored plans, cost"
        yield Check(name, 0.0, laws.asymmetry(laws_of), 1e-6)
    for horizon, expected in YAWS.items():
        yield Check(f"N = {horizon}: largest yaw", expected, study.yaws[horizon], 1e-2, "rad")


def _flight_checks(study: Study) -> Iterator[Check]:
    """Check settling on the exact plant, limits and momentum."""
    first = study.cases[next(iter(STARTS)), REPORT].settled_at
    yield Check("(2), Q3 = 10: settled at", REPORT_SETTLES, first, 10.0, "s")
    for (start, model), case in study.cases.items():
        latest = STARTS[start][1]
        late = _beyond(case.settled_at, latest)
        if model != REPORT:
            yield Check(f"{model}, {start}: after {latest:g}", 0.0, late, 0.0, "s")
    speed = max(case.metrics["max_wheel_speed"] for case in study.cases.values())
    acceleration = max(case.metrics["max_wheel_acceleration"] for case in study.cases.values())
    drift = max(case.metrics["momentum_drift"] for case in study.cases.values())
    yield Check("wheel speed beyond 100", 0.0, _beyond(speed, laws.MAX_SPEED), 0.0, "rad/s")
    beyond = _beyond(acceleration, laws.MAX_ACCELERATION)
    yield Check("wheel acceleration beyond 5", 0.0, beyond, 0.0, "rad/s^2")
    yield Check("drift of the total momentum", 0.0, drift, 1e-12, "N m s")


def _beyond(value: float, limit: float) -> float:
    """Return by how much a value exceeds a limit, 0 where it does not; NaN of NaN."""
    return float(np.maximum(value - limit, 0.0))


def _comparison_checks(found: Comparison) -> Iterator[Check]:
    both = np.isfinite(found.excess)
    yield Check("IPOPT alone has a plan, steps", 0, int(
        (np.isnan(found.our_cost) & np.isfinite(found.their_cost)).sum()), 0)  # fmt: skip
    yield Check(
        "SQP: cost over IPOPT's, worst",
        0.0,
        _beyond(float(found.excess[both].max(initial=0.0)), 0.0),
        1e-6,
    )


def _region_checks(region: Region, near: Region) -> Iterator[Check]:
    short = _beyond(WANTED, region.share)
    yield Check("random starts: share short of 0.9", 0.0, short, 0.0)
    missed = int((~region.converged & region.near).sum())
    yield Check("random starts within 1 rad: not converged", 0, missed, 0)
    yield Check("starts within 1 rad alone: not converged", 0, int((~near.converged).sum()), 0)


def _jump_table(study: Study) -> Table:
    header = ("", *(f"N = {horizon}" for horizon in study.yaws))
    rows = [("largest yaw from rest", *(f"{yaw:.3f} rad" for yaw in study.yaws.values()))]
    share = 100.0 * float(np.isfinite(study.plane.cost).mean())
    before, behind = study.jump
    notes = [
        f"u1 {RADII[0]:g} rad off, at phi = -+{laws.BESIDE:g}: {before:+g}, {behind:+g} rad/s^2.",
        f"Of the plane up to +-{HALF_WIDTH:g} rad, {share:.0f} % have a plan of 30 steps.",
    ]
    return Table("Plans that end at rest at the target, model (2)", header, rows, notes)


def _settled_table(study: Study) -> Table:
    header = ("start: roll, pitch, yaw", *FLOWN, "wanted")
    rows = [
        (
            start,
            *(_time(study.cases[start, model].settled_at) for model in FLOWN),
            f"{latest:.0f} s",
        )
        for start, (_, latest) in STARTS.items()
    ]
    notes = [
        "Settled for good: less than 0.01 rad off, turning at less than 0.001 rad/s.",
        "Q = diag(1, 1, 30, 1e-6, 1e-6), r = 1e-3 where nothing else is said; N = 30, T = 10 s.",
    ]
    return Table("Time to settle on the exact plant, by prediction model", header, rows, notes)


def _time(value: float) -> str:
    return "never" if math.isnan(value) else f"{value:.0f} s"


def _times_table(study: Study) -> Table:
    header = ("time of a solve", "mean", "median", "longest", "speed-up")
    mean, longest = PAPER_TIMES
    rows = [("report: fmincon, MATLAB, 2.4 GHz", f"{mean} s", NONE, f"{longest} s", NONE)]
    for model in FLOWN:
        steps = np.concatenate([case.flown.step_times for case in study.of(model).values()])
        rows.append((f"commands: {model}", *_three(steps), NONE))
    if study.comparison is not None:
        found = study.comparison
        rows.append(("same problems: SQP", *_three(found.ours), f"{found.speed_up:.1f}"))
        rows.append(("same problems: IPOPT", *_three(found.theirs), "1"))
    notes = [
        "Commands: solves, restarts and fallbacks of a step, over three flights. Wanted: mean",
        "below 20 ms, longest below 300 ms, speed-up (median over the problems) of at least 3.",
        f"Same problems: those of the first flight with {REPORT}, from the same warm starts.",
        "This machine: " + machine_line(),
    ]
    return Table("Solve times", header, rows, notes)


def _three(row: Any) -> tuple[str, str, str]:
    found = times(row)
    return seconds(found["mean"]), seconds(found["median"]), seconds(found["max"])


def _region_tables(region: Region, near: Region) -> Iterator[Table]:
    parts = {
        "Euler angles in +-180 deg": region,
        "of these, within +-1 rad": region.of(region.near),
        "Euler angles in +-1 rad": near,
    }
    header = ("starts", "flown", "converged", "share, 95 %", "settled: median", "latest")
    rows = [(name, *_region_row(part)) for name, part in parts.items()]
    yield Table("Region of attraction: random starts at rest", header, rows)
    missed = region.of(~region.converged)
    if missed.status:
        yield _missed_table(missed)


def _region_row(part: Region) -> tuple[str, ...]:
    n, converged, found = len(part.status), int(part.converged.sum()), part.values()
    low, high = clopper_pearson(converged, n)
    latest = (_time(found[key]) for key in ("settle_time_median", "settle_time_max"))
    return str(n), str(converged), f"{100 * low:.1f} to {100 * high:.1f} %", *latest


def _missed_table(missed: Region) -> Table:
    header = ("roll, pitch, yaw [deg]", "turn", "error at the end", "status")
    rows = [
        (
            ", ".join(f"{angle:.0f}" for angle in np.degrees(missed.euler[i])),
            f"{missed.angle_deg[i]:.0f} deg",
            f"{missed.error_deg[i]:.3g} deg",
            missed.status[i],
        )
        for i in range(min(len(missed.status), _LISTED))
    ]
    more = len(missed.status) - len(rows)
    notes = [f"{more} more: gnc campaign report."] if more else []
    return Table("Starts that do not converge", header, rows, notes)


def _values(study: Study) -> dict[str, Any]:
    regions = {"random": study.region, "within_1_rad": study.near}
    return {
        "machine": machine(),
        "circles": [circle._asdict() for circle in study.circles],
        "plane": study.plane._asdict(),
        "largest_yaw": study.yaws,
        "flights": {
            f"{start}, {model}": {"times": times(case.flown.step_times), "metrics": case.metrics}
            for (start, model), case in study.cases.items()
        },
        "comparison": None if study.comparison is None else study.comparison._asdict(),
        "regions": {name: region.values() for name, region in regions.items() if region},
    }
