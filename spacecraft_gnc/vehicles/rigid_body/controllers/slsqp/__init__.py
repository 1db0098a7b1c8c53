"""``method: slsqp``: scipy's sequential quadratic programming, the papers' baseline."""

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import PenalizedParameters
from spacecraft_gnc.vehicles.vehicle import Method

METHOD: Final = Method(
    name="slsqp",
    build=Lazy(
        "spacecraft_gnc.vehicles.rigid_body.controllers.solvers:SlsqpController.from_scenario"
    ),
    parameters=PenalizedParameters,
    hard_limits=True,
    certifier=Lazy("spacecraft_gnc.vehicles.rigid_body.audit.plans:of_constraints"),
)
