"""``method: fsolve``: MINPACK on the shooting equations, the papers' other baseline."""

from typing import Final

from spacecraft_gnc.lazy import Lazy
from spacecraft_gnc.vehicles.rigid_body.parameters.ocp import PenalizedParameters
from spacecraft_gnc.vehicles.vehicle import Method

METHOD: Final = Method(
    name="fsolve",
    build=Lazy(
        "spacecraft_gnc.vehicles.rigid_body.controllers.solvers:FsolveController.from_scenario"
    ),
    parameters=PenalizedParameters,
    certifier=Lazy("spacecraft_gnc.vehicles.rigid_body.audit.plans:of_equations"),
)
