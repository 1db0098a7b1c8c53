"""Animated GIF of one flight, or of several side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from PIL import Image

from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.whole_file import whole_file
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.pictures._animated_run import AnimatedRun, animated_run
from spacecraft_gnc.vehicles.rigid_body.pictures._scene import Scene

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

FRAMES: Final = 76
"""Frames of a flight with at least as many states; a shorter one has a frame for each state."""
_MOST_RUNS: Final = 3
_SHOWN: Final = 100  # wall time of a frame [ms]
_LAST_SHOWN: Final = 2500  # of the last one, before the first follows again [ms]
_WHITE: Final = 255  # place of white in the palette, behind all other colors


def save_animation(
    flights: Mapping[str, tuple[Flight, Scenario | None]], path: Path, *, title: str = ""
) -> None:
    """Write the moving picture of flights, which starts again at its end, in one step.

    Parameters
    ----------
    flights
        Flight and scenario by name, three at the most; the scenario gives the torque limit and
        the pointing zones with the axes of the instruments.
    path
        The .gif file.
    title
        Heading.

    Raises
    ------
    ParameterError
        If there are more flights.
    RecordingError
        If the file cannot be written; nothing is left then.
    """
    if len(flights) > _MOST_RUNS:
        raise ParameterError(
            f"--animate: received {len(flights)} runs; required {_MOST_RUNS} at the most, which "
            "stand side by side; leave some out"
        )
    runs = [animated_run(name, *flown, i) for i, (name, flown) in enumerate(flights.items())]
    times = frame_times(runs)
    shown = [_SHOWN] * (len(times) - 1) + [_LAST_SHOWN]
    with style.applied(), whole_file(path) as temporary:
        first, others = _pictures(Scene(runs, title), times)
        first.save(
            temporary, format="gif", save_all=True, append_images=others, duration=shown, loop=0
        )


def _pictures(scene: Scene, times: Array) -> tuple[Image.Image, Iterator[Image.Image]]:
    """Return the first frame, and what draws the others one by one."""
    # One palette for all, so that nothing flickers: of the last, which has every color.
    palette = Image.fromarray(scene.frame(times[-1])).quantize(_WHITE, Image.Quantize.MAXCOVERAGE)
    colors = list(palette.getpalette() or ())[: 3 * _WHITE]
    palette.putpalette(colors + [255] * (768 - len(colors)))
    pictures = (_indexed(scene.frame(time), palette) for time in times)
    return next(pictures), pictures


def _indexed(picture: Array, palette: Image.Image) -> Image.Image:
    """Return a picture (height, width, 3) in the colors of a palette."""
    indexed = Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE)
    # The nearest color may be a light gray: the background is to be white.
    indexed.paste(_WHITE, mask=Image.fromarray((picture == 255).all(axis=2)))
    return indexed


def frame_times(runs: Sequence[AnimatedRun]) -> Array:
    """Return the times of the frames [s]: states of the longest flight, evenly spread."""
    times = max((run.times for run in runs), key=lambda times: times[-1])
    rows = np.linspace(0, len(times) - 1, min(len(times), FRAMES)).round().astype(int)
    return np.asarray(times[rows])
