"""The 3-D view of a page: bodies that move relative to each other, with ports, region and trail."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import style, view
from spacecraft_gnc.drawing.envelope import strided
from spacecraft_gnc.drawing.solids import CORNERS, EDGES, Body, triangles
from spacecraft_gnc.drawing.traces import label, packed
from spacecraft_gnc.types import Array


@dataclass(frozen=True, slots=True)
class Region:
    """A region with eight corners that stands still in the frame of the view."""

    name: str
    color: str
    corners: Array
    """(8, 3) in the order of `solids.CORNERS` [m]."""


@dataclass(frozen=True, slots=True)
class Motion:
    """What the view shows of one run.

    Attributes
    ----------
    name
        Of the run.
    times
        (n + 1,) of the states [s].
    bodies
        The first one stands still in the frame of the view, about its origin; none: not known.
    trail
        (n + 1, 3) path that is drawn [m].
    reference
        (n + 1, 3) where the trail is to go [m].
    turn
        (n + 1, 3, 3) attitude of that frame in another one, which the reader can choose.
    told
        (n + 1,) how it stands, in words.
    readout
        Lines beside the picture.
    region
        None: there is none.
    snapshots
        States in which the bodies stay drawn.
    """

    name: str
    times: Array
    bodies: Sequence[Body]
    trail: Array
    reference: Array
    turn: Array
    told: Sequence[str]
    readout: Sequence[view.Readout] = ()
    region: Region | None = None
    snapshots: Sequence[int] = field(default_factory=tuple)

    @property
    def n_steps(self) -> int:
        """Control steps."""
        return len(self.times) - 1


def script() -> str:
    """Return the code of the view: ``drawView(view)`` draws what `scene` returned."""
    return view.script("bodies_view.js")


def scene(
    motions: Sequence[Motion],
    points: int,
    words: view.Words,
    frames: Mapping[str, Sequence[str]],
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
    frames
        Name of the frame of the motions and of the other one, each with the names of its axes.
    """
    points = min(points, view.POINTS)
    data = {
        "ink": style.INK,
        "grid": style.GRID_COLOR,
        "portColor": style.AXIS_COLORS[1],
        "frames": [{"name": name, "axes": list(axes)} for name, axes in frames.items()],
        "corners": packed(CORNERS),
        "edges": [list(edge) for edge in EDGES],
        "triangles": triangles().T.tolist(),
        "runs": [_run_data(motion, points) for motion in motions],
    }
    return view.View(data, view.frames_note(motions, points), words)


def _run_data(motion: Motion, points: int) -> dict[str, Any]:
    chosen = _chosen(motion, points)
    place = {int(row): k for k, row in enumerate(chosen)}
    return {
        "name": motion.name,
        "count": len(chosen),
        "step": chosen.tolist(),
        "time": packed(motion.times[chosen]),
        "told": [motion.told[i] for i in chosen],
        "bodies": [_body_data(body, chosen) for body in motion.bodies],
        "trail": packed(motion.trail[chosen]),
        "reference": packed(motion.reference[chosen]),
        "turn": packed(motion.turn[chosen]),
        "region": None if motion.region is None else _region_data(motion.region),
        "snapshots": [place[row] for row in motion.snapshots],
        "readout": list(view.readout_data(motion.readout, motion.n_steps + 1, chosen)),
    }


def _chosen(motion: Motion, points: int) -> NDArray[np.int64]:
    """Return the states that the slider steps through, the snapshots among them."""
    extra = np.array(motion.snapshots, dtype=np.int64)
    return np.union1d(strided(motion.n_steps + 1, points), extra)


def _body_data(body: Body, chosen: NDArray[np.int64]) -> dict[str, Any]:
    return {
        "name": label(body.name),
        "color": body.color,
        "size": body.size.tolist(),
        "port": body.port.tolist(),
        "position": packed(body.positions[chosen]),
        "attitude": packed(body.attitudes[chosen]),
    }


def _region_data(region: Region) -> dict[str, Any]:
    name = label(region.name)
    return {"name": name, "color": region.color, "corners": packed(region.corners)}
