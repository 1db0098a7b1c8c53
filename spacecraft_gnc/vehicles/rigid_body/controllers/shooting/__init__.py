"""``method: shooting``: Newton's method on the first-order conditions."""

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import NewtonParameters
from spacecraft_gnc.vehicles.vehicle import Method

METHOD: Final = Method(
    name="shooting",
    build=Lazy(
        "spacecraft_gnc.vehicles.rigid_body.controllers.solvers:ShootingController.from_scenario"
    ),
    parameters=NewtonParameters,
    variants=("exact", "estimated_du", "estimated_u"),
    certifier=Lazy("spacecraft_gnc.vehicles.rigid_body.audit.plans:of_penalties"),
)
