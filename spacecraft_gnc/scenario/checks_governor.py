"""Whether the governor reads what is given for it."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.scenario import registry
from spacecraft_gnc.scenario.checked import Checked

_GOVERNOR: Final = "reference_governor"
_ATTITUDE: Final = "attitude"
OF_ATTITUDE: Final = (
    "initial_reference_rotation_vector",
    "max_torque",
    "max_momentum",
    "steady_margin_deg",
    "lyapunov_level",
    "prediction_horizon",
    "alpha_tolerance",
    "cut_point_shift",
    "route",
    "route_clearance_deg",
)
"""Parameters that only ``governor: attitude`` reads."""


def check_governor_parameters(checked: Checked) -> None:
    """Add a problem for each parameter that the governor would ignore.

    A default that is stated changes nothing; a governor or a method of another package may read
    anything.
    """
    governor = checked.get(_GOVERNOR, "governor")
    if governor not in registry.BUILT_IN["governors"]:
        return
    if governor != _ATTITUDE:
        for name in OF_ATTITUDE:
            if checked.is_changed(_GOVERNOR, name):
                need = f"a governor that reads it ({_ATTITUDE}), not {governor}"
                _complain(checked, name, need, f"remove it, or set governor: {_ATTITUDE}")
        return
    method = checked.get("nmpc_controller", "method")
    if (
        method != "feedback"
        and method in registry.BUILT_IN["controllers"]
        and checked.is_changed(_GOVERNOR, "lyapunov_level")
    ):
        need = f"nmpc_controller.method: feedback beside it, not {method}: no other has a level"
        _complain(checked, "lyapunov_level", need, "remove it")


def _complain(checked: Checked, name: str, need: str, remedy: str) -> None:
    checked.complain(_GOVERNOR, name, shown(checked.get(_GOVERNOR, name)), need, remedy)
