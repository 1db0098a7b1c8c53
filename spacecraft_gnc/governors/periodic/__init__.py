"""Reference governor of a stable periodic linear loop: off-line sets, on-line quadratic program."""

from spacecraft_gnc.governors.periodic.cache import cached_sets
from spacecraft_gnc.governors.periodic.governor import PeriodicDecision, PeriodicGovernor
from spacecraft_gnc.governors.periodic.problem import PeriodicConstraints, PeriodicLoop
from spacecraft_gnc.governors.periodic.recursion import SetOptions, admissible_sets
from spacecraft_gnc.governors.periodic.sets import AdmissibleSet, AdmissibleSets
from spacecraft_gnc.governors.periodic.steady import EmptySetError

__all__ = [
    "AdmissibleSet",
    "AdmissibleSets",
    "EmptySetError",
    "PeriodicConstraints",
    "PeriodicDecision",
    "PeriodicGovernor",
    "PeriodicLoop",
    "SetOptions",
    "admissible_sets",
    "cached_sets",
]
