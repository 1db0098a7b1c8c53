"""Figure of a replay: delta-v of each craft as flown and as replayed, and their difference."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.axes import component, frame, legend
from spacecraft_gnc.drawing.figures import Draw, stacked
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.resolved import Resolved

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SIZE: Final = (6.3, 6.6)  # [inch]


def replay_figure(resolved: Resolved, names: tuple[str, str], title: str) -> Figure:
    """Return the lengths of delta-v as flown and as replayed, and those of the differences."""
    draws: list[Draw] = []
    for sizes, what in (
        (np.linalg.norm(resolved.recorded, axis=-1), f"as flown, {names[0]}"),
        (np.linalg.norm(resolved.replayed, axis=-1), f"replayed, {names[1]}"),
        (resolved.differences, "difference"),
    ):
        draw = partial(_craft, times=resolved.times, sizes=sizes)
        draws.append(partial(draw, title=f"Delta-v {what}"))
    figure = stacked(_SIZE, *draws)
    with style.applied():
        figure.suptitle(title, fontsize=12, fontweight="bold")
    return figure


def _craft(axes: Axes, times: Array, sizes: Array, title: str) -> None:
    for i, values in enumerate(sizes.T):
        axes.plot(times, values, label=f"craft {i + 1}", drawstyle="steps-post", **component(i % 4))
    legend(axes, sizes.shape[1])
    frame(axes, times, title, "[m/s]")
