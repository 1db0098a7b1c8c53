"""Descriptor of the rigid body: what the rest of the package asks it for."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.rigid_body.controllers.methods import METHODS, ControllerParameters
from spacecraft_gnc.vehicles.rigid_body.governors.laws import LAWS
from spacecraft_gnc.vehicles.rigid_body.parameters.governor import GovernorParameters
from spacecraft_gnc.vehicles.rigid_body.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.vehicle import Vehicle


def _lazy(target: str) -> Lazy:
    return Lazy(f"{__package__}.{target}")


VEHICLE: Final = Vehicle(
    name="rigid_body",
    description="rigid spacecraft turned by a body torque",
    sections={
        "plant": PlantParameters,
        "nmpc_controller": ControllerParameters,
        "reference_governor": GovernorParameters,
    },
    methods=METHODS,
    governors=LAWS,
    plant=_lazy("plant:RigidBodyPlant.from_scenario"),
    flight=_lazy("flight:RigidBodyFlight"),
    checks=_lazy("checks.all:check"),
    defaults=_lazy("parameters.defaults:formulas"),
    former_defaults=_lazy("parameters.former:former_defaults"),
    facts=_lazy("facts:facts"),
    planner=_lazy("planner.planner:PLANNER"),
    outlook=_lazy("outlook:outlook"),
    revision=_lazy("revision:without_start_and_target"),
    warmup=_lazy("warmup:WARMUP"),
    columns=_lazy("recorded:read_recorded"),
    audit=_lazy("audit.flight:AUDIT"),
    metrics=_lazy("metrics.summary:summarize"),
    summary=_lazy("metrics.rows:summary_rows"),
    figures=_lazy("pictures:FIGURES"),
    report=_lazy("report:REPORT"),
    live=_lazy("live:LIVE"),
    signals=_lazy("signals:SIGNALS"),
    outputs=_lazy("outputs:Outputs"),
    resolve=_lazy("resolve:REPLAY"),
)
