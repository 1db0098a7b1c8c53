"""Every check of a rigid body's scenario."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.plant.disturbances.checks import check_disturbances
from spacecraft_gnc.vehicles.rigid_body.checks.actuators import check_actuators
from spacecraft_gnc.vehicles.rigid_body.checks.body import check_inertia, check_momentum
from spacecraft_gnc.vehicles.rigid_body.checks.method import check_method
from spacecraft_gnc.vehicles.rigid_body.checks.planned import check_planned
from spacecraft_gnc.vehicles.rigid_body.checks.pointing import check_pointing
from spacecraft_gnc.vehicles.rigid_body.checks.reference import check_reference
from spacecraft_gnc.vehicles.rigid_body.checks.target import check_target
from spacecraft_gnc.vehicles.rigid_body.checks.torque import check_torque


def check(checked: Checked) -> None:
    """Add a problem for each pair of values that do not fit together."""
    check_method(checked)
    check_inertia(checked)
    check_momentum(checked)
    check_pointing(checked)
    check_target(checked)
    check_reference(checked)
    check_planned(checked)
    check_torque(checked)
    check_actuators(checked)
    inertia = checked.get("plant", "inertia")
    if inertia:
        check_disturbances(checked, np.reshape(inertia, (3, 3)))
