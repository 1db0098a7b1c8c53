"""Sections 4 and 6 of Bagherzadeh et al. 2023: simplified sensitivities, neighboring extremals.

Times are of whole commands, the median of each step over repeated flights.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.studies.bagherzadeh2023_study import (
    EXACT,
    NE,
    NE_EXACT_10,
    ONLINE,
    TIMED,
    Study,
    correction_times,
    study_all,
)
from spacecraft_gnc.studies.flights import Flown, fly
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.report import NONE, Check, Report, Table, seconds, times
from spacecraft_gnc.studies.speed import machine, machine_line
from spacecraft_gnc.types import Array

NAME: Final = "bagherzadeh2023"
TITLE: Final = (
    "Bagherzadeh, Karimpour, Keshmiri (Robotica 2023): neighboring extremal NMPC on SO(3)"
)
VARIANTS: Final = {
    "exact": "bagherzadeh2023_exact",
    "estimated du": "bagherzadeh2023_estimated_du",
    "estimated u and du": "bagherzadeh2023_estimated_u_du",
}
# Tables II and IV: longest, shortest, mean time of a step and total [s].
PAPER_II: Final = {
    "exact": (1.5417, 0.1228, 0.7689, 289.287),
    "estimated du": (0.7834, 0.1398, 0.2048, 77.091),
    "estimated u and du": (0.7852, 0.0591, 0.1166, 44.006),
}
PAPER_IV: Final = {
    EXACT: (0.7955, 0.1417, 0.2978, 112.079),
    NE: (0.1185, 0.0040, 0.0069, 2.653),
    NE_EXACT_10: (0.7422, 0.0102, 0.0431, 16.267),
}
# Largest and final angle from the exact flight [deg], found by an independent code; by start.
RAW: Final = ((0.20, 0.004), (0.88, 0.016), (2.70, 0.033))
CUT: Final = (0.07, 0.28, 0.25)
LINEAR: Final = (0.9, 3.6, 7.5)  # at 150 s


def run(options: Options) -> Report:
    """Fly the cases; return the report."""
    progress = options.progress
    variants = {name: fly(file, progress=progress) for name, file in VARIANTS.items()}
    studies = study_all(progress)
    costs = correction_times(studies)

    tables = [_table_2(variants), _table_4(studies[TIMED], costs), _errors_table(studies)]
    checks = [*_variant_checks(variants), *_study_checks(studies)]
    return Report(
        NAME, TITLE, tables, checks, _values(variants, studies, costs), (variants, studies)
    )


def square_errors(exact: Flown, other: Flown) -> Array:
    """Return (n, 4) integrals of the squared differences of u_1, u_2, u_3, |u| [(N m)^2 s]."""
    a, b = exact.trajectory, other.trajectory
    norms = np.linalg.norm(a.torque, axis=1) - np.linalg.norm(b.torque, axis=1)
    difference = np.column_stack([a.torque - b.torque, norms])
    return np.asarray(a.period * np.cumsum(difference**2, axis=0))


def _table_2(variants: Mapping[str, Flown]) -> Table:
    table = _times_table(PAPER_II, variants, "exact")
    iterations, errors = ["Newton steps, most"], ["ISE of the torque"]
    for name, flown in variants.items():
        m = _metrics(flown)
        error = square_errors(variants["exact"], flown)[-1].max()
        iterations += [NONE, f"{m['iterations_median']:g}, {m['iterations_max']}"]
        errors += [NONE, NONE] if name == "exact" else ["1e-7", f"{error:.0e}"]
    notes = [
        "ISE: integral of the squared torque difference from exact [(N m)^2 s], the largest of",
        "u1, u2, u3, |u|; the paper's is the order of its Fig. 2.",
        "Ours solves (26) and (33) in closed form: an estimate has nothing to save.",
        "This machine: " + machine_line(),
    ]
    title = "Table II: simplified sensitivities, time of a step"
    return Table(title, table.header, [*table.rows, iterations, errors], notes)


def _table_4(study: Study, costs: tuple[float, float]) -> Table:
    table = _times_table(PAPER_IV, study.flights, EXACT)
    stored, online = map(seconds, costs)
    share = f"{100.0 * study.hit_rate:.0f} %"
    notes = [
        f"The correction alone: {stored} along a stored run (NominalRun.torque), {online} on line",
        f"(NeighboringExtremal.solve), where it answered {share} of the steps.",
    ]
    return Table(f"Table IV: start changed by {TIMED}, time of a step", *table[1:3], notes)


def _times_table(
    paper: Mapping[str, tuple[float, ...]], flights: Mapping[str, Flown], first: str
) -> Table:
    """Return longest, shortest, mean and total of each way, a column for the paper's and ours."""
    header, rows = [""], [["longest"], ["shortest"], ["mean"], ["total"], ["speed-up"]]
    for name, flown in flights.items():
        header += [f"{name}: paper", "ours"]
        ours, theirs = times(flown.step_times), paper.get(name)
        for i, key in enumerate(("max", "min", "mean", "total")):
            rows[i] += [NONE if theirs is None else f"{theirs[i]:g} s", seconds(ours[key])]
        ratio = NONE if theirs is None else f"{paper[first][3] / theirs[3]:.2f}"
        rows[4] += [ratio, f"{flights[first].total / flown.total:.2f}"]
    return Table("", header, rows)


def _errors_table(studies: Mapping[str, Study]) -> Table:
    rows = []
    for name, study in studies.items():
        paths = {
            "NE of a propagated deviation, open loop (paper)": study.open_loop,
            "the linear prediction itself": study.predicted,
            "NE of the true state": study.raw,
        }
        for way, path in paths.items():
            error = study.error_of(path)
            rows.append([f"{name}: {way}", f"{error.max():.4f}", f"{error[-1]:.4f}", NONE, NONE])
        for way in (NE, NE_EXACT_10, ONLINE):
            error, m = study.error(way), _metrics(study.flights[way])
            label = f"{name}: {way}" + (", cut to the limit" if way == NE else "")
            share = f"{100.0 * m['neighboring_share']:.0f} %"
            torque = f"{m['neighboring_error']:.1e}"
            rows.append([label, f"{error.max():.4f}", f"{error[-1]:.4f}", share, torque])
    notes = [
        "Torque: largest difference from an exact solve of the same state [N m].",
        "The paper plots its states without figures; its drift is that of the first row of each.",
    ]
    title = "Angle from the flight of exact solves [deg]"
    return Table(title, ("start: way", "largest", "at 150 s", "steps by NE", "torque"), rows, notes)


def _metrics(flown: Flown) -> dict[str, Any]:
    return summarize(flown.trajectory, flown.scenario)


def _variant_checks(variants: Mapping[str, Flown]) -> Iterator[Check]:
    for name, flown in variants.items():
        m = _metrics(flown)
        yield Check(f"{name}: error at 150 s", 0.21364, m["final_error_deg"], 1e-5, "deg")
        yield Check(f"{name}: steps that failed", 0, m["unconverged_steps"], 0)
        if name != "exact":
            error = float(square_errors(variants["exact"], flown)[-1].max())
            yield Check(f"{name}: ISE of the torque", 0.0, error, 1e-18, "(N m)^2 s")


def _study_checks(studies: Mapping[str, Study]) -> Iterator[Check]:
    for (name, study), raw, cut, linear in zip(studies.items(), RAW, CUT, LINEAR, strict=True):
        error = study.error_of(study.raw)
        ours = {key: float(study.error(key).max()) for key in (NE, NE_EXACT_10, ONLINE)}
        drift = float(study.error_of(study.open_loop)[-1])
        yield Check(f"{name}: NE, largest error", raw[0], float(error.max()), 5e-3, "deg")
        yield Check(f"{name}: NE, error at 150 s", raw[1], float(error[-1]), 5e-4, "deg")
        yield Check(f"{name}: NE cut to the limit, largest", cut, ours[NE], 5e-3, "deg")
        yield Check(f"{name}: NE open loop, error at 150 s", linear, drift, 0.05, "deg")
        yield Check(f"{name}: NE on line, largest error", 0.0, ours[ONLINE], 0.01, "deg")
    largest = float(np.linalg.norm(studies[TIMED].raw.torques, axis=1).max())
    yield Check(f"{TIMED}: NE, largest |u| before the cut", 0.0144, largest, 5e-5, "N m")


def _values(
    variants: Mapping[str, Flown], studies: Mapping[str, Study], costs: tuple[float, float]
) -> dict[str, Any]:
    return {
        "machine": machine(),
        "correction_times": {"stored_run": costs[0], "on_line": costs[1]},
        "variants": {
            name: {
                "times": times(flown.step_times),
                "metrics": _metrics(flown),
                "integral_square_error": square_errors(variants["exact"], flown)[-1],
            }
            for name, flown in variants.items()
        },
        "starts": {name: _study_values(study) for name, study in studies.items()},
    }


def _study_values(study: Study) -> dict[str, Any]:
    errors = {name: study.error(name) for name in study.flights}
    paths = {"not cut": study.raw, "predicted": study.predicted, "open loop": study.open_loop}
    errors |= {f"NE {name}": study.error_of(path) for name, path in paths.items()}
    return {
        "hit_rate": study.hit_rate,
        "metrics": {name: _metrics(flown) for name, flown in study.flights.items()},
        "times": {name: times(flown.step_times) for name, flown in study.flights.items()},
        "error_max_deg": {name: error.max() for name, error in errors.items()},
        "error_end_deg": {name: error[-1] for name, error in errors.items()},
    }
