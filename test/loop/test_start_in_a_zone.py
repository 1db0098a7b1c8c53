"""A flight that begins inside a soft zone leaves it, for good, and reaches the target."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.scenario import load

IN_THE_PLANE = [0.0, 0.0, 0.4]  # 1 deg from the axis of the cone, which lies across the way
ON_THE_AXIS = [0.0, 0.0, 0.38288]  # to 1e-3 deg: the penalty hardly knows a direction
OUT_OF_PLANE = [0.0, 0.06, 0.38]
TURNED_ROUND = {  # the same zone, told as the cone to stay inside
    "nmpc_controller.zones.star.kind": "inclusion",
    "nmpc_controller.zones.star.inertial_axis": [-0.9276, -0.3736, 0.0],
    "nmpc_controller.zones.star.half_angle_deg": 175.0,
}


@pytest.mark.parametrize(
    ("start", "changes"),
    [
        (IN_THE_PLANE, {}),
        (ON_THE_AXIS, {}),
        (OUT_OF_PLANE, {}),
        (IN_THE_PLANE, TURNED_ROUND),
        (IN_THE_PLANE, {"nmpc_controller.method": "neighboring_extremal"}),
        (OUT_OF_PLANE, {"nmpc_controller.method": "slsqp", "plant.duration": 220.0}),
    ],
    ids=["plane", "axis", "off the plane", "inclusion", "neighboring", "slsqp"],
)
def test_it_flies_out(start: list[float], changes: dict[str, Any]) -> None:
    scenario = load("gupta2015_case2", {"plant.initial_rotation_vector": start, **changes})
    assert sum("leaves it" in warning for warning in scenario.warnings) == 1
    loop = scenario.build()
    flown = loop.run()
    margins = np.degrees(loop.controller.solver.ocp.zones[0].margin(flown.attitude))
    assert margins[0] < 0.0
    left = int(np.flatnonzero(margins < 0.0)[-1]) + 1
    assert left < 100  # of 750 steps, or 550
    assert margins[-1] > 15.0
    assert np.degrees(lie.angle_between(np.eye(3), flown.final_attitude)) < 0.01
