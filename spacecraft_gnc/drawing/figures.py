"""Figures for print: diagrams above each other, written as PNG, SVG or PDF."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from matplotlib.figure import Figure

from spacecraft_gnc.drawing import style
from spacecraft_gnc.errors import RecordingError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMATS: Final = ("png", "svg", "pdf")
SINGLE = (6.3, 3.2)  # [inch]
DOUBLE = (6.3, 5.2)
# No date in the files: the same flight gives the same bytes.
_METADATA: Final[Mapping[str, Mapping[str, None]]] = {
    "png": {},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
Draw: TypeAlias = "Callable[[Axes], None]"
Maker: TypeAlias = "Callable[[], Figure]"


def stacked(size: tuple[float, float], *draw: Draw) -> Figure:
    """Return a figure with diagrams above each other, over one time axis."""
    with style.applied():
        figure = Figure(size, layout="constrained")
        axes = figure.subplots(len(draw), 1, sharex=True, squeeze=False)[:, 0]
        for panel, draw_panel in zip(axes, draw, strict=True):
            draw_panel(panel)
        for panel in axes[:-1]:
            panel.set_xlabel("")
        return figure


def save_figures(
    figures: Iterable[tuple[str, Figure]], folder: Path, formats: Iterable[str] = ("png",)
) -> list[Path]:
    """Write figures to ``folder``/NAME.FORMAT, each in one step.

    Parameters
    ----------
    figures
        Names and figures, drawn when they are asked for.
    folder
        Created if need be.
    formats
        Of `FORMATS`.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    RecordingError
        If the folder cannot be written.
    """
    formats = tuple(formats)
    written: list[Path] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, figure in figures:
            written += [_save(figure, folder / f"{name}.{kind}", kind) for kind in formats]
    except OSError as error:
        raise RecordingError(
            f"{folder}: figures cannot be written ({os.strerror(error.errno or 0)}); required a "
            "folder that can be written, with free space; choose another with --out"
        ) from error
    return written


def _save(figure: Figure, path: Path, kind: str) -> Path:
    temporary = path.with_name(f".{path.name}.tmp")
    try:
        with style.applied():
            figure.savefig(temporary, format=kind, metadata=dict(_METADATA[kind]))
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)
    return path
