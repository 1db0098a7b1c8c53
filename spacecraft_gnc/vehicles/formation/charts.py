"""Diagrams of the report of flights in formation."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.bands import band
from spacecraft_gnc.drawing.chart import (
    HELD,
    Chart,
    components,
    one_curve_each,
    over_time,
    span,
    times_of,
)
from spacecraft_gnc.drawing.sources import Stretch
from spacecraft_gnc.drawing.traces import DASHES, Curve, Trace, axis, limit, log_axis, trace
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation import flown as series
from spacecraft_gnc.vehicles.formation.decision import Answer
from spacecraft_gnc.vehicles.formation.events import (
    STANDING_COLORS,
    standing,
    standing_name,
    stretches,
)
from spacecraft_gnc.vehicles.formation.flight import FormationFlight
from spacecraft_gnc.vehicles.formation.flown import KM, Flown
from spacecraft_gnc.vehicles.formation.limits import all_separations, communication_angles
from spacecraft_gnc.vehicles.formation.path_chart import path_chart
from spacecraft_gnc.vehicles.formation.summary import answer_name

_MOST_ROWS: Final = 4  # craft that have a row of their own where runs are compared
_ANSWER_COLORS: Final = {
    Answer.OPTIMAL: style.AXIS_COLORS[2],
    Answer.HELD: style.LIMIT_COLOR,
    Answer.LONGEST_KEPT: style.AXIS_COLORS[1],
    Answer.LEAST_VIOLATING: style.RUN_COLORS[3],
    Answer.PASSAGE: style.RUN_COLORS[4],
    Answer.PASSED: style.RUN_COLORS[5],
}


def _no_bound(_: Flown) -> float:
    return 0.0


class _Quantity(NamedTuple):
    """What several craft or pairs have each."""

    name: str
    title: str
    word: str
    """In short, beside the axis."""
    unit: str
    note: str
    values: Callable[[Flown], Array]
    """(n, k) or (n + 1, k)."""
    names: Callable[[Flown], Sequence[str]]
    color: Callable[[int], str]
    of_run: Callable[[Flown], Array] | None = None
    """(n,) or (n + 1,) for runs over each other; None: the largest of each row."""
    of_runs: str = ""
    """What that is; empty: ``title``."""
    bound: Callable[[Flown], float] = _no_bound
    """0: none."""
    bound_text: str = "limit"
    scale: Callable[[str], dict[str, Any]] = axis
    line: Mapping[str, Any] = MappingProxyType({})


def charts_of(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    """Yield the diagrams of flights; a run may spend so many points on a curve."""
    yield path_chart(runs, points)
    for quantity in _QUANTITIES:
        yield _chart(runs, points, quantity)
    if any(series.governor_chose(run.trajectory) for run in runs):
        if _is_comparable(runs):
            yield _shifts(runs, points)
        yield _cost(runs, points)
        yield from _governor(runs, points)
    yield _band(runs, "standing", "Standing", standing, standing_name, STANDING_COLORS)
    if any((run.trajectory.status != run.trajectory.status[0]).any() for run in runs):
        yield _band(
            runs, "answer", "Governor's answer", lambda f: f.status, answer_name, _ANSWER_COLORS
        )


_QUANTITIES: Final = (
    _Quantity(
        "separation", "Separation", "separation", "km", "Of each pair, at the control steps.",
        lambda run: KM * all_separations(run.trajectory), series.pair_names, series.pair_color,
        of_run=lambda run: KM * series.nearest(run.trajectory), of_runs="Least separation",
        bound=lambda run: KM * series.limit_of(run.scenario, "min_separation"),
        bound_text="at least",
    ),
    _Quantity(
        "delta_v", "Size of delta-v", "delta-v", "m/s",
        "Commanded at the start of each control step; of a lost craft none is drawn.",
        lambda run: series.delta_v(run.trajectory), series.craft_names, series.craft_color,
        of_runs="Largest delta-v of a craft",
        bound=lambda run: series.limit_of(run.scenario, "max_delta_v"), line=HELD,
    ),
    _Quantity(
        "angle", "Communication angle", "angle", "deg",
        "Of each pair, between where the other craft is and where it is to be; of a lost craft "
        "none is drawn.",
        lambda run: communication_angles(run.trajectory), series.pair_names, series.pair_color,
        of_runs="Largest communication angle",
        bound=lambda run: series.angle_limit(run.scenario),
    ),
    _Quantity(
        "error", "Distance from the commanded place", "distance", "m",
        "Of each craft from the point of the natural ellipse that it is to track.",
        series.errors, series.craft_names, series.craft_color,
        of_run=series.farthest, of_runs="Distance of the farthest craft from its place",
        scale=log_axis,
    ),
    _Quantity(
        "spent", "Delta-v spent", "delta-v", "m/s", "Sum of the sizes since the start.",
        series.spent, series.craft_names, series.craft_color,
        of_run=lambda run: np.asarray(series.spent(run).sum(axis=1)),
        of_runs="Delta-v spent by all craft",
    ),
)  # fmt: skip


def _chart(runs: Sequence[Flown], points: int, what: _Quantity) -> Chart:
    """Return the diagram of a quantity: one curve of each craft or pair, or the worst of a run."""
    title = what.title if len(runs) == 1 else what.of_runs or what.title
    if len(runs) == 1:
        traces = list(_curves(runs[0], points, what))
    else:
        traces = list(
            one_curve_each(
                runs, points, what.of_run or (lambda run: series.widest(what.values(run))), title,
                **what.line,
            )
        )  # fmt: skip
    traces += [
        limit(span(runs), (side, side), f"{what.bound_text} {side:g} {what.unit}")
        for side in sorted({what.bound(run) for run in runs} - {0.0})
    ]
    drawn = over_time(runs, traces, what.scale(f"{what.word} [{what.unit}]"))
    if what.bound_text == "at least" and what.scale is axis:
        drawn["layout"]["yaxis"]["rangemode"] = "tozero"
    scale = "yaxis" if what.scale is log_axis else ""
    return Chart(what.name, title, what.note, drawn, scale=scale)


def _curves(run: Flown, points: int, what: _Quantity) -> Iterator[Trace]:
    values = what.values(run)
    for i, name in enumerate(what.names(run)):
        line = {"color": what.color(i), "dash": DASHES[i % len(DASHES)], "width": 1.7, **what.line}
        yield trace(Curve(times_of(run, values), values[:, i], name, line), points)


def _shifts(runs: Sequence[Flown], points: int) -> Chart:
    """Return the time shifts of one run, or of runs of the same craft: a row for each craft."""
    title, note = "Time shift", "Along the natural ellipse; all are equal in the desired formation."
    if len(runs) == 1:
        what = _Quantity(
            "shifts", title, "shift", "control steps", note,
            lambda run: series.shifts(run.trajectory), series.craft_names, series.craft_color,
            line=HELD,
        )  # fmt: skip
        return _chart(runs, points, what)
    drawn = components(
        runs, points, lambda run: series.shifts(run.trajectory), series.craft_names(runs[0]),
        "shift", style.Unit("steps", 1.0), **HELD,
    )  # fmt: skip
    return Chart("shifts", title, note, drawn, tall=True)


def _is_comparable(runs: Sequence[Flown]) -> bool:
    """Tell whether the craft of the runs are the same ones, and few enough for a row each."""
    names = {series.craft_names(run) for run in runs}
    return len(runs) == 1 or (len(names) == 1 and len(next(iter(names))) <= _MOST_ROWS)


def _cost(runs: Sequence[Flown], points: int) -> Chart:
    """Return what the chosen shifts cost: W and Omega of one run, the whole cost of several."""
    note = "Logarithmic: W is not drawn where it is 0, as all shifts are equal."
    what = _Quantity(
        "cost", "Cost of the shifts chosen", "cost", "-", note,
        lambda run: np.column_stack([run.trajectory.shift_cost, run.trajectory.state_cost]),
        lambda _: ("W, of the shifts", "Omega, of errors and delta-v"),
        lambda i: (style.AXIS_COLORS[1], style.INK)[i],
        of_run=lambda run: run.trajectory.cost, scale=log_axis, line=HELD,
    )  # fmt: skip
    return _chart(runs, points, what)


def _governor(runs: Sequence[Flown], points: int) -> Iterator[Chart]:
    for name, title, word, unit, note, values, scale in (
        (
            "admissible", "Admissible candidates", "candidates", "-",
            "Shifts that keep every constraint.",
            series.admissible, log_axis,
        ),
        (
            "margin", "Least room along the prediction", "room", "% of the limit",
            "Of the constraint with the least; below zero: broken.",
            series.room_percent, axis,
        ),
        (
            "solve_time", "Time of the governor", "time", "ms", "Wall time of each decision.",
            lambda f: 1e3 * f.solve_time, log_axis,
        ),
    ):  # fmt: skip
        yield _chart(runs, points, _single(name, title, word, unit, note, values, scale))


def _single(
    name: str,
    title: str,
    word: str,
    unit: str,
    note: str,
    values: Callable[[FormationFlight], Array],
    scale: Callable[[str], dict[str, Any]],
) -> _Quantity:
    """Return a quantity that the governor has once."""
    return _Quantity(
        name, title, word, unit, note, lambda run: values(run.trajectory)[:, None],
        lambda _: (title,), lambda _: style.INK, scale=scale,
    )  # fmt: skip


def _band(
    runs: Sequence[Flown],
    name: str,
    title: str,
    values: Callable[[FormationFlight], NDArray[Any]],
    name_of: Callable[[int], str],
    colors: dict[Any, str],
) -> Chart:
    """Return the band of the states of each run over time."""

    def stretches_of(run: Flown) -> list[Stretch]:
        return list(stretches(values(run.trajectory), run.times))

    drawn = band(runs, stretches_of, name_of, lambda state: colors.get(state, style.MUTED))
    return Chart(name, title, "", drawn, wide=True)
