"""Check measured states: the truth, and noise of the scenario's seed drawn again."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.plant.random_numbers import standard_normals
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.audit.equations import rotations
from spacecraft_gnc.vehicles.docking.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.docking.signals import STATE

_PARTS: Final = {
    "port_offset": "position",
    "port_velocity": "velocity",
    "attitude": "attitude",
    "angular_velocity": "rate",
}
"""Stream of the noise of each part, after ``navigation.``; its parameter ends in ``_noise``."""
_CHECK: Final = "measured = truth and noise of the seed"
_ROUNDING: Final = 1e-14


def audit_navigation(evidence: Evidence, ledger: Ledger) -> None:
    """Measure every state again: bit for bit, but for the rounding of a turned attitude."""
    steps, plant = evidence.columns[STATE].steps, evidence.scenario.plant
    for name, part in _PARTS.items():
        truth = evidence.rows(STATE, name, steps)
        where, told = f"{STATE}.measured_{name}", evidence.rows(STATE, f"measured_{name}", steps)
        noise = _noise(plant, part, steps)
        if noise is None:
            ledger.compare(_CHECK, steps, {where: told}, {where: truth})
        elif name == "attitude":
            turned = rotations(noise) @ truth.reshape(-1, 3, 3)
            off = told - turned.reshape(-1, 9)
            ledger.bound(f"{_CHECK}, attitude", steps, where, off, _ROUNDING)
        else:
            ledger.compare(_CHECK, steps, {where: told}, {where: truth + noise})


def _noise(plant: PlantParameters, part: str, steps: NDArray[np.int64]) -> Array | None:
    """Return the noise (m, 3) of a part in steps; None: it is measured without."""
    deviation: float = getattr(plant, f"{part}_noise")
    if not deviation or not steps.size:
        return None
    stream = f"navigation.{part}"
    drawn = [standard_normals(plant.seed, plant.run, stream, k, 3) for k in steps.tolist()]
    return deviation * np.array(drawn)
