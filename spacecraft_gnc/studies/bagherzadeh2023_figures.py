"""Pictures of Bagherzadeh et al. 2023: its Figs. 1-5 (variants) and 7-13 (neighboring extremals).

The paper's pairs of pictures, exact against another way, are one picture here: the exact flight is
a broad pale line.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.studies import overlays
from spacecraft_gnc.studies.bagherzadeh2023 import square_errors
from spacecraft_gnc.studies.bagherzadeh2023_study import (
    EXACT,
    NE,
    NE_EXACT_10,
    ONLINE,
    TIMED,
    Study,
)
from spacecraft_gnc.studies.flights import Flown
from spacecraft_gnc.vehicles.rigid_body.pictures import motion as panels
from spacecraft_gnc.vehicles.rigid_body.series import momenta, state_times

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_DASHED: Final = {**overlays.THIN, "linestyle": (0, (4, 1.5))}
_DOTTED: Final = {**overlays.THIN, "linestyle": (0, (1, 1.5))}
_ERRORS: Final = (1e-5, 20.0)  # range of the errors drawn [deg]


def figures(
    variants: Mapping[str, Flown], studies: Mapping[str, Study]
) -> Iterator[tuple[str, Figure]]:
    """Yield the pictures by name."""
    yield "bagherzadeh2023_variants", _variants(variants)
    yield "bagherzadeh2023_extremals", _extremals(studies)


def _variants(variants: Mapping[str, Flown]) -> Figure:
    flights = {name: flown.trajectory for name, flown in variants.items()}
    exact = flights["exact"]
    times, looks = exact.time, (overlays.WIDE, _DASHED, _DOTTED)
    torques = {n: (f.torque, k) for (n, f), k in zip(flights.items(), looks, strict=True)}
    moments = {n: (momenta(f), k) for (n, f), k in zip(flights.items(), looks, strict=True)}
    with style.applied():
        figure = Figure((11.0, 9.6), layout="constrained")
        grid = figure.add_gridspec(3, 2)
        axes = [figure.add_subplot(grid[i, j]) for i in range(3) for j in range(2)]
        overlays.components(axes[0], times, torques, title="Control", symbol="u", unit="N m")
        panels.torque_norm(axes[1], exact, variants["exact"].scenario.controller.max_torque)
        axes[1].set_title("Norm of the control, exact")
        overlays.components(
            axes[2], state_times(exact), moments, title="Momentum", symbol=r"\Pi", unit="N m s"
        )
        _square_errors(axes[3], variants)
        steps = {name: flown.step_times for name, flown in variants.items()}
        overlays.step_times(axes[4], times, steps, title="Time of a step")
        panels.attitude_sphere(axes[5], exact)
        axes[5].set_title("Attitude, exact")
        _heading(figure, "simplified sensitivities")
        return figure


def _square_errors(axes: Axes, variants: Mapping[str, Flown]) -> None:
    exact = variants["exact"]
    series = {
        name: square_errors(exact, flown)[:, :3].sum(axis=1)
        for name, flown in variants.items()
        if name != "exact"
    }
    overlays.lines(
        axes, exact.trajectory.time, series,
        title="Integral square error of the control", ylabel="ISE [(N m)$^2$ s]", floor=1e-28,
    )  # fmt: skip


def _extremals(studies: Mapping[str, Study]) -> Figure:
    study = studies[TIMED]
    with style.applied():
        figure = Figure((11.0, 10.8), layout="constrained")
        top, middle, bottom = figure.subfigures(3, 1, squeeze=False)[:, 0]
        left, right = top.subplots(1, 2)
        _states(left, right, study)
        errors = middle.subplots(1, 3, sharey=True)
        for axes, (name, one) in zip(errors, studies.items(), strict=True):
            _errors(axes, name, one)
        errors[0].set(ylabel="angle from the exact flight [deg]", ylim=_ERRORS)
        handles, labels = errors[0].get_legend_handles_labels()
        middle.legend(handles, labels, loc="outside lower center", ncols=len(labels))
        left, right = bottom.subplots(1, 2)
        steps = {name: flown.step_times for name, flown in study.flights.items()}
        times = state_times(study.flights[EXACT].trajectory)
        overlays.step_times(left, times, steps, title=f"Time of a step, {TIMED}")
        panels.attitude_sphere(right, study.flights[NE_EXACT_10].trajectory)
        right.set_title(f"Attitude, {NE_EXACT_10}")
        _heading(figure, "neighboring extremals from changed initial conditions")
        return figure


def _states(left: Axes, right: Axes, study: Study) -> None:
    """Draw torque and momentum: exact, the paper's open loop, and with exact solves between."""
    exact = study.flights[EXACT].trajectory
    mixed = study.flights[NE_EXACT_10].trajectory
    names = (EXACT, "NE open loop", "NE + exact")
    looks = (overlays.WIDE, _DASHED, _DOTTED)
    torques = (exact.torque, study.open_loop.torques, mixed.torque)
    moments = (momenta(exact), study.open_loop.momenta, momenta(mixed))
    overlays.components(
        left, exact.time, dict(zip(names, zip(torques, looks, strict=True), strict=True)),
        title=f"Control, {TIMED}", symbol="u", unit="N m",
    )  # fmt: skip
    overlays.components(
        right, state_times(exact), dict(zip(names, zip(moments, looks, strict=True), strict=True)),
        title=f"Momentum, {TIMED}", symbol=r"\Pi", unit="N m s",
    )  # fmt: skip


def _errors(axes: Axes, name: str, study: Study) -> None:
    times = state_times(study.flights[EXACT].trajectory)
    series = {
        "NE open loop": study.error_of(study.open_loop),
        "NE": study.error_of(study.raw),
        "NE cut to the limit": study.error(NE),
        NE_EXACT_10: study.error(NE_EXACT_10),
        ONLINE: study.error(ONLINE),
    }
    shown = {key: np.where(error > 0.0, error, np.nan) for key, error in series.items()}
    overlays.lines(
        axes, times, shown, title=f"Error, {name}", ylabel="", floor=_ERRORS[0], with_key=False
    )


def _heading(figure: Figure, what: str) -> None:
    figure.suptitle(f"Bagherzadeh et al. (2023), {what}", fontsize=12, fontweight="bold")
