"""Closed loop and its interfaces, without ROS."""

from spacecraft_gnc.loop.closed_loop import ClosedLoop
from spacecraft_gnc.loop.flight import Flight
from spacecraft_gnc.loop.protocols import (
    Command,
    Controller,
    Governor,
    GovernorDecision,
    Plant,
    Reference,
    Source,
    State,
)

__all__ = [
    "ClosedLoop",
    "Command",
    "Controller",
    "Flight",
    "Governor",
    "GovernorDecision",
    "Plant",
    "Reference",
    "Source",
    "State",
]
