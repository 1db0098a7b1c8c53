"""Moving pictures: frames drawn over what stands still, written as an animated GIF."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np
from PIL import Image

from spacecraft_gnc.drawing.whole_file import whole_file
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FRAMES: Final = 76
"""Frames of a flight with at least as many states; a shorter one has a frame for each state."""
MOST_RUNS: Final = 3
"""Flights that stand side by side."""
_SHOWN: Final = 100  # wall time of a frame [ms]
_LAST_SHOWN: Final = 2500  # of the last one, before the first follows again [ms]
_WHITE: Final = 255  # place of white in the palette, behind all other colors


class Timed(Protocol):
    """A flight with the times of its states."""

    @property
    def times(self) -> Array:
        """(n + 1,) [s]."""


def require_few(runs: Sequence[Any]) -> None:
    """Raise ParameterError if there are more flights than can stand side by side."""
    if len(runs) > MOST_RUNS:
        raise ParameterError(
            f"--animate: received {len(runs)} runs; required {MOST_RUNS} at the most, which "
            "stand side by side; leave some out"
        )


def frame_times(runs: Sequence[Timed]) -> Array:
    """Return the times of the frames [s]: states of the longest flight, evenly spread."""
    times = max((run.times for run in runs), key=lambda times: times[-1])
    rows = np.linspace(0, len(times) - 1, min(len(times), FRAMES)).round().astype(int)
    return np.asarray(times[rows])


def write_gif(frame: Callable[[float], Array], times: Array, path: Path) -> None:
    """Write the moving picture of ``frame`` at times (k,), in one step; it starts again at its end.

    Parameters
    ----------
    frame
        Returns the picture (height, width, 3) at a time [s], 8 bits a color.
    times
        Of the frames [s].
    path
        The .gif file.

    Raises
    ------
    RecordingError
        If the file cannot be written; nothing is left then.
    """
    shown = [_SHOWN] * (len(times) - 1) + [_LAST_SHOWN]
    with whole_file(path) as temporary:
        first, others = _pictures(frame, times)
        first.save(
            temporary, format="gif", save_all=True, append_images=others, duration=shown, loop=0
        )


@contextmanager
def drawn_over(axes: Axes) -> Iterator[None]:
    """Draw at once, over what is there, all that is added to axes meanwhile; then remove it."""
    still = set(axes.get_children())
    axes.set_autoscale_on(False)
    yield
    moving = [artist for artist in axes.get_children() if artist not in still]
    for artist in sorted(moving, key=lambda artist: artist.get_zorder()):
        axes.draw_artist(artist)
        artist.remove()


def _pictures(
    frame: Callable[[float], Array], times: Array
) -> tuple[Image.Image, Iterator[Image.Image]]:
    """Return the first frame, and what draws the others one by one."""
    # One palette for all, so that nothing flickers: of the last, which has every color.
    palette = Image.fromarray(frame(times[-1])).quantize(_WHITE, Image.Quantize.MAXCOVERAGE)
    colors = list(palette.getpalette() or ())[: 3 * _WHITE]
    palette.putpalette(colors + [255] * (768 - len(colors)))
    pictures = (_indexed(frame(time), palette) for time in times)
    return next(pictures), pictures


def _indexed(picture: Array, palette: Image.Image) -> Image.Image:
    """Return a picture (height, width, 3) in the colors of a palette."""
    indexed = Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
    # The nearest color may be a light gray: the background is to be white.
    indexed.paste(_WHITE, mask=Image.fromarray((picture == 255).all(axis=2)))
    return indexed
