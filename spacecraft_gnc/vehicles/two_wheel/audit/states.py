"""Recorded states, in the form of the cores."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.types import read_only
from spacecraft_gnc.vehicles.two_wheel.signals import STATE
from spacecraft_gnc.vehicles.two_wheel.state import WheelState


def recorded_states(evidence: Evidence, steps: NDArray[np.int64]) -> list[WheelState]:
    """Return the states of steps (m,)."""
    attitudes, rates, speeds, total = (
        read_only(evidence.rows(STATE, name, steps))
        for name in ("attitude", "angular_velocity", "wheel_speed", "total_momentum")
    )
    healthy = evidence.rows(STATE, "healthy", steps) != 0.0
    told = read_only(evidence.rows(STATE, "applied_acceleration", steps))
    return [
        WheelState(
            step, attitudes[i].reshape(3, 3), rates[i], speeds[i], total[i], healthy[i], told[i]
        )
        for i, step in enumerate(steps.tolist())
    ]
