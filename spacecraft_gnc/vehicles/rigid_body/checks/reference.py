"""Checks of a moving reference: its trajectory, and a method that tracks it."""

from __future__ import annotations

from typing import Final

import numpy as np

from spacecraft_gnc.errors import GncError
from spacecraft_gnc.governors.moving import StoredTrajectory, attitudes_of
from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import problem_of, shown
from spacecraft_gnc.vehicles.rigid_body.chosen import method_reads, own_law
from spacecraft_gnc.vehicles.rigid_body.controllers import terminal_set
from spacecraft_gnc.vehicles.rigid_body.controllers.neighboring_extremal import (
    NeighboringParameters,
)
from spacecraft_gnc.vehicles.rigid_body.governors.laws import NONE, PLANNED, STORED, TURNING

_CONTROLLER: Final = "nmpc_controller"
_GOVERNOR: Final = "reference_governor"
_TABLE: Final = ("times", "rotation_vectors", "angular_velocities")


def check_reference(checked: Checked) -> None:
    """Add a problem for each reason why a moving reference could not be flown."""
    law = own_law(checked)
    if law is None or not (law.moves or law is PLANNED):
        return
    _check_method(checked, law.name)
    if law is TURNING and checked.get(_GOVERNOR, "reference_rate") == [0.0, 0.0, 0.0]:
        need, remedy = "a rate that is not zero", f"give it, or set governor: {NONE.name}"
        checked.complain(_GOVERNOR, "reference_rate", "[0.0, 0.0, 0.0] rad/s", need, remedy)
    if law is STORED:
        _check_table(checked)


def _check_method(checked: Checked, law: str) -> None:
    """Refuse methods that lead to rest."""
    need = f"a method that follows a moving reference (governor: {law})"
    method = checked.get(_CONTROLLER, "method")
    if method == terminal_set.METHOD.name:
        value = f"{shown(method)}, whose terminal set lies around rest"
        checked.complain(_CONTROLLER, "method", value, need, "set method: shooting")
    name = "nominal_rotation_vector"
    if method_reads(checked, NeighboringParameters) and checked.get(_CONTROLLER, name):
        value = f"{shown(checked.get(_CONTROLLER, name))}, of a stored run that leads to rest"
        checked.complain(_CONTROLLER, name, value, need, "remove it: corrections on line follow")


def _check_table(checked: Checked) -> None:
    """Have the rows of a trajectory read, as the governor reads them."""
    name = "target_rotation_vector"
    if checked.is_changed(_GOVERNOR, name):
        need = "none beside governor: stored_trajectory, which starts at its first row"
        checked.complain(_GOVERNOR, name, shown(checked.get(_GOVERNOR, name)), need, "remove it")
    names = [f"trajectory.{part}" for part in _TABLE]
    values = [checked.get(_GOVERNOR, name) for name in names]
    if None in values:
        return
    for name, value in zip(names, values, strict=True):
        if value == []:
            need = "a row for each time of the trajectory (governor: stored_trajectory)"
            checked.complain(_GOVERNOR, name, "nothing", need, "add it")
    if [] in values:
        return
    times, vectors, rates = (np.array(value) for value in values)
    try:
        rows = attitudes_of(vectors.reshape(-1, 3))
        StoredTrajectory(times, rows, rates.reshape(-1, 3), np.eye(3), 1.0)
    except GncError as error:
        problem = problem_of(error, checked.source, _GOVERNOR, names)
        if problem is None:
            raise
        what = str(error).partition(":")[0].partition("[")[0].replace("attitudes", _TABLE[1])
        checked.complain(
            _GOVERNOR, f"trajectory.{what}", problem.value, problem.requirement, problem.remedy
        )
