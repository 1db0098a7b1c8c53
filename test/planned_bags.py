"""Bags of flights along plans: figure 4 of Phogat et al. in coarser steps, pushed off its plan."""

from __future__ import annotations

import copy

from flown_bags import fly
from recording.bags import CODEC

from spacecraft_gnc import lie

INERTIA = [800.0, 0.0, 0.0, 0.0, 1200.0, 0.0, 0.0, 0.0, 1000.0]
LEAD = 3
NS = 250_000_000  # control period [ns]
KEPT = "command = what the tracking asks for, within the bounds"
PLAN = {
    "duration": 22.0,
    "torque_bounds": [20.0],
    "momentum_bounds": [70.0],
    "torque_reserve": 0.1,
    "momentum_reserve": 0.2,
    "replan_error_deg": 2.0,
    "replan_lead": LEAD,
}
SECTIONS = {
    "plant": {
        "inertia": [1.1 * moment for moment in INERTIA],
        "time_step": 0.25,
        "duration": 30.0,
        "initial_rotation_vector": [0.0, 0.0, 0.0],
        "initial_momentum": [30.0, -10.0, 10.0],
        "disturbances": ["push"],
        "push_torque": [0.0, 0.0, -40.0],
        "push_time": 8.0,
        "push_duration": 1.5,
    },
    "nmpc_controller": {
        "method": "planned",
        "inertia": INERTIA,
        "time_step": 0.25,
        "settling_time": 8.0,
    },
    "reference_governor": {"target_rotation_vector": [0.9, 0.9, 0.9]},
}
"""Pushed off its plan, so that another one is made."""
OTHER_TARGET = {60: lie.exp([0.2, 1.0, 0.5])}


def planned(plan=None, **changes):
    """Return sections of ``method: planned``, some values changed, by section name."""
    sections = copy.deepcopy(SECTIONS)
    for name, values in changes.items():
        sections[name].update(values)
    sections["nmpc_controller"].update(_flat(plan or {}))
    return sections


def governed(plan=None, **changes):
    """Return sections of ``governor: planned``."""
    sections = copy.deepcopy(SECTIONS)
    sections["nmpc_controller"]["method"] = "shooting"
    sections["reference_governor"].update({"governor": "planned", **_flat(plan or {})})
    sections["plant"]["duration"] = 40.0
    for name, values in changes.items():
        sections[name].update(values)
    return sections


def _flat(plan):
    return {f"plan.{name}": value for name, value in (PLAN | plan).items()}


def fly_planned(folder, **options):
    """Fly along a plan and another one; return the bag."""
    return fly(folder, planned(), **options)


def failed(audit):
    """Return the names of the checks that failed."""
    return {check.name for check in audit.checks if check.verdict == "FAIL"}


def lines(audit):
    """Return the checks by name."""
    return {check.name: check for check in audit.checks}


def moved(*by):
    """Return a change of a Vector3."""

    def change(old):
        return CODEC.vector([old.x + by[0], old.y + by[1], old.z + by[2]])

    return change
