"""What the 3-D view needs: attitudes to step through, and pointing zones as surfaces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from spacecraft_gnc.analysis import representations as forms
from spacecraft_gnc.analysis import series
from spacecraft_gnc.analysis.report.runs import Run
from spacecraft_gnc.analysis.sources import source_name
from spacecraft_gnc.drawing import style
from spacecraft_gnc.drawing.envelope import strided
from spacecraft_gnc.drawing.geometry import circle
from spacecraft_gnc.drawing.traces import label, packed
from spacecraft_gnc.types import Array

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.parameters.zones import ZoneParameters

_LIFT: Final = 1.004  # radius of the zones, so that the sphere does not hide them
_RINGS: Final = 10
_SECTORS: Final = 72
_BODY_AXES: Final = {"body x": (1, 0, 0), "body y": (0, 1, 0), "body z": (0, 0, 1)}


def sphere_data(runs: Sequence[Run], points: int) -> dict[str, Any]:
    """Return the attitudes and the zones of every run, and the colours."""
    return {
        "axisColours": list(style.AXIS_COLOURS),
        "ink": style.INK,
        "grid": style.GRID_COLOUR,
        "runs": [_run_data(run, points) for run in runs],
    }


def frames_note(runs: Sequence[Run], points: int) -> str:
    """Return which states the slider steps through."""
    strides = {
        run.name: int(strided(run.trajectory.n_steps + 1, points)[1])
        for run in runs
        if run.trajectory.n_steps >= points
    }
    if not strides:
        return "The slider steps through every recorded state."
    listed = ", ".join(f"every {stride}th state of {name}" for name, stride in strides.items())
    return f"Long run: the slider steps through {listed}."


def _run_data(run: Run, points: int) -> dict[str, Any]:
    trajectory = run.trajectory
    chosen = strided(trajectory.n_steps + 1, points)
    attitudes = series.attitudes(trajectory)
    momenta = series.momenta(trajectory)
    steps = np.minimum(chosen, trajectory.n_steps - 1)  # of the last state: the last step
    zones = run.scenario.controller.zones if run.scenario is not None else ()
    values = {form.name: forms.values(form, attitudes)[chosen] for form in forms.REPRESENTATIONS}
    return {
        "name": run.name,
        "count": len(chosen),
        "step": chosen.tolist(),
        "time": packed(series.state_times(trajectory)[chosen]),
        "attitude": packed(attitudes[chosen]),
        "reference": packed(series.references(trajectory)[chosen]),
        "error": packed(series.settling_error_deg(trajectory)[chosen]),
        "momentum": packed(momenta[chosen]),
        "torque": packed(trajectory.torque[steps]),
        "source": [source_name(int(s)) for s in trajectory.source[steps]],
        **{name: packed(array) for name, array in values.items()},
        "zones": [_zone_data(zone) for zone in zones],
    }


def _zone_data(zone: ZoneParameters) -> dict[str, Any]:
    axis = np.asarray(zone.inertial_axis) / np.linalg.norm(zone.inertial_axis)
    body_axis = np.asarray(zone.body_axis) / np.linalg.norm(zone.body_axis)
    named = [name for name, unit in _BODY_AXES.items() if np.allclose(body_axis, unit, atol=1e-12)]
    points = cap(axis, math.radians(zone.half_angle_deg))
    where = named[0] if named else "its boresight"
    return {
        "name": label(f"{zone.name}: {zone.kind} for {where}, {zone.half_angle_deg:.4g}°"),
        "kind": zone.kind,
        "colour": style.ZONE_COLOURS[zone.kind],
        "bodyAxis": body_axis.tolist(),
        "boresight": not named,
        "points": packed(points),
        "triangles": _triangles(),
        "border": packed(points[-_SECTORS:]),
    }


def cap(axis: Array, half_angle: float) -> Array:
    """Return points (1 + rings * sectors, 3) of the cap within ``half_angle`` [rad] of ``axis``.

    The centre first, then ring after ring; the last one is the border.
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
