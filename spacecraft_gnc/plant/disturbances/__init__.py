"""Disturbances: external torques on the body, which the controller does not know."""

from spacecraft_gnc.plant.disturbances.parameters import DisturbanceParameters
from spacecraft_gnc.plant.disturbances.registry import build, names, not_installed, refusals
from spacecraft_gnc.plant.disturbances.torques import Disturbance, Disturbances, Motion

__all__ = [
    "Disturbance",
    "DisturbanceParameters",
    "Disturbances",
    "Motion",
    "build",
    "names",
    "not_installed",
    "refusals",
]
