"""Pose of the deputy that follows from a recorded state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Evidence, Telemetry
from spacecraft_gnc.audit.telemetry import NO_POSES, poses
from spacecraft_gnc.vehicles.docking.signals import POSE, STATE


def _values(evidence: Evidence, steps: NDArray[np.int64]) -> Sequence[Any]:
    plant = evidence.scenario.plant
    offsets = evidence.rows(STATE, "port_offset", steps)
    attitudes = evidence.rows(STATE, "attitude", steps).reshape(-1, 3, 3)
    told = []
    for offset, attitude in zip(offsets, attitudes, strict=True):
        center = plant.chief_port + offset - attitude @ plant.deputy_port
        known = np.isfinite(attitude).all()
        told.append([center, lie.to_quaternion_xyzw(attitude) if known else np.full(4, np.nan)])
    return told


POSES: Final = Telemetry(POSE, poses, _values, NO_POSES)
