"""Checks of a scenario against its separation: desired formation and start."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation import hill
from spacecraft_gnc.vehicles.formation.geometry import pairs, separations
from spacecraft_gnc.vehicles.formation.orbit import mean_motion

_PLANT, _GOVERNOR = "plant", "reference_governor"
_ROUNDING: Final = 1e-9
"""Share of a distance."""


class Nearest(NamedTuple):
    """The two craft that come nearest to each other."""

    pair: tuple[int, int]
    distance: float
    """[m]"""

    def told(self, craft: Any) -> str:
        """Return both names."""
        first, second = self.pair
        return f"{craft[first]} and {craft[second]}"


def check(checked: Checked, samples: int) -> None:
    """Refuse a formation or a start in which two craft are nearer than they may be.

    Parameters
    ----------
    checked
        Without problems so far.
    samples
        Control steps of an orbit.
    """
    plant, governor = checked.section(_PLANT), checked.section(_GOVERNOR)
    governed = governor.governor == "time_shift"
    _check_formation(checked, plant, governor, samples, governed)
    _check_start(checked, plant, samples)


def start(plant: Any, samples: int) -> Array:
    """Return the states (n, 6) of the craft at the start, Hill's frame [m], [m/s]."""
    if plant.initial_position.size:
        return np.hstack([
            np.reshape(plant.initial_position, (-1, 3)), np.reshape(plant.initial_velocity, (-1, 3))
        ])  # fmt: skip
    return hill.start_states(
        mean_motion(plant.altitude),
        plant.radial_semi_axis,
        samples,
        plant.initial_phase,
        plant.initial_along_track_offset,
        plant.initial_amplitude,
    )


def nearest(positions: Array) -> Nearest:
    """Return the two craft that come nearest to each other at positions (..., n, 3) [m]."""
    apart = separations(positions)
    least = apart.reshape(-1, apart.shape[-1]).min(axis=0)
    first, second = pairs(positions.shape[-2])[np.argmin(least)].tolist()
    return Nearest((first, second), float(least.min()))


def desired(plant: Any, phases: Any, samples: int, checks: int = 1) -> Nearest:
    """Return the two craft that come nearest to each other in the desired formation.

    ``checks``: instants of each control step that are looked at.
    """
    fine = samples * checks
    natural = hill.natural_states(mean_motion(plant.altitude), plant.radial_semi_axis, fine)
    places = (np.arange(fine)[:, None] + np.array(phases) * checks) % fine
    return nearest(natural[places, :3])


def _check_formation(
    checked: Checked, plant: Any, governor: Any, samples: int, governed: bool
) -> None:
    margin = governor.separation_margin if governed else 0.0
    checks = governor.prediction_substeps if governed else 1
    found = desired(plant, governor.phase, samples, checks)
    if found.distance >= (plant.min_separation + margin) * (1.0 - _ROUNDING):
        return
    told = f"{found.told(plant.spacecraft)} come as near as {found.distance:.6g} m"
    if found.distance >= plant.min_separation:
        most = found.distance - plant.min_separation
        value = f"{margin!r} m, but {told} to each other in the desired formation"
        need = f"at most {most:.6g} m, what is left beyond min_separation there"
        checked.complain(_GOVERNOR, "separation_margin", value, need, "lower it")
        return
    value = f"{plant.radial_semi_axis!r} m, at which {told} in the desired formation"
    need = f"min_separation ({plant.min_separation:g} m) between all craft there"
    least = plant.radial_semi_axis * plant.min_separation / found.distance
    remedy = f"raise it to {math.ceil(least):g} m, or change reference_governor.phase"
    checked.complain(_PLANT, "radial_semi_axis", value, need, remedy)


def _check_start(checked: Checked, plant: Any, samples: int) -> None:
    found = nearest(start(plant, samples)[:, :3])
    if found.distance >= plant.min_separation * (1.0 - _ROUNDING):
        return
    name = "initial_position" if plant.initial_position.size else "initial_phase"
    told = f"{found.told(plant.spacecraft)} are {found.distance:.6g} m apart"
    value = f"{shown(checked.get(_PLANT, name))}, where {told}"
    need = f"at least min_separation ({plant.min_separation:g} m) between all craft at the start"
    checked.complain(_PLANT, name, value, need, "move one of them away")
