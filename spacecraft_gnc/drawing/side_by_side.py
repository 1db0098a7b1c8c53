"""Moving picture of flights side by side, each in its own space, with curves below."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final, Generic, TypeVar

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from spacecraft_gnc.drawing.moving import Timed, drawn_over
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE: Final = (8.0, 6.4)  # [inch]
_DPI: Final = 100  # 800 pixels wide
Curve = tuple[Array, Array, dict[str, Any]]
"""Times and values of a line, and its style, of which the color is one part."""
_Run = TypeVar("_Run", bound=Timed)


class SideBySide(ABC, Generic[_Run]):
    """The picture of several flights side by side, at any time.

    A subclass draws what stands still when it is made, and then calls `keep`.

    Parameters
    ----------
    runs
        What is shown.
    title
        Heading.
    """

    def __init__(self, runs: Sequence[_Run], title: str, **spaces: float) -> None:
        self._runs = runs
        self._figure = Figure(SIZE, dpi=_DPI)
        self._canvas = FigureCanvasAgg(self._figure)
        self._write(0.02, title, ha="left", fontweight="bold")
        self._spaces = self._row(len(runs), **spaces)
        self._curves: list[tuple[Axes, list[Curve]]] = []

    @abstractmethod
    def draw(self, axes: Axes, run: _Run, row: int) -> None:
        """Draw a flight in its space as it is in the state of that row."""

    def keep(self) -> None:
        """Keep what is drawn by now as that over which each frame is drawn."""
        self._canvas.draw()  # type: ignore[no-untyped-call]
        self._still = self._canvas.copy_from_bbox(self._figure.bbox)  # type: ignore[no-untyped-call]

    def frame(self, time: float) -> Array:
        """Return the picture (height, width, 3) at a time [s], 8 bits a color."""
        self._canvas.restore_region(self._still)  # type: ignore[no-untyped-call]
        for axes, run in zip(self._spaces, self._runs, strict=True):
            with drawn_over(axes):
                self.draw(axes, run, _row_at(run.times, time))
        for axes, curves in self._curves:
            with drawn_over(axes):
                for times, values, line in curves:
                    row = _row_at(times, time)
                    axes.plot(times[: row + 1], values[: row + 1], **line)
                    axes.plot(times[row], values[row], "o", markersize=4.0, color=line["color"])
        clock = self._write(0.98, f"t = {time:.0f} s", ha="right")
        self._figure.draw_artist(clock)
        clock.remove()
        picture = np.array(self._canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        return np.asarray(picture[:, :, :3])

    def _row(self, count: int, **place: float) -> list[Axes]:
        """Return axes side by side."""
        grid = self._figure.add_gridspec(1, count, **place)
        return [self._figure.add_subplot(grid[0, i]) for i in range(count)]

    def _write(self, x: float, text: str, **options: Any) -> Any:
        return self._figure.text(x, 0.965, text, va="center", fontsize=11.0, **options)


def _row_at(times: Array, time: float) -> int:
    """Return the row of the last state at a time [s]."""
    return max(int(np.searchsorted(times, time + 1e-9, side="right")) - 1, 0)
