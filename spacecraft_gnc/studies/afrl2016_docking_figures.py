"""Pictures beside Figs. 6 to 8 of Kolmanovsky et al. 2016: docking with a rotating chief."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from spacecraft_gnc import lie
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, frame, legend, limit
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.studies.afrl2016_docking_study import Case, Docked, Start

SNAPSHOTS: Final = (0.0, 150.0, 300.0, 450.0, 600.0, 750.0)  # of Fig. 6 [s]
_AXES: Final = "xyz"
_CHIEF, _DEPUTY = style.AXIS_COLORS[0], style.AXIS_COLORS[1]
_CORNERS: Final = np.array(list(product((-0.5, 0.5), repeat=3)))
_FACES: Final = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))


def figures(
    shown: Case,
    governed: Mapping[Start, Case],
    ungoverned: Mapping[Start, Case],
    tilted: Mapping[str, Case],
    failed: Case,
    campaign: Docked | None,
) -> Iterator[tuple[str, Figure]]:
    """Yield name and figure."""
    yield "afrl2016_docking_snapshots", snapshots_figure(shown)
    yield "afrl2016_docking_controls", controls_figure(shown)
    yield "afrl2016_docking_references", references_figure(shown)
    yield "afrl2016_docking_constraints", constraints_figure(governed, ungoverned)
    yield "afrl2016_docking_tilted", tilted_figure(tilted)
    yield "afrl2016_docking_thruster_failed", failed_figure(failed)
    if campaign is not None:
        yield "afrl2016_docking_campaign", campaign_figure(campaign)


def states(flight: Any, name: str) -> Array:
    """Return a quantity of the states (n + 1, ...), the last one included."""
    values = getattr(flight, name)
    return np.concatenate([values, np.asarray(getattr(flight, f"final_{name}"))[None]])


def state_times(flight: Any) -> Array:
    """Return the times (n + 1,) of the states [s]."""
    return np.append(flight.time, flight.time[-1] + flight.period)


# --- Fig. 6 --------------------------------------------------------------------------------


def snapshots_figure(case: Case) -> Figure:
    """Fig. 6: both bodies in Hill's frame, every 150 s."""
    times, pictured = state_times(case.flight), []
    for at in SNAPSHOTS:
        k = round(at / case.flight.period)
        if k < len(times):
            pictured.append(k)
    with style.applied():
        engine = ConstrainedLayoutEngine(wspace=0.12, hspace=0.08)
        figure = Figure((10.8, 8.0), layout=engine)
        for i, k in enumerate(pictured):
            axes: Any = figure.add_subplot(2, 3, i + 1, projection="3d")
            _snapshot(axes, case, k, float(times[k]))
        _title(figure, "both bodies in Hill's frame; crosses: ports; line: track of the deputy's")
        return figure


def _snapshot(axes: Any, case: Case, k: int, time: float) -> None:
    """Draw the bodies at step k, with the track of the deputy's port up to there."""
    p, flight = case.flown.scenario.plant, case.flight
    offset, attitude = states(flight, "port_offset"), states(flight, "attitude")
    chief = chief_attitudes(p, state_times(flight)[: k + 1])
    ports = p.chief_port + offset[: k + 1]
    way = np.einsum("kij,kj->ki", chief, ports)
    center = ports[k] - attitude[k] @ p.deputy_port
    for size, at, turn, color in (
        (p.chief_size, np.zeros(3), chief[k], _CHIEF),
        (p.deputy_size, chief[k] @ center, chief[k] @ attitude[k], _DEPUTY),
    ):
        corners = at + (_CORNERS * size) @ turn.T
        axes.add_collection3d(
            Poly3DCollection(
                [corners[list(face)] for face in _FACES], facecolor=color, edgecolor=style.INK,
                alpha=0.45, linewidth=0.6,
            )
        )  # fmt: skip
    half = max(1.15 * float(np.abs(way[-1]).max()), 1.3)
    seen = np.where((np.abs(way) <= half).all(axis=1)[:, None], way, np.nan)
    axes.plot(*seen.T, color=style.MUTED, linewidth=0.9)
    for port in (chief[k] @ p.chief_port, way[-1]):
        axes.plot(*port[:, None], "x", color=style.INK, markersize=5.0, zorder=5)
    axes.set(xlim=(-half, half), ylim=(-half, half), zlim=(-half, half))
    axes.set_box_aspect((1.0, 1.0, 1.0))
    axes.set(xlabel="radial [m]", ylabel="along track [m]")
    axes.set_zlabel("normal [m]", labelpad=-1.0)
    axes.set_title(f"after {time:.0f} s")


def chief_attitudes(plant: Any, times: Array) -> Array:
    """Return the attitude (n, 3, 3) of the chief at times, chief to Hill's frame."""
    spin = plant.chief_spin_rate * plant.chief_spin_axis / np.linalg.norm(plant.chief_spin_axis)
    first = lie.exp(plant.chief_initial_rotation_vector)
    return np.array([lie.exp(spin * time) @ first for time in times])


# --- Figs. 7 and 8 -------------------------------------------------------------------------


def controls_figure(case: Case) -> Figure:
    """Fig. 7: force and moment with their limits."""
    flight, p = case.flight, case.flown.scenario.plant
    rows = (
        ("Force", "[N]", flight.force, p.max_force),
        ("Moment about the center of mass", "[N m]", flight.moment, p.max_moment),
    )
    with style.applied():
        figure = Figure((7.2, 5.4), layout="constrained")
        panels = figure.subplots(2, 1, sharex=True)
        for axes, (title, unit, values, bound) in zip(panels, rows, strict=True):
            _three(axes, flight.time, values, step=True)
            for value in (bound, -bound):
                limit(axes, value)
            frame(axes, flight.time, title, unit)
        panels[0].set_xlabel("")
        legend(panels[0], 3)
        _title(figure, "control inputs, chief frame")
        return figure


def references_figure(case: Case) -> Figure:
    """Fig. 8: position and orientation reference commands."""
    flight = case.flight
    rows = (
        ("Position reference", "[m]", flight.reference[:, :3]),
        ("Orientation reference, rotation vector", "[rad]", flight.reference[:, 3:]),
    )
    with style.applied():
        figure = Figure((7.2, 5.4), layout="constrained")
        panels = figure.subplots(2, 1, sharex=True)
        for axes, (title, unit, values) in zip(panels, rows, strict=True):
            _three(axes, flight.time, values, step=True)
            frame(axes, flight.time, title, unit)
        panels[0].set_xlabel("")
        legend(panels[0], 3)
        _title(figure, "reference commands of the governor")
        return figure


def _three(axes: Axes, times: Array, values: Array, *, step: bool = False) -> None:
    for i, name in enumerate(_AXES):
        drawn = "steps-post" if step else "default"
        axes.plot(times, values[:, i], label=name, drawstyle=drawn, **component(i))


# --- ours ----------------------------------------------------------------------------------


def constraints_figure(governed: Mapping[Start, Case], ungoverned: Mapping[Start, Case]) -> Figure:
    """Each constraint with and without the governor, as a share of its bound, by start."""
    with style.applied():
        figure = Figure((10.4, 7.6), layout="constrained")
        panels = figure.subplots(4, 2, sharex=True, sharey="row")
        for column, (title, cases) in enumerate(
            (("With the governor", governed), ("Without it", ungoverned))
        ):
            for j, (start, case) in enumerate(cases.items()):
                for axes, values in zip(panels[:, column], _constraints(case), strict=True):
                    times = state_times(case.flight)[: len(values)]
                    axes.plot(times, values, color=style.RUN_COLORS[j], label=start.words)
            panels[0, column].set_title(title)
            panels[-1, column].set_xlabel("time [s]")
        _bounds(panels, next(iter(governed.values())))
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        _title(figure, "constraints from three starts; dashed: limits")
        return figure


def _constraints(case: Case) -> tuple[Array, Array, Array, Array]:
    """Return largest force and moment by step, line-of-sight margin and clearance by state."""
    flight = case.flight
    return (
        np.abs(flight.force).max(axis=1),
        np.abs(flight.moment).max(axis=1),
        states(flight, "line_of_sight_margin"),
        states(flight, "clearance"),
    )


def _bounds(panels: Any, case: Case) -> None:
    """Draw the limit of each row, and look at it closely where it is met."""
    p = case.flown.scenario.plant
    bounds = (p.max_force, p.max_moment, 0.0, -p.clearance_tolerance)
    labels = ("force [N]", "moment [N m]", "line of sight [m]", "clearance [m]")
    for row, bound, label in zip(panels, bounds, labels, strict=True):
        for axes in row:
            limit(axes, bound)
        row[0].set_ylabel(label)
    for axes in (*panels[2], *panels[3]):
        axes.set_yscale("symlog", linthresh=0.1)  # meters at the start, centimeters at the end


def tilted_figure(tilted: Mapping[str, Case]) -> Figure:
    """Tilted spin axis: periodic laws beside time-invariant ones."""
    with style.applied():
        figure = Figure((7.2, 8.4), layout="constrained")
        panels = figure.subplots(5, 1, sharex=True)
        for j, (name, case) in enumerate(tilted.items()):
            off = np.linalg.norm(states(case.flight, "port_offset"), axis=1)
            for axes, values in zip(panels, (off, *_constraints(case)), strict=True):
                times = state_times(case.flight)[: len(values)]
                axes.plot(times, values, color=style.RUN_COLORS[j], label=name,
                          linestyle=style.COMPONENT_STYLES[j])  # fmt: skip
        panels[0].set(ylabel="port offset [m]", yscale="log")
        _bounds(panels[1:, None], tilted["periodic"])
        panels[-1].set_xlabel("time [s]")
        legend(panels[0], 2)
        _title(figure, "spin axis off the orbit normal")
        return figure


def failed_figure(case: Case) -> Figure:
    """Abort: port offset, clearance and force after a thruster is lost."""
    flight, p = case.flight, case.flown.scenario.plant
    with style.applied():
        figure = Figure((7.2, 6.6), layout="constrained")
        panels = figure.subplots(3, 1, sharex=True)
        _three(panels[0], state_times(flight), states(flight, "port_offset"))
        frame(panels[0], state_times(flight), "Port offset", "[m]")
        panels[1].plot(state_times(flight), states(flight, "clearance"), color=style.INK)
        limit(panels[1], -p.clearance_tolerance)
        frame(panels[1], state_times(flight), "Clearance", "[m]")
        _three(panels[2], flight.time, flight.force, step=True)
        frame(panels[2], flight.time, "Force, commanded", "[N]")
        lost = np.flatnonzero(flight.lost_thruster >= 0)
        for axes in panels:
            axes.axvline(p.thruster_lost_at, color=style.LIMIT_COLOR, linewidth=1.0)
            if lost.size:
                axes.axvline(flight.time[lost[0]], color=style.MUTED, linewidth=1.0, linestyle=":")
        for axes in panels[:-1]:
            axes.set_xlabel("")
        legend(panels[0], 3)
        _title(figure, f"{p.thruster_lost} lost (red), noticed (dotted)")
        return figure


def campaign_figure(found: Docked) -> Figure:
    """Random starts: when each is docked, and over the distance."""
    with style.applied():
        figure = Figure((9.6, 4.0), layout="constrained")
        left, right = figure.subplots(1, 2)
        known = found.docked_at[np.isfinite(found.docked_at)]
        times, counts = np.unique(known, return_counts=True)
        left.bar(times, counts, width=0.8 * found.period, color=style.PASSED_COLOR)
        left.set(title="Time to dock", xlabel="docked for good from [s]", ylabel="starts")
        away = np.linalg.norm(found.port_offset, axis=1)
        right.plot(away, found.docked_at, ".", markersize=3.5, color=style.PASSED_COLOR)
        right.set(title="By distance", xlabel="distance of the ports at the start [m]",
                  ylabel="docked for good from [s]")  # fmt: skip
        n, passed = len(found.status), int(found.passed.sum())
        _title(figure, f"{passed} of {n} random starts dock within the constraints")
        return figure


def _title(figure: Figure, what: str) -> None:
    figure.suptitle(f"Docking (AFRL 2016): {what}", fontsize=12, fontweight="bold")
