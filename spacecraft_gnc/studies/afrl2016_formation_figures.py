"""Pictures beside Fig. 9 of Kolmanovsky et al. 2016: three spacecraft form up."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, legend, limit
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.limits import all_separations, communication_angles
from spacecraft_gnc.vehicles.formation.metrics import delta_v_norms

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.studies.afrl2016_formation_study import Case, Deadlock, Formed

_STEPS: Final = "control step"
_SHOWN: Final = 100  # steps of Fig. 9
_KM: Final = 1e-3
_TITLES: Final = ("Constraints with TSG inactive", "Constraints with TSG active")
_LABELS: Final = ("delta-v [m/s]", "separation [km]", "angle [deg]")


def figures(
    governed: Case,
    ungoverned: Case,
    deadlocks: Sequence[Deadlock],
    loss: Case,
    motions: Mapping[str, Case],
    campaign: Formed | None,
) -> Iterator[tuple[str, Figure]]:
    """Yield name and figure."""
    yield "afrl2016_formation", formation_figure(governed, ungoverned)
    yield "afrl2016_formation_deadlock", deadlock_figure(deadlocks[0])
    yield "afrl2016_formation_loss", loss_figure(loss)
    yield "afrl2016_formation_nonlinear", motions_figure(motions)
    if campaign is not None:
        yield "afrl2016_formation_campaign", campaign_figure(campaign)


def formation_figure(governed: Case, ungoverned: Case) -> Figure:
    """Fig. 9: constraints inactive and active, shifts and W, trajectories."""
    with style.applied():
        figure = Figure((11.6, 9.4), layout="constrained")
        top, bottom = _halves(figure, (1.25, 1.0))
        panels = top.subplots(3, 2, sharex=True, sharey="row")
        cases = zip(_TITLES, (ungoverned, governed), strict=True)
        for column, (title, case) in enumerate(cases):
            _constraints(panels[:, column], case)
            panels[0, column].set(title=title, xlim=(0, _SHOWN))
            panels[-1, column].set_xlabel(_STEPS)
        _label(panels[:, 0])
        for i, names in ((0, _craft(governed)), (1, _pair_names(governed))):
            _name_lines(panels[i, 1], names)
        left, right = bottom.subfigures(1, 2)
        _shifts(left.subplots(2, 1, sharex=True), governed)
        _trajectories(right.subplots(1, 1), governed)
        _title(figure, "time shift governor (TSG); dashed: limits")
        return figure


def _halves(figure: Figure, ratios: tuple[float, float]) -> Any:
    """Return the upper and the lower part of a figure."""
    return figure.subfigures(2, 1, height_ratios=ratios)


def _craft(case: Case) -> tuple[str, ...]:
    return tuple(case.flown.scenario.plant.spacecraft)


def _pair_names(case: Case) -> list[str]:
    return [f"{a}-{b}" for a, b in combinations(_craft(case), 2)]


def _constraints(panels: Any, case: Case) -> None:
    """Draw delta-v by craft, separation and angle by pair, with their limits."""
    flight, p = case.flight, case.flown.scenario.plant
    norms = np.where(flight.healthy, delta_v_norms(flight.delta_v, flight.healthy), np.nan)
    rows = (
        (norms, p.max_delta_v),
        (all_separations(flight) * _KM, p.min_separation * _KM),
        (communication_angles(flight), p.max_communication_angle_deg),
    )
    for axes, (values, bound) in zip(panels, rows, strict=True):
        for i in range(values.shape[1]):
            axes.plot(values[:, i], drawstyle="steps-post" if axes is panels[0] else "default",
                      **component(i))  # fmt: skip
        limit(axes, bound)
        axes.set_xlim(0, flight.n_steps)


def _label(panels: Any) -> None:
    for axes, label in zip(
        panels, ("delta-v [m/s]", "separation [km]", "angle [deg]"), strict=True
    ):
        axes.set_ylabel(label)


def _name_lines(axes: Axes, names: Sequence[str]) -> None:
    for line, name in zip(axes.get_lines(), names, strict=False):
        line.set_label(name)
    legend(axes, len(names))


def _shifts(panels: Any, case: Case) -> None:
    """Draw the shift of each craft, and W."""
    flight = case.flight
    for i, name in enumerate(_craft(case)):
        panels[0].plot(flight.time_shift[:, i], drawstyle="steps-post", label=name, **component(i))
    panels[0].set(title="Parameters and W", ylabel="shift [control steps]")
    legend(panels[0], 3)
    panels[1].plot(flight.shift_cost, color=style.INK, drawstyle="steps-post")
    panels[1].set(ylabel="W", xlabel=_STEPS, xlim=(0, _SHOWN))


def _trajectories(axes: Axes, case: Case) -> None:
    """Draw where the craft fly in the orbital plane; rings: start, dots: end."""
    flight = case.flight
    positions = np.concatenate([flight.position, flight.final_position[None]]) * _KM
    for i, name in enumerate(_craft(case)):
        x, y, _ = positions[:, i].T
        axes.plot(y, x, label=name, linewidth=1.1, **component(i))
        color = component(i)["color"]
        axes.plot(y[0], x[0], "o", markerfacecolor="none", color=color)
        axes.plot(y[-1], x[-1], "o", color=color)
    axes.set(title="Trajectories", xlabel="along track [km]", ylabel="radial [km]")
    axes.set_aspect("equal", adjustable="box")


# --- ours ----------------------------------------------------------------------------------


def deadlock_figure(deadlock: Deadlock) -> Figure:
    """Draw a stored start: shifts, W, separation and angle, not resolved and resolved."""
    with style.applied():
        figure = Figure((11.0, 7.2), layout="constrained")
        panels = figure.subplots(4, 2, sharex=True, sharey="row")
        for column, (title, case) in enumerate(
            (("Not resolved", deadlock.unresolved), ("Resolved", deadlock.resolved))
        ):
            flight, p = case.flight, case.flown.scenario.plant
            rows: tuple[tuple[Array, float | None], ...] = (
                (flight.time_shift, None),
                (flight.shift_cost[:, None], None),
                (all_separations(flight) * _KM, p.min_separation * _KM),
                (communication_angles(flight), p.max_communication_angle_deg),
            )
            for axes, (values, bound) in zip(panels[:, column], rows, strict=True):
                for i in range(values.shape[1]):
                    axes.plot(values[:, i], drawstyle="steps-post" if bound is None else "default",
                              **component(i))  # fmt: skip
                if bound is not None:
                    limit(axes, bound)
                _shade(axes, flight.deadlocked)
            panels[0, column].set_title(title)
            panels[-1, column].set(xlabel=_STEPS, xlim=(0, flight.n_steps))
        labels = ("shift [steps]", "W", "separation [km]", "angle [deg]")
        for axes, label in zip(panels[:, 0], labels, strict=True):
            axes.set_ylabel(label)
        _name_lines(panels[0, 1], _craft(deadlock.resolved))
        _name_lines(panels[2, 1], _pair_names(deadlock.resolved))
        _title(figure, "a start that deadlocks; shaded: from when it is noticed until it is left")
        return figure


def _shade(axes: Axes, flags: Array) -> None:
    """Shade the steps at which flags (n,) are true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    for begin, end in edges.reshape(-1, 2):
        axes.axvspan(begin, end, color=style.MUTED, alpha=0.2, linewidth=0.0)


def loss_figure(case: Case) -> Figure:
    """Draw the loss of a craft: constraints, and where the craft fly."""
    flight = case.flight
    with style.applied():
        figure = Figure((8.4, 8.6), layout="constrained")
        top, bottom = _halves(figure, (2.3, 1.0))
        panels = top.subplots(3, 1, sharex=True)
        _constraints(panels, case)
        _label(panels)
        panels[-1].set_xlabel(_STEPS)
        _name_lines(panels[0], _craft(case))
        _name_lines(panels[1], _pair_names(case))
        lost = np.flatnonzero(~flight.healthy.all(axis=1))
        noticed = np.flatnonzero(flight.lost.any(axis=1))
        for axes in panels:
            for steps, color, line in ((lost, style.LIMIT_COLOR, "-"), (noticed, style.MUTED, ":")):
                if steps.size:
                    axes.axvline(steps[0], color=color, linewidth=1.0, linestyle=line)
        _trajectories(bottom.subplots(1, 1), case)
        name = case.flown.scenario.plant.spacecraft_lost
        _title(figure, f"{name} lost (red), noticed (dotted)")
        return figure


def motions_figure(motions: Mapping[str, Case]) -> Figure:
    """Motion of which the laws do not know: position errors, and distance from Hill's flight."""
    with style.applied():
        figure = Figure((8.4, 6.4), layout="constrained")
        panels = figure.subplots(2, 1, sharex=True)
        base = motions["hill"].flight.position
        for j, (name, case) in enumerate(motions.items()):
            flight, look = case.flight, component(j)
            away = np.linalg.norm(flight.position - flight.reference_position, axis=2).max(axis=1)
            panels[0].plot(away, label=name, **look)
            apart = np.linalg.norm(flight.position - base, axis=2).max(axis=1)
            if name != "hill":
                panels[1].plot(apart, label=name, **look)
        limit(panels[0], motions["hill"].flown.scenario.governor.formed_error)
        panels[0].set(title="Largest position error", ylabel="[m]", yscale="log")
        panels[1].set(title="Largest distance from the flight by Hill's equations", ylabel="[m]",
                      xlabel=_STEPS)  # fmt: skip
        legend(panels[0], 3)
        _title(figure, "motion of which laws and governor do not know")
        return figure


def campaign_figure(found: Formed) -> Figure:
    """Random starts: when each is formed, and what delta-v it takes."""
    with style.applied():
        figure = Figure((11.4, 4.0), layout="constrained")
        left, middle, right = figure.subplots(1, 3)
        flown, parked = found.flown, found.flown & (found.deadlocks > 0.0)
        formed, bins = found.formed_at, 30
        groups = [formed[flown & ~parked], formed[parked]]
        labels = ["without a deadlock", "deadlock, resolved"]
        colors = [style.RUN_COLORS[0], style.RUN_COLORS[1]]
        left.hist([g[np.isfinite(g)] for g in groups], bins=bins, stacked=True, color=colors,
                  label=labels)  # fmt: skip
        left.set(title="Time to form", xlabel="formed for good from step", ylabel="starts")
        left.legend(loc="upper right", fontsize=9)
        for axes, values, title in (
            (middle, found.max_delta_v, "Largest delta-v"),
            (right, found.total_delta_v, "Delta-v of all craft"),
        ):
            axes.hist([values[flown & ~parked], values[parked]], bins=bins, stacked=True,
                      color=colors)  # fmt: skip
            axes.set(title=title, xlabel="[m/s]", ylabel="starts")
        for axes in (left, middle, right):
            axes.yaxis.get_major_locator().set_params(integer=True)
        n, passed = int(flown.sum()), int(found.passed.sum())
        _title(figure, f"{passed} of {n} feasible random starts form up within the limits")
        return figure


def _title(figure: Figure, what: str) -> None:
    figure.suptitle(f"Formation (AFRL 2016): {what}", fontsize=12, fontweight="bold")
