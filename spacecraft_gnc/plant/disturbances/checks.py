"""Check of a scenario: whether the disturbances that it lists can be built."""

from __future__ import annotations

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.problems import problem_of
from spacecraft_gnc.plant.disturbances.registry import not_installed, refusals
from spacecraft_gnc.types import ArrayLike, as_inertia


def check_disturbances(checked: Checked, inertia: ArrayLike, section: str = "plant") -> None:
    """Add a problem for each disturbance that cannot be built.

    Silent where a value of the section was refused already, and of a flight that is over where one
    is not installed: its torque was recorded.

    Parameters
    ----------
    checked : Checked
    inertia : (3, 3) array
        Inertia of the whole spacecraft, body frame [kg m^2].
    section : str
        That has the parameters of the disturbances.
    """
    names = [declaration.name for declaration in checked.declarations(section)]
    if not checked.get(section, "disturbances") or None in (checked.get(section, n) for n in names):
        return
    parameters = checked.section(section)
    if checked.is_over and not_installed(parameters):
        return
    for error in refusals(parameters, as_inertia("inertia", inertia)):
        problem = problem_of(error, checked.source, section, names)
        if problem is None:  # a plug-in's, of another form
            raise error
        name = str(error).partition(":")[0]
        checked.complain(section, name, problem.value, problem.requirement, problem.remedy)
