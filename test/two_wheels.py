"""Flights with two wheels in tests: the spacecraft of config/afrl_two_wheel.yaml."""

from __future__ import annotations

from spacecraft_gnc.scenario import from_sections

SECTIONS = {
    "plant": {
        "vehicle": "two_wheel",
        "inertia": [430.0, 0.0, 0.0, 0.0, 1210.0, 0.0, 0.0, 0.0, 1300.0],
        "wheel_axes": [1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        "wheel_inertias": [0.043, 0.043],
        "max_wheel_speed": 100.0,
        "max_wheel_acceleration": 5.0,
        "time_step": 1.0,
        "duration": 800.0,
        "initial_euler_321": [0.5, 0.3, -0.4],
        "pose_every": 0,
    },
    "nmpc_controller": {"method": "underactuated", "time_step": 10.0},
    "reference_governor": {"target_rotation_vector": [0.0, 0.0, 0.0]},
}


def two_wheels(**changes):
    """Return sections with some values changed, by section name."""
    return {name: {**values, **changes.get(name, {})} for name, values in SECTIONS.items()}


def scenario_of(start=None, steps=80, **controller):
    """Return a scenario from 3-2-1 angles, over control steps."""
    plant = {"duration": 10.0 * steps}
    if start is not None:
        plant["initial_euler_321"] = [float(angle) for angle in start]
    return from_sections(two_wheels(plant=plant, nmpc_controller=controller))
