"""The 3-D view of a page: craft on their paths, where they are to be, and lines between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import style, view
from spacecraft_gnc.drawing.envelope import strided
from spacecraft_gnc.drawing.traces import label, packed
from spacecraft_gnc.types import Array

_MUTED: Final = "#8C97A5"


@dataclass(frozen=True, slots=True)
class Craft:
    """A craft on its path.

    Attributes
    ----------
    name, color
        How it is called and drawn.
    path
        (n + 1, 3) where it is in each state; NaN: unknown.
    place
        (n + 1, 3) where it is to be.
    answers
        (n + 1,) whether it does what it is told.
    """

    name: str
    color: str
    path: Array
    place: Array
    answers: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Link:
    """A line between two craft.

    Attributes
    ----------
    first, second
        Which craft.
    kept
        (n + 1,) whether the constraints between them are kept.
    """

    first: int
    second: int
    kept: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Motion:
    """What the view shows of one run.

    Attributes
    ----------
    name
        Of the run.
    times
        (n + 1,) of the states [s].
    craft, links
        What moves.
    ring
        (k, 3) closed path that the craft are to be on; empty: not known.
    told
        (n + 1,) how it stands, in words.
    readout
        Lines beside the picture.
    """

    name: str
    times: Array
    craft: Sequence[Craft]
    links: Sequence[Link]
    ring: Array
    told: Sequence[str]
    readout: Sequence[view.Readout] = ()

    @property
    def n_steps(self) -> int:
        """Control steps."""
        return len(self.times) - 1


def script() -> str:
    """Return the code of the view: ``drawView(view)`` draws what `scene` returned."""
    return view.script("craft_view.js")


def scene(
    motions: Sequence[Motion], points: int, words: view.Words, axes: Sequence[str]
) -> view.View:
    """Return the view.

    Parameters
    ----------
    motions
        The runs.
    points
        States that a run may step through; at the most `view.POINTS`.
    words
        Of the page.
    axes
        Names of x, y and z, with their unit.
    """
    points = min(points, view.POINTS)
    data = {
        "ink": style.INK,
        "grid": style.GRID_COLOR,
        "ringColor": _MUTED,
        "keptColor": style.MUTED,
        "brokenColor": style.LIMIT_COLOR,
        "axes": list(axes),
        "runs": [_run_data(motion, points) for motion in motions],
    }
    return view.View(data, view.frames_note(motions, points), words)


def _run_data(motion: Motion, points: int) -> dict[str, Any]:
    chosen = strided(motion.n_steps + 1, points)
    return {
        "name": motion.name,
        "count": len(chosen),
        "step": chosen.tolist(),
        "time": packed(motion.times[chosen]),
        "told": [motion.told[i] for i in chosen],
        "craft": [_craft_data(craft, chosen) for craft in motion.craft],
        "links": [
            {"craft": [link.first, link.second], "kept": link.kept[chosen].tolist()}
            for link in motion.links
        ],
        "ring": packed(motion.ring),
        "readout": list(view.readout_data(motion.readout, motion.n_steps + 1, chosen)),
    }


def _craft_data(craft: Craft, chosen: NDArray[np.int64]) -> dict[str, Any]:
    return {
        "name": label(craft.name),
        "color": craft.color,
        "path": packed(craft.path[chosen]),
        "place": packed(craft.place[chosen]),
        "answers": craft.answers[chosen].tolist(),
    }
