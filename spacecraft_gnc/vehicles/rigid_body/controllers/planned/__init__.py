"""``method: planned``: an optimal transfer within bounds, tracked by Newton's NMPC."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.parameters.parameter import group
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import NewtonParameters
from spacecraft_gnc.vehicles.rigid_body.parameters.plan import PlanParameters
from spacecraft_gnc.vehicles.vehicle import Method


@dataclass(frozen=True, kw_only=True, eq=False, init=False, repr=False)
class PlannedParameters(NewtonParameters):
    """Parameters of ``method: planned``: those of the tracking, and those of the plan."""

    plan: PlanParameters = group(PlanParameters)


METHOD: Final = Method(
    name="planned",
    build=Lazy(f"{__package__}.controller:PlannedController.from_scenario"),
    parameters=PlannedParameters,
    variants=("exact", "estimated_du", "estimated_u"),
    refuses_starts=True,
    certifier=Lazy("spacecraft_gnc.vehicles.rigid_body.audit.plans:of_tracking"),
)
