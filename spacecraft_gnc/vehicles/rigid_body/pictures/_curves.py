"""Curves below an animation: error, zone margins and torque of all its flights."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.ticker import MaxNLocator

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import TIME_LABEL, plain_numbers
from spacecraft_gnc.drawing.axes import limit as draw_limit
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.vehicles.rigid_body.pictures._animated_run import AnimatedRun

_TO_COME: Final = 0.22  # opacity of what has not been flown yet
_LEAST_ERROR: Final = 1e-3  # at which the logarithmic scale ends [deg]


@dataclass(frozen=True, slots=True)
class Curve:
    """One quantity of every flight over time."""

    title: str
    runs: Sequence[AnimatedRun]
    values: Sequence[Array]
    """Of each flight, (n,) or (n + 1,)."""
    limits: dict[str, float] = field(default_factory=dict)
    """Values that bound it, by what is written beside them."""
    logarithmic: bool = False
    barred_below: bool = False
    """Values below zero are tinted as barred."""

    def draw_still(self, axes: Axes) -> None:
        """Draw the axes, the limits, and the curves faintly."""
        axes.set_title(self.title, fontsize=9.0)
        axes.set_xlabel(TIME_LABEL, labelpad=1.0)
        axes.set_xlim(0.0, max(run.times[-1] for run in self.runs))
        for run, values in zip(self.runs, self.values, strict=True):
            axes.plot(run.times[: len(values)], values, alpha=_TO_COME, **run.line)
        known = np.concatenate(self.values)
        known = known[known > 0.0]  # NaN neither
        if self.logarithmic and known.size:
            axes.set_yscale("log")
            axes.set_ylim(max(_LEAST_ERROR, 0.5 * known.min()), 2.5 * known.max())
            plain_numbers(axes.yaxis)
        else:
            axes.yaxis.set_major_locator(MaxNLocator(5))
            axes.margins(y=0.08)
        if self.barred_below:
            bottom, top = axes.get_ylim()
            low = min(bottom, -0.2 * top)  # room for the label
            axes.axhspan(low, 0.0, color=style.LIMIT_COLOR, alpha=0.10, linewidth=0.0)
            axes.set_ylim(bottom=low)
        for text, limit in self.limits.items():
            draw_limit(axes, limit)
            axes.annotate(
                text, (1.0, limit), xycoords=("axes fraction", "data"), xytext=(-2, -3),
                textcoords="offset points", ha="right", va="top", fontsize=8.0,
                color=style.LIMIT_COLOR,
            )  # fmt: skip

    def draw_flown(self, axes: Axes, time: float) -> None:
        """Draw the curves up to a time [s], with a dot where they are."""
        for run, values in zip(self.runs, self.values, strict=True):
            last = min(run.row(time), len(values) - 1)
            axes.plot(run.times[: last + 1], values[: last + 1], **run.line)
            axes.plot(run.times[last], values[last], "o", markersize=4.5, color=run.line["color"])


def curves(runs: Sequence[AnimatedRun]) -> Iterator[Curve]:
    """Yield the quantities that the flights have."""
    yield Curve("Error to the target [deg]", runs, [run.error for run in runs], logarithmic=True)
    if all(run.zones for run in runs):
        margins = [run.margins.min(axis=0) for run in runs]
        yield Curve(
            "Angle to the nearest zone [deg]", runs, margins, {"violated": 0.0}, barred_below=True
        )
    unit = style.prefixed("N m", *(run.torque for run in runs))
    limits = {run.limit * unit.factor for run in runs if run.limit}
    torques = [unit.factor * run.torque for run in runs]
    yield Curve(
        f"Torque [{unit.label}]",
        runs,
        torques,
        {f"limit {limit:g} {unit.label}": limit for limit in sorted(limits)},
    )
