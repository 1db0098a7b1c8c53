"""Figures of plans for print: torque, momentum and co-states by component, with their bounds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from spacecraft_gnc.drawing import representations as forms
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, frame, legend
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.drawing.figures import DOUBLE, Maker, stacked
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.planner.plan import AXES, Plan
from spacecraft_gnc.vehicles.rigid_body.planner.report import Planned, scaled_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_TRIPLE: Final = (6.3, 6.0)  # [inch]
_OVERVIEW: Final = (11.0, 7.4)
_BOUND: Final[dict[str, Any]] = {"color": style.LIMIT_COLOR, "linewidth": 1.1, "linestyle": "--"}
_ACTING: Final[dict[str, Any]] = {"color": style.LIMIT_COLOR, "linewidth": 6.0, "alpha": 0.3}
_SATURATION: Final[dict[str, Any]] = {"color": style.INK, "linewidth": 1.1, "linestyle": ":"}


class _Vector(NamedTuple):
    """A vector of a plan over time."""

    title: str
    symbol: str
    unit: str
    values: Callable[[Plan], Array]
    """(N, 3), each held for a control period, or (N+1, 3)."""
    bounds: Callable[[Plan], Array] = lambda _: np.empty((0, 3))
    """Its lower and upper ones."""
    saturation: Callable[[Plan], Array] = lambda _: np.empty((0, 3))
    """Values beyond which the torque is at a bound."""


_VECTORS: Final = {
    "torque": _Vector(
        "Torque", "u", "N m", lambda plan: plan.solution.torque,
        bounds=lambda plan: plan.torque_bounds,
    ),
    "momentum": _Vector(
        "Angular momentum", r"\Pi", "N m s", lambda plan: plan.solution.momentum,
        bounds=lambda plan: plan.momentum_bounds,
    ),
    "co_momentum": _Vector(
        "Co-momentum", r"\gamma", "N m", lambda plan: plan.solution.co_momentum,
        saturation=lambda plan: plan.saturation,
    ),
    "attitude_co_state": _Vector(
        "Co-state of the attitude", r"\zeta", "kg m² N m", lambda plan: plan.attitude_co_states
    ),
    "torque_multipliers": _Vector(
        "Multipliers of the torque bounds", r"\alpha u", "N m",
        lambda plan: plan.solution.torque_multipliers,
    ),
    "momentum_multipliers": _Vector(
        "Multipliers of the momentum bounds", r"\beta\Pi", "N m/s",
        lambda plan: plan.solution.momentum_multipliers,
    ),
}  # fmt: skip
_OF_OVERVIEW: Final = ("torque", "momentum", "co_momentum")


class PlanFigures:
    """Implements `drawing.vehicle.VehicleFigures` for plans."""

    def flight(
        self, run: Planned, *, title: str = "", error_scale: str = "log"
    ) -> dict[str, Maker]:
        """Return what draws each figure of one plan, by name."""
        overview = {"overview": lambda: _overview([run], title)}
        attitude = {"attitude": lambda: stacked(DOUBLE, *_attitude(run))}
        return overview | _vectors([run]) | attitude

    def comparison(self, runs: Sequence[Planned], *, error_scale: str = "log") -> dict[str, Maker]:
        """Return what draws the figures of several plans over each other, by name."""
        return {"overview": lambda: _overview(runs, "")} | _vectors(runs)

    def animate(self, runs: Sequence[Planned], path: Path, *, title: str = "") -> None:
        """Refuse a moving picture."""
        raise ParameterError(
            f"--animate: received {runs[0].name}, a plan; required a flight; fly it: gnc simulate "
            "SCENARIO.yaml --out FILE.npz"
        )


def _vectors(runs: Sequence[Planned]) -> dict[str, Maker]:
    def maker(vector: _Vector) -> Maker:
        return lambda: _components(runs, vector)

    return {name: maker(vector) for name, vector in _VECTORS.items()}


def _components(runs: Sequence[Planned], vector: _Vector) -> Figure:
    """Return a figure of a vector, a diagram for each component."""
    figure = stacked(_TRIPLE, *(_panel(runs, vector, j) for j in range(3)))
    with style.applied():
        _legend(figure, runs, [vector])
    return figure


def _legend(figure: Figure, runs: Sequence[Planned], vectors: Sequence[_Vector]) -> None:
    """Tell below the figure the plans apart, and what its dashed and dotted lines and bands are."""
    told: list[tuple[str, dict[str, Any]]] = []
    if len(runs) > 1:
        told = [(run.name, {"color": _color(i)}) for i, run in enumerate(runs)]
    plans = [run.trajectory for run in runs]
    if any(np.isfinite(vector.bounds(plan)).any() for plan in plans for vector in vectors):
        told.append(("bound", _BOUND))
    acting = [_VECTORS[one.quantity] for plan in plans for one in plan.solution.active]
    if any(vector in acting for vector in vectors):
        told.append(("while it acts", _ACTING))
    if any(np.isfinite(vector.saturation(plan)).any() for plan in plans for vector in vectors):
        told.append((r"no bound: beyond it the torque, $-\gamma$, saturates", _SATURATION))
    if told:
        lines = [Line2D([], [], label=name, **look) for name, look in told]
        figure.legend(
            handles=lines, loc="outside lower center", ncols=min(len(lines), 3), handlelength=2.4
        )


def _overview(runs: Sequence[Planned], title: str) -> Figure:
    """Return torque, momentum and co-momentum beside each other, a row for each component."""
    with style.applied():
        figure = Figure(_OVERVIEW, layout="constrained")
        grid = figure.subplots(3, len(_OF_OVERVIEW), sharex=True)
        for i, name in enumerate(_OF_OVERVIEW):
            for j in range(3):
                _panel(runs, _VECTORS[name], j)(grid[j, i])
                if j < 2:
                    grid[j, i].set_xlabel("")
        if title:
            figure.suptitle(title, fontsize=12, fontweight="bold")
        _legend(figure, runs, [_VECTORS[name] for name in _OF_OVERVIEW])
    return figure


def _panel(runs: Sequence[Planned], vector: _Vector, j: int) -> Callable[[Axes], None]:
    """Return what draws a component of every plan, with its bounds."""

    def draw(axes: Axes) -> None:
        every = [vector.values(run.trajectory) for run in runs]
        bounds = [vector.bounds(run.trajectory)[:, j] for run in runs]
        saturation = [vector.saturation(run.trajectory)[:, j] for run in runs]
        unit = scaled_unit(vector.unit, *every, *bounds, *saturation)
        for i, (run, values) in enumerate(zip(runs, every, strict=True)):
            color = style.COMPONENT_COLORS[j] if len(runs) == 1 else _color(i)
            scaled = unit.factor * values[:, j]
            if len(values) == run.trajectory.n_steps:
                axes.step(run.times, held(scaled), where="post", color=color)
            else:
                axes.plot(run.times, scaled, color=color)
        for pairs, look in ((bounds, _BOUND), (saturation, _SATURATION)):
            for value in sorted({float(v) for pair in pairs for v in pair if np.isfinite(v)}):
                axes.axhline(unit.factor * value, **look)
        for run in runs:
            _mark_active(axes, run, vector, j, unit.factor)
        longest = max(runs, key=lambda run: float(run.times[-1]))
        title = f"{vector.title}, body frame" if j == 0 else ""
        frame(axes, longest.times, title, f"${vector.symbol}_{AXES[j]}$ [{unit.label}]")

    return draw


def _mark_active(axes: Axes, run: Planned, vector: _Vector, j: int, factor: float) -> None:
    """Draw a band over each bound of the vector while it acts."""
    for one in run.trajectory.solution.active:
        if vector is _VECTORS[one.quantity] and one.axis == j:
            last = one.last + (one.quantity == "torque")  # held over its last step
            axes.hlines(
                factor * one.bound, run.times[one.first], run.times[last], **_ACTING
            )  # fmt: skip


def _color(i: int) -> str:
    return style.RUN_COLORS[i % len(style.RUN_COLORS)]


def _attitude(run: Planned) -> tuple[Callable[[Axes], None], ...]:
    plan, times = run.trajectory, run.times

    def quaternion(axes: Axes) -> None:
        values = forms.quaternions_xyzw(plan.solution.attitude)
        for i, name in enumerate(forms.QUATERNION.components):
            axes.plot(times, values[:, i], label=name, **component(i))
        frame(axes, times, "Attitude", "quaternion [-]")
        legend(axes, 4)

    def error(axes: Axes) -> None:
        axes.plot(times, plan.error_deg, color=style.INK)
        frame(axes, times, "Angle to the goal", "angle [deg]")
        axes.set_ylim(bottom=0.0)

    return quaternion, error
