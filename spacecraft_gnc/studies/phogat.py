"""Phogat, Chatterjee, Banavar: energy-optimal transfers within bounds, section 6.

The paper prints no figure that can be checked: it has the plots of figure 4 and two statements on
them. The expected figures come from CasADi with IPOPT.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.ocp.transfer import TransferSolution
from spacecraft_gnc.status import Status
from spacecraft_gnc.studies.options import Options
from spacecraft_gnc.studies.phogat_compare import AGREE, Compared
from spacecraft_gnc.studies.phogat_speed import growth
from spacecraft_gnc.studies.phogat_study import (
    ANGLES,
    AXES,
    TIMES,
    Case,
    Study,
    holding_torque,
    kept,
    saturated_as_co_states_say,
    study_all,
    time_of_full_torque,
)
from spacecraft_gnc.studies.phogat_transfers import BODY, MAX_MOMENTUM, MAX_TORQUE
from spacecraft_gnc.studies.report import NONE, Check, Report, Table, seconds
from spacecraft_gnc.studies.speed import machine, machine_line

NAME: Final = "phogat"
TITLE: Final = (
    "Phogat, Chatterjee, Banavar: discrete-time optimal attitude control with momentum and control "
    "constraints, section 6"
)
COST: Final = 20965.95496  # of figure 4 [N^2 m^2]
COST_Y90: Final = 14192.2478  # 90 deg about y in 30 s
ACTIVE: Final = {
    ("torque", 1, 1): (0, 5), ("torque", 1, -1): (179, 189), ("torque", 2, 1): (0, 3),
    ("momentum", 1, 1): (70, 132), ("momentum", 2, 1): (58, 79),
}  # fmt: skip
"""Quantity, axis and side of a bound, and the steps over which it acts in figure 4."""
HELD: Final = {1: 0.934258, 2: 1.469680}
"""Largest torque on an axis while its momentum saturates, by IPOPT [N m]; 0 in the paper."""
_LETTERS: Final = "xyz"
_SYMBOL: Final = {"torque": "u", "momentum": "Pi"}


def run(options: Options) -> Report:
    """Solve the transfers; return the report."""
    study = study_all(options)
    plan = study.figure_4
    checks = [*_plan_checks(study), *_statement_checks(plan), *_range_checks(study)]
    tables = [_statements(plan), _cases_table(study), _shortest_table(study), _methods(study)]
    if study.compared:
        checks += _comparison_checks(study.compared)
        tables.append(_comparison_table(study.compared))
    return Report(NAME, TITLE, tables, checks, _values(study), (study,))


def _plan_checks(study: Study) -> Iterator[Check]:
    """Check the plan of figure 4."""
    plan = study.figure_4
    yield Check("figure 4: cost", COST, plan.cost, 1e-5, "N^2 m^2")
    yield Check("figure 4 by Algorithm 2 alone: cost", COST, study.algorithm_2.cost, 1e-5,
                "N^2 m^2")  # fmt: skip
    for (quantity, axis, side), (first, last) in ACTIVE.items():
        found = [
            one for one in plan.active
            if (one.quantity, one.axis, math.copysign(1, one.bound)) == (quantity, axis, side)
        ]  # fmt: skip
        name = f"figure 4: {_SYMBOL[quantity]}_{_LETTERS[axis]} at its "
        name += "upper bound" if side > 0 else "lower bound"
        alone = found[0] if len(found) == 1 else None
        yield Check(f"{name}, first step", first, alone.first if alone else math.nan, 0)
        yield Check(f"{name}, last step", last, alone.last if alone else math.nan, 0)
    yield Check("figure 4: bounds that act otherwise", 0, len(plan.active) - len(ACTIVE), 0)
    error = lie.angle_between(plan.attitude[-1], plan.problem.goal)
    yield Check("figure 4: roll-out off the goal", 0.0, error, 1e-12, "rad")
    yield Check("figure 4: largest residual of (5.6)-(5.8)", 0.0, plan.residuals.largest, 1e-8)
    yield Check("figure 4: curvature below 1e-3", 0.0, max(0.0, 1e-3 - plan.min_curvature), 0.0)
    for name, values, bound in (
        ("torque beyond 20", plan.torque, MAX_TORQUE),
        ("momentum beyond 70", plan.momentum, MAX_MOMENTUM),
    ):
        unit = "N m" if bound == MAX_TORQUE else "N m s"
        beyond = max(0.0, float(np.abs(values).max()) - bound)
        yield Check(f"figure 4: {name}", 0.0, beyond, 0.0, unit)


def _statement_checks(plan: TransferSolution) -> Iterator[Check]:
    """Check what the paper says of figure 4."""
    wrong = int(not saturated_as_co_states_say(plan))
    yield Check("saturates where |gamma| > 20 only: violated", 0, wrong, 0)
    holding = holding_torque(plan)
    for axis, largest in HELD.items():
        steps, letter = kept(plan, axis), _LETTERS[axis]
        torque = plan.torque[steps, axis]
        name = f"while Pi_{letter} saturates: |u_{letter}|"
        yield Check(f"{name}, largest", largest, float(np.abs(torque).max()), 1e-4, "N m")
        rest = float(np.abs(torque - holding[steps, axis]).max())
        yield Check(f"{name} less gyroscopic", 0.0, rest, 1e-9, "N m")


def _range_checks(study: Study) -> Iterator[Check]:
    """Check cases and the shortest times."""
    cost = study.cases["y", 90, 30].plan.cost
    yield Check("90 deg about y in 30 s: cost", COST_Y90, cost, 1e-4, "N^2 m^2")
    full = time_of_full_torque(10.0, float(BODY.inertia[0, 0]), MAX_TORQUE)
    shortest = study.shortest["x", 10]
    steps = math.ceil(full / BODY.time_step)
    yield Check("10 deg about x: fewest steps", steps, shortest.plan.problem.n_steps, 0)
    contradicted = sum(
        case.plan.converged == (time < study.shortest[axis, angle].plan.problem.duration - 1e-9)
        for (axis, angle, time), case in study.cases.items()
    )
    yield Check("cases that contradict the shortest time", 0, contradicted, 0)
    over = sum(one.proven > one.plan.problem.duration + 1e-9 for one in study.shortest.values())
    yield Check("shortest plans below the proven bound", 0, over, 0)


def _comparison_checks(compared: tuple[Compared, ...]) -> Iterator[Check]:
    by_ipopt = [one for one in compared if math.isfinite(one.ipopt_cost)]
    missed = sum(not one.plan.converged for one in by_ipopt)
    proven = sum(one.plan.status == Status.INFEASIBLE for one in by_ipopt)
    both = np.array([one.difference for one in by_ipopt if one.plan.converged])
    yield Check("proven infeasible, solved by IPOPT", 0, proven, 0)
    yield Check("IPOPT alone has a plan", 0, missed, 0)
    yield Check("cost over IPOPT's, worst", 0.0, max(0.0, float(both.max(initial=0.0))), AGREE)
    short = max(0.0, 0.98 - float((np.abs(both) < AGREE).mean()))
    yield Check("same cost as IPOPT: share short of 0.98", 0.0, short, 0.0)


def _statements(plan: TransferSolution) -> Table:
    rows = []
    gamma = np.abs(plan.co_momentum).max(axis=0)
    for axis in range(3):
        count, letter = int((plan.active_torque[:, axis] != 0).sum()), _LETTERS[axis]
        rows.append((f"control saturates where the co-state exceeds 20: {letter}",
                     f"{count} steps; |gamma_{letter}| up to {gamma[axis]:.2f} N m"))  # fmt: skip
    for axis in HELD:
        steps, letter = kept(plan, axis), _LETTERS[axis]
        held = np.abs(plan.torque[steps, axis])
        rows.append((
            f"momentum saturates, control goes to zero: {letter}",
            f"approximate: {held.min():.2f} to {held.max():.2f} N m, steps {steps[0]}-{steps[-1]}",
        ))  # fmt: skip
    notes = [
        "The first is exact, step by step. The second is not: the torque that remains is the",
        "gyroscopic one, which turns momentum from axis to axis; it is exactly balanced.",
    ]
    return Table("The paper's statements on figure 4", ("paper", "ours"), rows, notes)


def _cases_table(study: Study) -> Table:
    header = ("axis, angle", *(f"{time} s" for time in TIMES))
    rows = [
        (f"{axis}, {angle} deg", *(_cell(study.cases[axis, angle, time]) for time in TIMES))
        for axis in AXES
        for angle in ANGLES
    ]
    notes = [
        "Sum of |u|^2 / 2 [N^2 m^2]; in parentheses: relative difference from IPOPT's cost.",
        "infeasible: proven by the bound on the time; none: no plan found, by IPOPT neither.",
    ]
    if not study.compared:
        notes = [
            "Sum of |u|^2 / 2 [N^2 m^2]. infeasible: proven by the bound on the time;",
            "none: no plan found. IPOPT was left out.",
        ]
    return Table("Cases of the paper's range, rest to rest, steps of 0.1 s", header, rows, notes)


def _cell(case: Case) -> str:
    plan, compared = case
    theirs = math.nan if compared is None else compared.ipopt_cost
    if not plan.converged:
        text = "infeasible" if plan.status == Status.INFEASIBLE else "none"
        return text if math.isnan(theirs) else f"{text}, IPOPT {theirs:.2f}"
    if compared is None:
        return f"{plan.cost:.2f}"
    if math.isnan(theirs):
        return f"{plan.cost:.2f} (IPOPT none)"
    return f"{plan.cost:.2f} ({compared.difference:.0e})"


def _shortest_table(study: Study) -> Table:
    header = ("axis", *(f"{angle} deg" for angle in ANGLES))
    rows = []
    for axis in AXES:
        found = [study.shortest[axis, angle] for angle in ANGLES]
        cells = (f"{one.plan.problem.duration:.1f} s (> {one.proven - 0.1:.1f})" for one in found)
        rows.append((axis, *cells))
    notes = ["Fewest steps with a plan; in parentheses: no plan of this time or less, proven."]
    return Table("Shortest transfers, rest to rest", header, rows, notes)


def _methods(study: Study) -> Table:
    header = ("figure 4, N = 190", "Newton steps", "time", "cost")
    rows = [
        (name, f"{plan.iterations}", seconds(plan.solve_time), f"{plan.cost:.5f}")
        for name, plan in (
            ("homotopy, then Algorithm 2", study.figure_4),
            ("Algorithm 2 alone", study.algorithm_2),
        )
    ]
    rows += [
        (f"N = {one.n_steps}", f"{one.iterations}", seconds(one.time), NONE)
        for one in study.lengths
    ]
    notes = [
        "First row: three starts, of which the cheapest plan is taken; the others: one start.",
        f"The time of a Newton step grows with N to the power {growth(study.lengths):.2f}.",
        "This machine: " + machine_line(),
    ]
    return Table("What it costs", header, rows, notes)


def _comparison_table(compared: tuple[Compared, ...]) -> Table:
    outcomes = [one.outcome for one in compared]
    rows = [(name, f"{outcomes.count(name)}") for name in sorted(set(outcomes))]
    times = np.array([(one.ours, one.ipopts) for one in compared])
    ours, ipopts = times[np.isfinite(times).all(axis=1)].T
    rows += [
        ("median time, ours", seconds(float(np.median(ours)))),
        ("median time, IPOPT", seconds(float(np.median(ipopts)))),
        ("speed-up: median, least", f"{np.median(ipopts / ours):.1f}, {(ipopts / ours).min():.1f}"),
    ]
    notes = [
        f"The cases above and {len(compared) - len(AXES) * len(ANGLES) * len(TIMES)} random ones.",
        "The same: to 1e-6. Times: from the same straight start, where both solve it.",
    ]
    return Table("Beside CasADi and IPOPT", ("transfers", "number"), rows, notes)


def _values(study: Study) -> dict[str, Any]:
    return {
        "machine": machine(),
        "figure_4": _plan_values(study.figure_4),
        "cases": [
            {"axis": axis, "angle_deg": angle, "time": time, **_case_values(case)}
            for (axis, angle, time), case in study.cases.items()
        ],
        "random": [_case_values(case) for case in study.random],
        "shortest": [
            {"axis": axis, "angle_deg": angle, "time": one.plan.problem.duration,
             "proven": one.proven}
            for (axis, angle), one in study.shortest.items()
        ],
        "lengths": [one._asdict() for one in study.lengths],
    }  # fmt: skip


def _case_values(case: Case) -> dict[str, Any]:
    found: dict[str, Any] = _plan_values(case.plan)
    if case.compared is not None:
        c = case.compared
        found |= {"ipopt_cost": c.ipopt_cost, "outcome": c.outcome, "ipopt_starts": c.ipopt_starts,
                  "time_ours": c.ours, "time_ipopt": c.ipopts}  # fmt: skip
    return found


def _plan_values(plan: TransferSolution) -> dict[str, Any]:
    return {
        "status": plan.status.text,
        "cost": plan.cost if plan.converged else None,
        "iterations": plan.iterations,
        "residual": plan.residuals.largest,
        "min_curvature": plan.min_curvature,
        "active": [one._asdict() for one in plan.active],
        "tried": [(one.start, one.status.text) for one in plan.tried],
    }
