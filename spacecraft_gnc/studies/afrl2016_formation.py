"""Formation flight of Kolmanovsky et al. 2016, sections 3.3 and 4.3: the time shift governor.

The report prints orbit, weights, limits and the desired formation; starts and the definition of the
communication angle are of an independent implementation (docs/reproduce.md), as are the expected
figures.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from spacecraft_gnc.campaign.statistics import clopper_pearson
from spacecraft_gnc.studies.afrl2016_formation_study import (
    LIMITS,
    SCENARIO,
    Case,
    Deadlock,
    Formed,
    Study,
    study_all,
)
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.report import NONE, Check, Report, Table, seconds, times
from spacecraft_gnc.studies.speed import machine, machine_line

NAME: Final = "afrl2016_formation"
TITLE: Final = "Three spacecraft in formation: time shift governor"
FORMED_AT: Final = 73  # by the independent implementation, as are the others [control steps]
DELTA_V: Final = 0.887  # [m/s]
SEPARATION: Final = 1665.0  # [m]
UNGOVERNED_DELTA_V: Final = 1.219  # [m/s]
UNGOVERNED_SEPARATION: Final = 579.0  # [m]
_SHARE: Final = 0.01
"""Of a figure by which ours may differ from the expected one."""
_ROUNDING: Final = 1e-9
"""Of a constraint: what rounding leaves of a limit that is met."""
_UNITS: Final = dict(zip(LIMITS, ("m/s", "m", "deg"), strict=True))


def run(options: Options) -> Report:
    """Fly and count; return the report."""
    study = study_all(options)
    checks = [*_figure_checks(study), *_deadlock_checks(study.deadlocks), *_other_checks(study)]
    tables = [_figure_table(study), _deadlock_table(study.deadlocks), _loss_table(study.loss),
              _motion_table(study), _times_table(study)]  # fmt: skip
    if study.campaign is not None:
        checks += _campaign_checks(study.campaign)
        tables += _campaign_tables(study.campaign)
    drawn = (study.governed, study.ungoverned, study.deadlocks, study.loss, study.motions,
             study.campaign)  # fmt: skip
    return Report(NAME, TITLE, tables, checks, _values(study), drawn)


def _figure_checks(study: Study) -> Iterator[Check]:
    """Check the flights of Fig. 9: what the governor keeps, and that it is needed."""
    governed, ungoverned = study.governed, study.ungoverned
    yield Check("formed at step", FORMED_AT, governed.number("formed_at_step"), 3.0)
    yield _near("largest delta-v", DELTA_V, governed.number("max_delta_v"), "m/s")
    yield _near("least separation", SEPARATION, governed.number("min_separation"), "m")
    yield from _kept("governed", governed)
    largest, least = ungoverned.number("max_delta_v"), ungoverned.number("min_separation")
    yield _near("ungoverned: largest delta-v", UNGOVERNED_DELTA_V, largest, "m/s")
    yield _near("ungoverned: least separation", UNGOVERNED_SEPARATION, least, "m")
    kept = sum(not excess > 0.0 for excess in ungoverned.broken.values())
    yield Check("ungoverned: of 3 constraints kept", 0, kept, 0)


def _near(words: str, expected: float, ours: float, unit: str) -> Check:
    return Check(words, expected, ours, _SHARE * expected, unit)


def _kept(words: str, case: Case) -> Iterator[Check]:
    for name, excess in case.broken.items():
        yield Check(f"{words}: {name} broken by", 0.0, excess, _ROUNDING, _UNITS[name])


def _deadlock_checks(deadlocks: list[Deadlock]) -> Iterator[Check]:
    """Check that every stored start deadlocks, and that none does so for good."""
    stay = sum(bool(each.unresolved.metrics["deadlocked"]) for each in deadlocks)
    yield Check("stored starts: deadlocked, not resolved", len(deadlocks), stay, 0)
    formed = sum(each.resolved.metrics["formed_at_step"] is not None for each in deadlocks)
    yield Check("stored starts: formed, resolved", len(deadlocks), formed, 0)
    broken = sum(not _is_kept(each.resolved) for each in deadlocks)
    yield Check("stored starts: with a constraint broken", 0, broken, 0)


def _is_kept(case: Case) -> bool:
    return all(excess <= _ROUNDING for excess in case.broken.values())


def _other_checks(study: Study) -> Iterator[Check]:
    """Check the loss of a craft, and motion of which governor and laws do not know."""
    noticed = study.loss.metrics["spacecraft_loss_detected_at"] is not None
    yield Check("craft lost: noticed", 1, int(noticed), 0)
    formed = study.loss.metrics["formed_at_step"] is not None
    yield Check("craft lost: the others formed", 1, int(formed), 0)
    yield from _kept("craft lost", study.loss)
    for motion in ("two_body", "two_body_j2"):
        case = study.motions[motion]
        formed = case.metrics["formed_at_step"] is not None
        yield Check(f"{motion}: formed", 1, int(formed), 0)
        yield from _kept(motion, case)


def _campaign_checks(found: Formed) -> Iterator[Check]:
    unfit = int((found.flown & ~found.passed).sum())
    yield Check("feasible random starts: not formed within limits", 0, unfit, 0)


_COLUMNS: Final = ("formed at", "delta-v", "separation", "angle", "delta-v in all")


def _row(case: Case) -> tuple[str, ...]:
    m = case.metrics
    return (
        _step(case.number("formed_at_step")),
        f"{m['max_delta_v']:.4f} m/s",
        f"{m['min_separation']:.1f} m",
        f"{m['max_communication_angle_deg']:.2f} deg",
        f"{m['total_delta_v']:.2f} m/s",
    )


def _step(value: float | None) -> str:
    return "never" if value is None or math.isnan(value) else f"step {value:.0f}"


def _figure_table(study: Study) -> Table:
    rows = [("governed", *_row(study.governed)), ("ungoverned", *_row(study.ungoverned))]
    p, g = study.governed.flown.scenario.plant, study.governed.flown.scenario.governor
    limits = f"{p.max_delta_v:g} m/s, {p.min_separation:g} m, {p.max_communication_angle_deg:g} deg"
    notes = [
        f"Limits of delta-v, separation and communication angle: {limits}.",
        f"Formed for good: all shifts equal, every position error below {g.formed_error:g} m.",
        "Ungoverned: thrusters without saturation, so that what the law asks for is flown.",
    ]
    return Table("Fig. 9: three spacecraft form up", ("", *_COLUMNS), rows, notes)


def _deadlock_table(deadlocks: list[Deadlock]) -> Table:
    header = ("start", "unresolved", "resolved", "passages", *_COLUMNS[1:])
    rows = []
    for i, (unresolved, resolved) in enumerate(deadlocks):
        stays = "deadlocked" if unresolved.metrics["deadlocked"] else _row(unresolved)[0]
        formed, *others = _row(resolved)
        rows.append((f"{i + 1}", stays, formed, str(resolved.metrics["passages"]), *others))
    notes = ["Phases, offsets and amplitudes: spacecraft_gnc/studies/afrl2016_formation_starts.py."]
    return Table("Stored starts that deadlock in a permuted formation", header, rows, notes)


def _loss_table(case: Case) -> Table:
    m = case.metrics
    header = ("lost", "at", "noticed at", *_COLUMNS)
    row = (m["spacecraft_lost"] or NONE, _time(m["spacecraft_lost_at"]),
           _time(m["spacecraft_loss_detected_at"]), *_row(case))  # fmt: skip
    notes = ["Delta-v and angles of the two others; separation of all three."]
    return Table("A spacecraft is lost", header, [row], notes)


def _time(value: float | None) -> str:
    return NONE if value is None else f"{value:.0f} s"


def _motion_table(study: Study) -> Table:
    rows = []
    for motion, case in study.motions.items():
        error = f"{case.number('final_position_error'):.3f} m"
        rows.append((motion, *_row(case), error, f"{_apart(study, case):.1f} m"))
    header = ("motion flown", *_COLUMNS, "final error", "off Hill's")
    g = study.motions["hill"].flown.scenario.governor
    margins = (
        f"{g.delta_v_margin:g} m/s, {g.separation_margin:g} m, "
        f"{g.communication_angle_margin_deg:g} deg"
    )
    notes = [
        f"Margins of the governor: {margins}.",
        "Off Hill's: largest distance of a craft from where Hill's equations take it.",
    ]
    return Table("Motion of which laws and governor do not know", header, rows, notes)


def _apart(study: Study, case: Case) -> float:
    """Return the largest distance of a craft from where it is in the flight by Hill's equations."""
    other = study.motions["hill"].flight.position
    return float(np.linalg.norm(case.flight.position - other, axis=-1).max())


def _times_table(study: Study) -> Table:
    header = ("governor step", "mean", "median", "longest")
    cases = {"figure 9": study.governed, "craft lost": study.loss,
             "slowest stored start": _slowest(study.deadlocks)}  # fmt: skip
    rows = [(name, *_three(case.flown.decision_times)) for name, case in cases.items()]
    candidates = int(study.governed.flight.iterations.max())
    notes = [
        f"Wanted: below 30 ms a step. Candidates of a step: {candidates}.",
        "This machine: " + machine_line(),
    ]
    return Table("Times of the governor", header, rows, notes)


def _slowest(deadlocks: list[Deadlock]) -> Case:
    cases = [each.resolved for each in deadlocks]
    return max(cases, key=lambda case: float(case.flown.decision_times.max()))


def _three(row: Any) -> tuple[str, str, str]:
    found = times(row)
    return seconds(found["mean"]), seconds(found["median"]), seconds(found["max"])


def _campaign_tables(found: Formed) -> Iterator[Table]:
    v = found.values()
    low, high = clopper_pearson(v["passed"], v["feasible"])
    header = ("starts", "feasible", "formed in limits", "share, 95 %", "deadlocks", "unresolved",
              "formed: median", "99 %", "latest")  # fmt: skip
    steps = (_step(v[f"formed_at_{name}"]) for name in ("median", "p99", "max"))
    share = f"{100 * low:.1f} to {100 * high:.1f} %"
    counts = (str(v[name]) for name in ("starts", "feasible", "passed"))
    row = (*counts, share, str(v["with_deadlock"]), str(v["deadlocked"]), *steps)
    refused = "; ".join(f"{name} {count}" for name, count in sorted(v["refused"].items()))
    notes = [f"Refused before flight: {refused or 'none'}."]
    title = f"Random starts in the box of config/campaigns/{SCENARIO}.yaml"
    yield Table(title, header, [row], notes)
    spent = [
        (words, *(_number(v[f"{name}_{of}"], unit) for of in ("median", "p99", "max")))
        for words, name, unit in (
            ("largest delta-v", "max_delta_v", "m/s"),
            ("delta-v of all craft", "total_delta_v", "m/s"),
        )
    ]
    yield Table("Delta-v of the random starts", ("feasible starts", "median", "99 %", "largest"),
                spent)  # fmt: skip


def _number(value: float | None, unit: str) -> str:
    return NONE if value is None else f"{value:.3f} {unit}"


def _values(study: Study) -> dict[str, Any]:
    return {
        "machine": machine(),
        "governed": _told(study.governed),
        "ungoverned": _told(study.ungoverned),
        "deadlocks": [
            {"unresolved": each.unresolved.metrics, "resolved": each.resolved.metrics}
            for each in study.deadlocks
        ],
        "loss": _told(study.loss),
        "motions": {motion: _told(case) for motion, case in study.motions.items()},
        "campaign": None if study.campaign is None else study.campaign.values(),
    }


def _told(case: Case) -> dict[str, Any]:
    return {"times": times(case.flown.decision_times), "metrics": case.metrics}
