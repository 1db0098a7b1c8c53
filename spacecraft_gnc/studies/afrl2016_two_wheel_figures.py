"""Pictures beside Figs. 1 to 5 of Kolmanovsky et al. 2016: two wheels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, frame, legend, limit
from spacecraft_gnc.drawing.chart import held
from spacecraft_gnc.studies.afrl2016_laws import MAX_ACCELERATION, Circle, Plane
from spacecraft_gnc.studies.afrl2016_region import NEAR, Region
from spacecraft_gnc.vehicles.two_wheel import flown as series
from spacecraft_gnc.vehicles.two_wheel.summary import states

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from spacecraft_gnc.studies.afrl2016_two_wheel_study import Case

_SIGNED: Final = LinearSegmentedColormap.from_list(
    "signed", [style.AXIS_COLORS[0], "#F6F6F3", style.AXIS_COLORS[1]]
)
_ACCELERATION: Final = "$u_1$ [rad/s²]"
_SHADE: Final = "#E0E0DC"  # where no plan exists
_ANGLES: Final = (r"roll $\phi$", r"pitch $\theta$", r"yaw $\psi$")
_JUMP: Final = 2.0  # rad/s^2 between neighbors that no line joins


def figures(
    circles: tuple[Circle, ...], plane: Plane, cases: Mapping[str, Case], region: Region | None
) -> Iterator[tuple[str, Figure]]:
    """Yield name and figure."""
    yield "afrl2016_circle", circle_figure(circles)
    yield "afrl2016_plane", plane_figure(plane)
    yield "afrl2016_euler_angles", euler_figure(cases)
    yield "afrl2016_wheels", wheels_figure(cases)
    if region is not None:
        yield "afrl2016_region", region_figure(region)


def circle_figure(circles: tuple[Circle, ...]) -> Figure:
    """Fig. 1: the law over circles, with the part from which no plan exists."""
    with style.applied():
        figure = Figure((7.2, 2.6 + 2.1 * len(circles)), layout="constrained")
        panels = figure.subplots(len(circles), 1, sharex=True, squeeze=False)[:, 0]
        for axes, laws in zip(panels, circles, strict=True):
            _law_over_circle(axes, laws)
        panels[-1].set_xlabel(r"$\lambda$ [deg]")
        _title(figure, r"feedback $u_1$ from $\phi = r\,\cos\lambda$, $\psi = r\,\sin\lambda$")
        return figure


def _law_over_circle(axes: Axes, laws: Circle) -> None:
    degrees, step = np.degrees(laws.angle), np.degrees(laws.angle[1] - laws.angle[0])
    for angle in degrees[np.isnan(laws.acceleration)]:
        axes.axvspan(angle - 0.5 * step, angle + 0.5 * step, color=_SHADE, linewidth=0.0)
    joined = np.append(laws.acceleration, np.nan)
    jumps = np.flatnonzero(np.abs(np.diff(joined)) > _JUMP)
    axes.plot(
        np.insert(np.append(degrees, degrees[-1]), jumps + 1, degrees[jumps]),
        np.insert(joined, jumps + 1, np.nan),
        "-",
        color=style.AXIS_COLORS[0],
        marker=".",
        markersize=3.5,
    )
    for bound in (MAX_ACCELERATION, -MAX_ACCELERATION):
        limit(axes, bound)
    axes.set(title=f"r = {laws.radius:g} rad", ylabel=_ACCELERATION, xlim=(0.0, 360.0))
    axes.set_xticks(range(0, 361, 45))
    if laws.infeasible:
        axes.legend(handles=[_infeasible()], loc="lower right", bbox_to_anchor=(1.0, 1.0))


def _infeasible() -> Patch:
    return Patch(label="no plan of 30 steps", facecolor=_SHADE)


def plane_figure(plane: Plane) -> Figure:
    """Fig. 2: the law over roll and yaw as a map, and along roll."""
    with style.applied():
        figure = Figure((11.0, 4.9), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
        left.set_facecolor(_SHADE)
        left.grid(visible=False)
        image = left.pcolormesh(
            plane.roll,
            plane.yaw,
            plane.acceleration,
            cmap=_SIGNED,
            vmin=-MAX_ACCELERATION,
            vmax=MAX_ACCELERATION,
            shading="nearest",
            rasterized=True,
        )
        figure.colorbar(image, ax=left, label=_ACCELERATION)
        left.set(
            title="Map", xlabel=rf"{_ANGLES[0]} [rad]", ylabel=rf"{_ANGLES[2]} [rad]",
            aspect="equal",
        )  # fmt: skip
        left.legend(handles=[_infeasible()], loc="lower right", bbox_to_anchor=(1.0, 1.0))
        _cuts(right, plane)
        _title(figure, r"feedback $u_1$ over $\phi$ and $\psi$, $\theta = 0$")
        return figure


def _cuts(axes: Axes, plane: Plane) -> None:
    """Draw the law along roll at some yaws, as dots: a line would hide the jump."""
    wanted = np.array([0.03, 0.25, 0.5]) * plane.yaw[-1]
    for i, yaw in enumerate(wanted):
        row = int(np.abs(plane.yaw - yaw).argmin())
        axes.plot(
            plane.roll,
            plane.acceleration[row],
            "osD"[i],
            markersize=3.5,
            color=style.COMPONENT_COLORS[i],
            label=rf"$\psi$ = {plane.yaw[row]:.2f} rad",
        )
    for bound in (MAX_ACCELERATION, -MAX_ACCELERATION):
        limit(axes, bound)
    axes.set(title="Along roll", xlabel=rf"{_ANGLES[0]} [rad]", ylabel=_ACCELERATION)
    legend(axes, 3, handletextpad=0.2)


def euler_figure(cases: Mapping[str, Case]) -> Figure:
    """Fig. 3: Euler angles on the exact plant, from each start."""
    with style.applied():
        figure = Figure((7.2, 1.0 + 2.4 * len(cases)), layout="constrained")
        panels = figure.subplots(len(cases), 1, sharex=True, squeeze=False)[:, 0]
        longest = max(
            (states(case.flight)[0] for case in cases.values()), key=lambda t: float(t[-1])
        )
        for axes, (name, case) in zip(panels, cases.items(), strict=True):
            angles = np.radians(series.euler_deg(case.flight))
            for i, label in enumerate(_ANGLES):
                axes.plot(states(case.flight)[0], angles[:, i], label=label, **component(i))
            axes.axvline(case.settled_at, color=style.MUTED, linewidth=1.0, linestyle=":")
            frame(axes, longest, f"From {name}", "angle [rad]")
        legend(panels[0], 3)
        for axes in panels[:-1]:
            axes.set_xlabel("")
        _title(figure, "Euler angles; dotted: settled for good")
        return figure


def wheels_figure(cases: Mapping[str, Case]) -> Figure:
    """Fig. 4: speeds and accelerations of the wheels with their limits, from the first start."""
    name, case = next(iter(cases.items()))
    flight, plant = case.flight, case.flown.scenario.plant
    times = states(flight)[0]
    rows = (
        ("Wheel speeds", "[rad/s]", series.wheel_speed(flight), plant.max_wheel_speed, "default"),
        ("Wheel accelerations", "[rad/s²]", held(flight.wheel_acceleration),
         plant.max_wheel_acceleration, "steps-post"),
    )  # fmt: skip
    with style.applied():
        figure = Figure((7.2, 5.4), layout="constrained")
        panels = figure.subplots(2, 1, sharex=True)
        for axes, (title, unit, values, bound, drawn) in zip(panels, rows, strict=True):
            for i, label in enumerate(series.wheel_names(flight)):
                axes.plot(times, values[:, i], label=label, drawstyle=drawn, **component(i))
            limit(axes, bound)
            limit(axes, -bound)
            frame(axes, times, title, unit)
        panels[0].set_xlabel("")
        legend(panels[0], 2)
        _title(figure, f"wheels, from {name}")
        return figure


def region_figure(region: Region) -> Figure:
    """Fig. 5: starts that converge and that do not, and how long it takes."""
    with style.applied():
        figure = Figure((9.6, 8.6), layout="constrained")
        panels = figure.subplots(2, 2)
        for axes, (i, j) in zip(panels.flat, ((0, 1), (0, 2), (1, 2)), strict=False):
            _starts(axes, region, i, j)
        _settle_times(panels[1, 1], region)
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
        n, converged = len(region.status), int(region.converged.sum())
        _title(figure, f"region of attraction: {converged} of {n} starts converge")
        return figure


def _starts(axes: Axes, region: Region, i: int, j: int) -> None:
    degrees, converged = np.degrees(region.euler), region.converged
    axes.plot(
        degrees[converged, i], degrees[converged, j], ".", markersize=3.5,
        color=style.PASSED_COLOR, label="converges",
    )  # fmt: skip
    axes.plot(
        degrees[~converged, i], degrees[~converged, j], "X", markersize=6.0, label="does not",
        markeredgecolor="white", markeredgewidth=0.4, color=style.FAILED_COLOR, zorder=3,
    )  # fmt: skip
    near = np.degrees(NEAR)
    axes.add_patch(
        Rectangle(
            (-near, -near), 2.0 * near, 2.0 * near, fill=False, edgecolor=style.INK, linewidth=1.2,
            label="$\\pm$1 rad",
        )
    )  # fmt: skip
    axes.set(
        xlabel=f"{_ANGLES[i]} [deg]", ylabel=f"{_ANGLES[j]} [deg]", xlim=(-185.0, 185.0),
        ylim=(-185.0, 185.0), aspect="equal",
    )  # fmt: skip
    axes.set_xticks(range(-180, 181, 90))
    axes.set_yticks(range(-180, 181, 90))


def _settle_times(axes: Axes, region: Region) -> None:
    axes.plot(region.angle_deg, region.settled_at, ".", markersize=3.5, color=style.PASSED_COLOR)
    axes.set(
        title="Time to settle", xlabel="angle of the turn [deg]", xlim=(0.0, 185.0),
        ylabel="settled for good from [s]",
    )  # fmt: skip
    axes.set_ylim(bottom=0.0)
    axes.set_xticks(range(0, 181, 45))


def _title(figure: Figure, what: str) -> None:
    figure.suptitle(f"Two wheels (AFRL 2016): {what}", fontsize=12, fontweight="bold")
