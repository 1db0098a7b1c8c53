"""Time shift governor of spacecraft that form up on one natural motion."""

from spacecraft_gnc.governors.time_shift.decision import Answer, TimeShiftDecision
from spacecraft_gnc.governors.time_shift.governor import (
    TimeShiftGovernor,
    require_admissible,
    start_violation,
)
from spacecraft_gnc.governors.time_shift.margins import Constraint, Margin
from spacecraft_gnc.governors.time_shift.monitor import CraftMonitor
from spacecraft_gnc.governors.time_shift.problem import TimeShiftProblem

__all__ = [
    "Answer",
    "Constraint",
    "CraftMonitor",
    "Margin",
    "TimeShiftDecision",
    "TimeShiftGovernor",
    "TimeShiftProblem",
    "require_admissible",
    "start_violation",
]
