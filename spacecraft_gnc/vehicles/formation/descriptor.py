"""Descriptor of the formation: what the rest of the package asks it for."""

from __future__ import annotations

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.formation.controllers.methods import METHODS
from spacecraft_gnc.vehicles.formation.governors.laws import LAWS
from spacecraft_gnc.vehicles.formation.parameters.controller import ControllerParameters
from spacecraft_gnc.vehicles.formation.parameters.governor import GovernorParameters
from spacecraft_gnc.vehicles.formation.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.vehicle import Vehicle


def _lazy(target: str) -> Lazy:
    return Lazy(f"{__package__}.{target}")


VEHICLE: Final = Vehicle(
    name="formation",
    description="several spacecraft that form up relative to a circular orbit",
    sections={
        "plant": PlantParameters,
        "nmpc_controller": ControllerParameters,
        "reference_governor": GovernorParameters,
    },
    methods=METHODS,
    governors=LAWS,
    craft=_lazy("craft:craft"),
    plant=_lazy("build:plant"),
    checks=_lazy("checks:check"),
    defaults=_lazy("parameters.defaults:formulas"),
    flight=_lazy("flight:FormationFlight"),
    columns=_lazy("recorded:read_recorded"),
    facts=_lazy("facts:facts"),
    warmup=_lazy("warmup:WARMUP"),
    audit=_lazy("audit.flight:AUDIT"),
    metrics=_lazy("summary:metrics"),
    summary=_lazy("summary:lines"),
    figures=_lazy("pictures:FIGURES"),
    report=_lazy("report:REPORT"),
    live=_lazy("live:LIVE"),
    resolve=_lazy("resolve:REPLAY"),
    signals=_lazy("signals:SIGNALS"),
    outputs=_lazy("outputs:Outputs"),
)
