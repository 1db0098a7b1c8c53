"""Time shift governor of spacecraft that form up on one natural motion."""

from spacecraft_gnc.governors.time_shift.closed_loop import (
    NEVER,
    FormationFlight,
    fly,
    fly_unshifted,
)
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
    "NEVER",
    "Answer",
    "Constraint",
    "CraftMonitor",
    "FormationFlight",
    "Margin",
    "TimeShiftDecision",
    "TimeShiftGovernor",
    "TimeShiftProblem",
    "fly",
    "fly_unshifted",
    "require_admissible",
    "start_violation",
]
