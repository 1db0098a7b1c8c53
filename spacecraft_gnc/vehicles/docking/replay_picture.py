"""Figure of a replay: forces and moments as flown and as replayed, and their differences."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, frame, legend
from spacecraft_gnc.drawing.figures import Draw, stacked
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.resolved import Resolved

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE: Final = (6.3, 10.4)  # [inch]
_HALVES: Final = (("Force", slice(3), "N"), ("Moment", slice(3, 6), "N m"))


def replay_figure(resolved: Resolved, names: tuple[str, str], title: str) -> Figure:
    """Return the wrenches as flown and as replayed, and their differences."""
    draws: list[Draw] = []
    for part, half, unit in _HALVES:
        flown, again = resolved.recorded[:, half], resolved.replayed[:, half]
        for values, what in (
            (flown, f"as flown, {names[0]}"),
            (again, f"replayed, {names[1]}"),
            (again - flown, "difference"),
        ):
            line = partial(_components, times=resolved.times, values=values, unit=unit)
            draws.append(partial(line, title=f"{part} {what}"))
    figure = stacked(_SIZE, *draws)
    with style.applied():
        figure.suptitle(title, fontsize=12, fontweight="bold")
    return figure


def _components(axes: Axes, times: Array, values: Array, title: str, unit: str) -> None:
    for i, name in enumerate("xyz"):
        axes.plot(times, values[:, i], label=name, drawstyle="steps-post", **component(i))
    legend(axes, 3)
    frame(axes, times, title, f"[{unit}]")
