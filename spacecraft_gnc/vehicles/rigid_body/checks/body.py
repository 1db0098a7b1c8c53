"""Checks of the body: inertia, and existence of the integrator's step."""

from __future__ import annotations

import numpy as np

from spacecraft_gnc.parameters.checked import Checked
from spacecraft_gnc.parameters.parameter import specs_of
from spacecraft_gnc.parameters.problems import shown
from spacecraft_gnc.solvability import is_surely_free, largest_free_step
from spacecraft_gnc.vehicles.rigid_body.parameters.plant import PlantParameters


def check_inertia(checked: Checked) -> None:
    """Ask for the plant's inertia where the plant, or a controller without its own, needs it."""
    value = checked.get("plant", "inertia")
    needed = "plant" in checked.given or (
        "nmpc_controller" in checked.given and checked.get("nmpc_controller", "inertia") == []
    )
    if value == [] and needed:
        spec = dict(specs_of(PlantParameters))["inertia"]
        remedy = "add it, such as [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]"
        checked.complain("plant", "inertia", "nothing", spec.requirement, remedy)


def check_momentum(checked: Checked) -> None:
    """Check Kalabic (3) for the plant's step, and for the controller's prediction step."""
    momentum = checked.get("plant", "initial_momentum")
    for section in ("plant", "nmpc_controller"):
        body, step = checked.effective(section, "inertia"), checked.get(section, "time_step")
        if body and momentum and isinstance(step, float) and step > 0.0:
            problem = np.array(body).reshape(3, 3), np.array(momentum)
            if is_surely_free(*problem, step):
                continue
            largest = largest_free_step(*problem)
            if step > largest:
                need = (
                    "(h hat(Pi))^2 + 4 Jd^2 >= 0 (Kalabic et al. 2014, (3)) in free motion from "
                    f"plant.initial_momentum {shown(momentum)}: less than {largest:.6g} s"
                )
                remedy = "use a smaller time step, or less momentum"
                checked.complain(section, "time_step", f"{step!r} s", need, remedy)
