"""The closed loop and its seams, without ROS."""

from spacecraft_gnc.loop.closed_loop import ClosedLoop
from spacecraft_gnc.loop.protocols import (
    Command,
    Controller,
    Governor,
    GovernorDecision,
    Invariants,
    Plant,
    Reference,
    Source,
    Standstill,
    State,
)
from spacecraft_gnc.loop.trajectory import Trajectory

__all__ = [
    "ClosedLoop",
    "Command",
    "Controller",
    "Governor",
    "GovernorDecision",
    "Invariants",
    "Plant",
    "Reference",
    "Source",
    "Standstill",
    "State",
    "Trajectory",
]
