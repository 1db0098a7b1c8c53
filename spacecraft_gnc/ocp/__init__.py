"""Optimal control problems on SO(3) and their solvers."""

from spacecraft_gnc.ocp.problem import AttitudeOcp, Weights
from spacecraft_gnc.ocp.shooting import ShootingOptions, ShootingSolver
from spacecraft_gnc.ocp.solution import Solution, Status
from spacecraft_gnc.ocp.zones import PointingZone

__all__ = [
    "AttitudeOcp",
    "PointingZone",
    "ShootingOptions",
    "ShootingSolver",
    "Solution",
    "Status",
    "Weights",
]
