"""What a governor knows of a loop does not depend on the size of the body."""

from __future__ import annotations

import numpy as np
import pytest

from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.scenario import from_sections

INERTIA = np.diag([1.0, 0.8, 0.8])


@pytest.mark.parametrize(("moment", "torque"), [(1e-3, 1e-6), (1e8, 1e3), (1e8, 1e-6)])
def test_governed_feedback_settles_as_soon_at_any_size(moment: float, torque: float) -> None:
    """In units of its settling time; ill-conditioned matrices would warn."""

    def settled(mass: float, limit: float) -> float:
        scenario = from_sections(
            {
                "plant": {
                    "inertia": (mass * INERTIA).ravel(),
                    "initial_rotation_vector": [0.05, 0.0, 1.0],
                },
                "nmpc_controller": {"max_torque": limit, "method": "feedback"},
                "reference_governor": {"governor": "attitude"},
            }
        )
        metrics = summarize(scenario.build().run(), scenario)
        return float(metrics["settle_time_0.1deg"]) / scenario.controller.settling_time

    assert settled(moment, torque) == pytest.approx(settled(1.0, 0.01), rel=0.02)
