"""Diagram of the report, and the two common kinds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.traces import (
    Curve,
    Trace,
    axis,
    component_line,
    figure,
    run_line,
    trace,
)
from spacecraft_gnc.types import Array


class Drawn(Protocol):
    """A run, as far as a diagram has to know it."""

    @property
    def name(self) -> str:
        """How the page calls it."""

    @property
    def times(self) -> Array:
        """(n + 1,) of its states [s]."""


R = TypeVar("R", bound=Drawn)
N = TypeVar("N", bound=np.generic)
HELD: Final[dict[str, Any]] = {"shape": "hv"}
"""Line of a value that holds for a control period."""
_SECONDS: Final = ".10~g"  # digits, not powers: a flight of hours is read in seconds too


@dataclass(frozen=True, slots=True)
class Variant:
    """One of several forms of a diagram that the reader chooses from."""

    name: str
    label: str
    note: str
    figure: dict[str, Any]


@dataclass(frozen=True, slots=True)
class Chart:
    """A diagram.

    Attributes
    ----------
    name
        Identifier in the page.
    title, note
        Heading, and the line below it: what is drawn and how.
    figure
        As `traces.figure` gives it; empty where `variants` has some.
    variants
        To choose from, the first one is shown.
    scale
        Name of the y axis that may be switched between log and linear; empty: none.
    wide, tall
        Whether it takes the whole width of the page, or is as high as two others.
    """

    name: str
    title: str
    note: str = ""
    figure: dict[str, Any] = field(default_factory=dict)
    variants: tuple[Variant, ...] = ()
    scale: str = ""
    wide: bool = False
    tall: bool = False

    def data(self) -> dict[str, Any]:
        """Return what the script of the page needs."""
        variants = [{"name": v.name, "note": v.note, "figure": v.figure} for v in self.variants]
        return {
            "name": self.name,
            "figure": self.figure or self.variants[0].figure,
            "variants": variants,
            "scale": self.scale,
        }


def times_of(run: Drawn, values: Array) -> Array:
    """Return the times [s] of values of the steps (n) or of the states (n + 1)."""
    return run.times[: len(values)]


def span(runs: Sequence[Drawn]) -> tuple[float, float]:
    """Return first and last time of all runs [s]."""
    return min(float(r.times[0]) for r in runs), max(float(r.times[-1]) for r in runs)


def over_time(
    runs: Sequence[Drawn], traces: Iterable[Trace], *y: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the figure of diagrams over the time of all runs, one for each axis ``y``."""
    drawn = figure(traces, y, axis("time [s]", range=span(runs), tickformat=_SECONDS))
    if len(runs) > 1:
        drawn["layout"]["showlegend"] = True  # one curve alone needs its run's name too
    return drawn


def named(runs: Sequence[Drawn], run: Drawn, text: str) -> str:
    """Return a label, with the name of its run where there are several."""
    return text if len(runs) == 1 else f"{run.name}: {text}"


def held(values: NDArray[N]) -> NDArray[N]:
    """Return (n + 1,) values: the last one once more at the end of its control period."""
    return np.concatenate([values, values[-1:]])


def one_curve_each(
    runs: Sequence[R], points: int, values: Callable[[R], Array], name: str, **line: Any
) -> Iterator[Trace]:
    """Yield one curve of each run that knows the values.

    Parameters
    ----------
    name
        Label where there is only one run; else the run's name.
    """
    for i, run in enumerate(runs):
        data = values(run)
        if np.isfinite(data).any():
            text = name if len(runs) == 1 else run.name
            curve = Curve(times_of(run, data), data, text, {**run_line(i), **line})
            yield trace(curve, points)


def components(
    runs: Sequence[R],
    points: int,
    values: Callable[[R], Array],
    names: Sequence[str],
    quantity: str,
    unit: style.Unit,
    beneath: Iterable[Trace] = (),
    **line: Any,
) -> dict[str, Any]:
    """Return the figure of a vector: one diagram for one run, else one row for each component.

    ``beneath`` the curves lie these traces.
    """
    several = len(runs) > 1
    traces = list(beneath)
    for i, run in enumerate(runs):
        data = unit.factor * values(run)
        for j, name in enumerate(names):
            drawn = run_line(i) if several else component_line(j)
            options = {"legendgroup": run.name, "showlegend": j == 0} if several else {}
            curve = Curve(
                times_of(run, data),
                data[:, j],
                run.name if several else name,
                {**drawn, **line},
                row=j if several else 0,
                options=options,
            )
            traces.append(trace(curve, points))
    if several:
        return over_time(runs, traces, *(axis(f"{name} [{unit.label}]") for name in names))
    return over_time(runs, traces, axis(f"{quantity} [{unit.label}]"))
