"""Defaults that follow from the reference orbit: control period and duration.

The formulas stand in words beside their parameters; docs/scenario.md prints them.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Final

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.formulas import Formula, Missing
from spacecraft_gnc.parameters.parameter import Value
from spacecraft_gnc.vehicles.formation.orbit import SAMPLES, orbital_period

_PLANT: Final = "plant"
_ORBITS: Final = 3
_SLACK: Final = 1e-9
"""By which a default duration is longer, so that its last step is whole."""


def formulas(checked: Checked) -> Iterator[Formula]:
    """Yield the formula of each default, in the order of their dependence."""
    yield Formula(_PLANT, "time_step", partial(_time_step, checked))
    yield Formula(_PLANT, "duration", partial(_duration, checked))


def _period(checked: Checked) -> float:
    altitude = checked.get(_PLANT, "altitude")
    if not isinstance(altitude, float):
        raise Missing
    return orbital_period(altitude)


def _time_step(checked: Checked) -> Value:
    given = checked.get("nmpc_controller", "time_step")
    return given if isinstance(given, float) and given > 0.0 else _period(checked) / SAMPLES


def _duration(checked: Checked) -> Value:
    return _ORBITS * _period(checked) * (1.0 + _SLACK)
