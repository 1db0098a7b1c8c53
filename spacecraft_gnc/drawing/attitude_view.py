"""The 3-D view of a page: body axes on the unit sphere, with a slider, zones and a readout."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.drawing import representations as forms
from spacecraft_gnc.drawing import style, view
from spacecraft_gnc.drawing.envelope import strided
from spacecraft_gnc.drawing.geometry import circle, graticule, rim
from spacecraft_gnc.drawing.traces import label, packed
from spacecraft_gnc.drawing.zones import Zone, unit
from spacecraft_gnc.types import Array

_LIFT: Final = 1.004  # radius of the zones, so that the sphere does not hide them
_RINGS: Final = 10
_SECTORS: Final = 72
_WORDS: Final = view.Words(
    "Attitude in 3-D",
    "Attitude on the unit sphere, inertial frame",
    "Body axes and pointing zones on the unit sphere",
    "Lines: paths of the body axes x, y, z; arrows: where they point at the time of the slider; "
    "diamonds: {diamonds}. Caps: pointing zones, filled. Drag to turn.",
)
_BODY_AXES: Final = {"body x": (1, 0, 0), "body y": (0, 1, 0), "body z": (0, 0, 1)}


@dataclass(frozen=True, slots=True)
class Rotors:
    """Wheels in the body.

    Attributes
    ----------
    names
        Of m wheels.
    axes
        (3, m) unit vectors, body frame.
    turning
        (n + 1, m) speed over its limit, or over the largest one that occurs.
    healthy, trusted
        (n + 1, m) whether each works, and whether it counts as working on board.
    """

    names: Sequence[str]
    axes: Array
    turning: Array
    healthy: NDArray[np.bool_]
    trusted: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Motion:
    """What the view shows of one run.

    Attributes
    ----------
    name
        Of the run.
    times, attitudes, references
        (n + 1,) [s], (n + 1, 3, 3) of the states, body to inertial.
    error_deg
        (n + 1,) angle to what the run is judged by [deg].
    vectors
        (n + 1, k) further values of the readout, by label with unit.
    notes
        (n + 1,) words beside one of these, by its label.
    zones
        Pointing zones.
    rotors
        Wheels; None: there are none to draw.
    """

    name: str
    times: Array
    attitudes: Array
    references: Array
    error_deg: Array
    vectors: Mapping[str, Array]
    notes: Mapping[str, Sequence[str]] = field(default_factory=dict)
    zones: Sequence[Zone] = ()
    rotors: Rotors | None = None

    @property
    def n_steps(self) -> int:
        """Control steps."""
        return len(self.times) - 1


def script() -> str:
    """Return the code of the view: ``drawView(view)`` draws what `view_data` returned."""
    return view.script("attitude_view.js")


def view_data(motions: Sequence[Motion], points: int) -> dict[str, Any]:
    """Return the attitudes and the zones of every run, the sphere and the colors."""
    return {
        "axisColors": list(style.AXIS_COLORS),
        "ink": style.INK,
        "grid": style.GRID_COLOR,
        "graticule": [packed(line) for line in graticule(_SECTORS)],
        "runs": [_run_data(motion, points) for motion in motions],
    }


def _run_data(motion: Motion, points: int) -> dict[str, Any]:
    chosen = strided(motion.n_steps + 1, points)
    return {
        "name": motion.name,
        "count": len(chosen),
        "step": chosen.tolist(),
        "time": packed(motion.times[chosen]),
        "attitude": packed(motion.attitudes[chosen]),
        "reference": packed(motion.references[chosen]),
        "error": packed(motion.error_deg[chosen]),
        "readout": list(_readout(motion, chosen)),
        "zones": [_zone_data(zone) for zone in motion.zones],
        "rotors": None if motion.rotors is None else _rotor_data(motion.rotors, chosen),
    }


def _rotor_data(rotors: Rotors, chosen: NDArray[np.int64]) -> dict[str, Any]:
    """Return wheels: the rim of each, how fast it turns, and whether it works and is trusted."""
    m = len(rotors.names)
    return {
        "names": [label(name) for name in rotors.names],
        "rims": [packed(rim(axis)) for axis in rotors.axes.T],
        "turning": packed(rotors.turning[chosen]),
        "healthy": packed(rotors.healthy[chosen].astype(float)),
        "trusted": packed(rotors.trusted[chosen].astype(float)),
        "colors": [style.COMPONENT_COLORS[i % len(style.COMPONENT_COLORS)] for i in range(m)],
        "lost": style.LIMIT_COLOR,
    }


def _readout(motion: Motion, chosen: NDArray[np.int64]) -> Iterator[dict[str, Any]]:
    """Yield the lines of the readout: digits after the point, or significant ones."""
    for form, digits in zip(forms.REPRESENTATIONS, (5, 3, 5), strict=True):
        values = forms.values(form, motion.attitudes)[chosen]
        what = "" if form is forms.ROLL_PITCH_YAW else f"{form.name.replace('_', ' ')} "
        name = f"{what}{', '.join(form.components)} [{form.unit}]"
        yield {"label": name, "values": packed(values), "fixed": digits, "width": values.shape[1]}
    yield {
        "label": "error [deg]", "values": packed(motion.error_deg[chosen]), "significant": 5,
        "width": 1,
    }  # fmt: skip
    for name, vectors in motion.vectors.items():
        notes = [motion.notes[name][i] for i in chosen] if name in motion.notes else []
        yield {
            "label": name, "values": packed(vectors[chosen]), "significant": 4,
            "width": vectors.shape[1], "notes": notes,
        }  # fmt: skip


def _zone_data(zone: Zone) -> dict[str, Any]:
    body_axis = unit(zone.body_axis)
    named = [
        name for name, along in _BODY_AXES.items() if np.allclose(body_axis, along, atol=1e-12)
    ]
    points = cap(unit(zone.inertial_axis), math.radians(zone.half_angle_deg))
    where = named[0] if named else "its boresight"
    return {
        "name": label(f"{zone.name}: {zone.kind} for {where}, {zone.half_angle_deg:.4g}°"),
        "kind": zone.kind,
        "color": style.ZONE_COLORS[zone.kind],
        "bodyAxis": body_axis.tolist(),
        "boresight": not named,
        "points": packed(points),
        "triangles": _triangles(),
        "border": packed(points[-_SECTORS:]),
    }


def cap(axis: Array, half_angle: float) -> Array:
    """Return points (1 + rings * sectors, 3) of the cap within ``half_angle`` [rad] of ``axis``.

    The center first, then ring after ring; the last one is the border.
    """
    angles = half_angle * np.arange(1, _RINGS + 1) / _RINGS
    rings = [circle(axis, angle, _SECTORS)[:-1] for angle in angles]
    return np.asarray(_LIFT * np.vstack([axis[None], *rings]))


def _triangles() -> list[list[int]]:
    """Return the three corners of each triangle of a cap, as plotly.js takes them."""
    corners: list[tuple[int, int, int]] = []
    for s in range(_SECTORS):
        t = (s + 1) % _SECTORS
        corners.append((0, 1 + s, 1 + t))
        for ring in range(_RINGS - 1):
            inner, outer = 1 + ring * _SECTORS, 1 + (ring + 1) * _SECTORS
            corners.append((inner + s, outer + s, outer + t))
            corners.append((inner + s, outer + t, inner + t))
    return [list(column) for column in zip(*corners, strict=True)]


def scene(motions: Sequence[Motion], points: int) -> view.View:
    """Return what the view draws, which states it steps through, and its words."""
    return view.View(view_data(motions, points), view.frames_note(motions, points), _WORDS)
