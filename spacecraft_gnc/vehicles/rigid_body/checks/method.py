"""Checks of the method: horizon, nominal run, level of the governor."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.vehicles.rigid_body.chosen import (
    is_governed,
    method_reads,
    own_method,
    reads_all,
)
from spacecraft_gnc.vehicles.rigid_body.controllers import feedback
from spacecraft_gnc.vehicles.rigid_body.controllers.feedback import FeedbackParameters
from spacecraft_gnc.vehicles.rigid_body.controllers.neighboring_extremal import (
    NeighboringParameters,
)
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import OcpParameters
from spacecraft_gnc.vehicles.vehicle import Method

_CONTROLLER: Final = "nmpc_controller"
_GOVERNOR: Final = "reference_governor"
_LONGEST_EXAMINED: Final = 1000  # steps: some seconds of computation before the flight
_OF_A_NOMINAL_RUN: Final = ("nominal_momentum", "exact_every")


def check_method(checked: Checked) -> None:
    """Add a problem for each value that the method of this package cannot use."""
    method = own_method(checked)
    if method is None:
        return
    _check_horizon(checked, method)
    _check_level(checked, method)
    if not method_reads(checked, NeighboringParameters):
        return
    if checked.get(_CONTROLLER, "nominal_rotation_vector") != []:
        return
    for name in _OF_A_NOMINAL_RUN:
        if checked.is_changed(_CONTROLLER, name):
            need = "nominal_rotation_vector beside it, as there is no nominal run without"
            _complain(checked, name, need, "give nominal_rotation_vector, or remove it")


def _check_horizon(checked: Checked, method: Method) -> None:
    """Refuse a horizon with which the look at the start, before the flight, takes minutes."""
    horizon = checked.get(_CONTROLLER, "horizon")
    if is_governed(checked) and reads_all(method, OcpParameters):
        law = checked.get(_GOVERNOR, "governor")
        who = f"behind reference_governor.governor: {law}, which predicts the whole flight"
    elif method.refuses_starts:
        who = f"of method: {method.name}, which has to be feasible at the start"
    else:
        return
    if isinstance(horizon, int) and horizon > _LONGEST_EXAMINED:
        _complain(checked, "horizon", f"at most {_LONGEST_EXAMINED} steps {who}", "shorten it")


def _check_level(checked: Checked, method: Method) -> None:
    """Refuse the level of an invariant set where the method has none."""
    name = "lyapunov_level"
    if reads_all(method, FeedbackParameters) or not is_governed(checked):
        return
    if checked.is_changed(_GOVERNOR, name):
        need = (
            f"nmpc_controller.method: {feedback.METHOD.name} beside it, not {method.name}: "
            "no other has a level"
        )
        checked.complain(_GOVERNOR, name, shown(checked.get(_GOVERNOR, name)), need, "remove it")


def _complain(checked: Checked, name: str, need: str, remedy: str) -> None:
    checked.complain(_CONTROLLER, name, shown(checked.get(_CONTROLLER, name)), need, remedy)
