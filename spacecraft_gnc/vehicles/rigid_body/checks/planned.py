"""Checks of a planned transfer: whether what flies it and what stands beside it go together."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.vehicles.rigid_body.chosen import own_law, own_method
from spacecraft_gnc.vehicles.rigid_body.controllers import planned, shooting
from spacecraft_gnc.vehicles.rigid_body.governors.laws import NONE, PLANNED

_CONTROLLER: Final = "nmpc_controller"
_GOVERNOR: Final = "reference_governor"


def check_planned(checked: Checked) -> None:
    """Add a problem for each value that a plan cannot be flown with."""
    if own_method(checked) is planned.METHOD:
        _check_law(checked)
        _check_tracking(checked)
        _check_zones(checked, f"method: {planned.METHOD.name}")
    elif own_law(checked) is PLANNED:
        _check_zones(checked, f"governor: {PLANNED.name}")


def _check_law(checked: Checked) -> None:
    """Refuse a governor that leads the reference, which is the target that is planned for."""
    law = own_law(checked)
    if law is None or law is NONE:
        return
    need = f"governor: {NONE.name} beside method: {planned.METHOD.name}, which plans to the target"
    remedy = f"remove it, or set method: {shooting.METHOD.name}"
    checked.complain(_GOVERNOR, "governor", shown(law.name), need, remedy)


def _check_tracking(checked: Checked) -> None:
    """Refuse limits of the tracking that the planner does not know."""
    beside = f"beside method: {planned.METHOD.name}, whose bounds are on the body torque"
    if checked.get(_CONTROLLER, "max_torque") not in (None, 0.0):
        need = f"0.0, no limit on the norm, {beside}"
        _complain(checked, "max_torque", need, "give plan.torque_bounds")
    actuators = checked.get(_CONTROLLER, "actuators")
    if actuators and np.linalg.matrix_rank(np.array(actuators).reshape(3, -1)) < 3:
        need = f"actuators that give torques about every axis {beside}"
        _complain(checked, "actuators", need, "add the missing one, or remove them all")


def _check_zones(checked: Checked, who: str) -> None:
    if checked.get(_CONTROLLER, "zone_names") not in (None, []):
        need = f"none beside {who}: a plan knows no pointing zones"
        _complain(checked, "zone_names", need, "remove them, or set another one")


def _complain(checked: Checked, name: str, need: str, remedy: str) -> None:
    checked.complain(_CONTROLLER, name, shown(checked.get(_CONTROLLER, name)), need, remedy)
