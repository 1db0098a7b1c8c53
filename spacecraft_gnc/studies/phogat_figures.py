"""Pictures beside figure 4 of Phogat et al., and the range of its section 6."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, frame, legend, limit
from spacecraft_gnc.studies.phogat_study import (
    ANGLES,
    AXES,
    Study,
    attitude_co_state,
    holding_torque,
    kept,
)
from spacecraft_gnc.studies.phogat_transfers import MAX_MOMENTUM, MAX_TORQUE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.ocp.transfer import TransferSolution
    from spacecraft_gnc.types import Array

_HELD: Final[dict[str, Any]] = {"drawstyle": "steps-post"}
_NAMES: Final = ("x", "y", "z")


def figures(study: Study) -> Iterator[tuple[str, Figure]]:
    """Yield name and figure."""
    yield "phogat_figure4", figure_4(study.figure_4)
    yield "phogat_range", shortest_times(study)


def figure_4(plan: TransferSolution) -> Figure:
    """Figure 4: control, momentum and co-states with their bounds, and the multipliers."""
    h = plan.problem.body.time_step
    times: Array = h * np.arange(plan.problem.n_steps + 1, dtype=np.float64)
    with style.applied():
        figure = Figure((11.0, 10.2), layout="constrained")
        panels = figure.subplots(3, 2)
        _lines(panels[0, 0], times, _last_held(plan.torque), "Control", "$u$ [N m]", **_HELD)
        _bounds(panels[0, 0], MAX_TORQUE, "bound")
        _lines(panels[0, 1], times, plan.momentum, "Momentum", r"$\Pi$ [N m s]")
        _bounds(panels[0, 1], MAX_MOMENTUM, "bound")
        _lines(
            panels[1, 0], times, _last_held(-plan.co_momentum),
            "Co-state of the momentum", r"$-\gamma$ [N m]", **_HELD,
        )  # fmt: skip
        _bounds(panels[1, 0], MAX_TORQUE, "bound of the control")
        co_state = attitude_co_state(plan)
        _lines(
            panels[1, 1], times, _last_held(co_state), "Co-state of the attitude",
            r"$\zeta$ [kg m² N m]", **_HELD,
        )  # fmt: skip
        _multipliers(panels[2, 0], times, plan)
        _kept_momentum(panels[2, 1], times, plan)
        legend(panels[0, 0], 4)
        figure.suptitle(
            r"90° about (1, 1, 1) in 19 s from $\Pi$ = (30, -10, 10) N m s: "
            f"cost {plan.cost:.2f} N² m²",
            x=0.01,
            ha="left",
        )
        return figure


def _lines(axes: Axes, times: Array, values: Array, title: str, label: str, **options: Any) -> None:
    for i, name in enumerate(_NAMES):
        axes.plot(times, values[:, i], label=name, **component(i), **options)
    frame(axes, times, title, label)


def _last_held(values: Array) -> Array:
    """Return the (N, 3) values of steps with the last one repeated, for the end of the last."""
    return np.vstack([values, values[-1:]])


def _bounds(axes: Axes, bound: float, label: str) -> None:
    limit(axes, bound, label)
    limit(axes, -bound)


def _multipliers(axes: Axes, times: Array, plan: TransferSolution) -> None:
    """Draw the multipliers of the bounds: lines of the control, areas of the momentum."""
    for i, name in enumerate(_NAMES):
        of_control, of_momentum = plan.torque_multipliers[:, i], plan.momentum_multipliers[:, i]
        if of_momentum.any():
            axes.fill_between(
                times, of_momentum, label=f"momentum {name}", color=style.COMPONENT_COLORS[i],
                alpha=0.3, linewidth=0.0, step="mid",
            )  # fmt: skip
        if of_control.any():
            axes.plot(times[:-1], of_control, label=f"control {name}", **component(i))
    frame(axes, times, "Multipliers of the bounds", "control [N m], momentum [N m/s]")
    axes.legend(loc="lower left")


def _kept_momentum(axes: Axes, times: Array, plan: TransferSolution) -> None:
    """Draw the control of an axis while its momentum saturates: the gyroscopic torque."""
    holding = holding_torque(plan)
    steps = np.concatenate([kept(plan, i) for i in range(3)])
    for i, name in enumerate(_NAMES):
        on = kept(plan, i)
        if not on.size:
            continue
        axes.plot(times[on], plan.torque[on, i], label=f"u, {name}", **component(i))
        axes.plot(
            times[on[::5]], holding[on[::5], i], "o", color=style.INK, markersize=3.0,
            label="gyroscopic" if i == 2 else None,
        )  # fmt: skip
    axes.axhline(0.0, color=style.MUTED, linewidth=0.8)
    frame(axes, times[steps.min() : steps.max() + 2], "Control while the momentum saturates", "")
    axes.set_ylabel("$u$ [N m]")
    axes.legend(loc="center right")


def shortest_times(study: Study) -> Figure:
    """Draw the shortest times over the angle, the proven bound, and the cases of the table."""
    with style.applied():
        figure = Figure((11.0, 6.6), layout="constrained")
        panels = figure.subplots(2, 2, sharex=True, sharey=True)
        for axes, axis in zip(panels.flat, AXES, strict=True):
            found = [study.shortest[axis, angle] for angle in ANGLES]
            axes.fill_between(
                ANGLES, [one.proven for one in found], color="#E0E0DC", linewidth=0.0,
                label="proven infeasible",
            )  # fmt: skip
            axes.plot(
                ANGLES, [one.plan.problem.duration for one in found], color=style.INK,
                label="shortest plan",
            )  # fmt: skip
            _cases(axes, study, axis)
            axes.set(title=f"about {axis}", ylim=(0.0, 32.0), xlim=(5.0, 95.0))
        for axes in panels[-1]:
            axes.set_xlabel("angle [deg]")
        for axes in panels[:, 0]:
            axes.set_ylabel("time [s]")
        legend(panels[0, 0], 2)
        return figure


def _cases(axes: Axes, study: Study, axis: str) -> None:
    for solved, marker, label in ((True, "o", "solved"), (False, "x", "not solved")):
        points = np.array([
            (angle, time) for (name, angle, time), case in study.cases.items()
            if name == axis and case.plan.converged == solved
        ])  # fmt: skip
        color = style.PASSED_COLOR if solved else style.FAILED_COLOR
        axes.plot(*points.T, marker, color=color, markersize=4.5, label=label)
