"""Checks of a scenario that is flown by ``method: fault_tolerant``."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown

_CONTROLLER: Final = "nmpc_controller"
_OF_EACH_WHEEL: Final = ("wheel_viscous_friction", "wheel_coulomb_friction")


def check(checked: Checked) -> None:
    """Check that friction is believed of each wheel, or of none."""
    axes = checked.effective(_CONTROLLER, "wheel_axes")
    m = np.size(axes) // 3 if axes else 0
    for name in _OF_EACH_WHEEL:
        value = checked.get(_CONTROLLER, name)
        if value and m and np.size(value) != m:
            need = f"{m} numbers, one for each column of wheel_axes, or none"
            checked.complain(_CONTROLLER, name, shown(value), need, "write one for each wheel")
