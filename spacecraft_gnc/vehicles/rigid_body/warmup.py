"""Short flights that compile every kernel of a rigid body."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from spacecraft_gnc.ocp import ShootingSolver
from spacecraft_gnc.vehicles.rigid_body.audit import motion
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier
from spacecraft_gnc.vehicles.rigid_body.controllers.methods import METHODS
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of
from spacecraft_gnc.vehicles.rigid_body.governors.laws import ATTITUDE
from spacecraft_gnc.vehicles.rigid_body.planner.planner import PLANNER
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

_SPHEROID: Final = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]  # [kg m^2]
_ZONE: Final = {
    "kind": "exclusion",
    "body_axis": [1.0, 0.0, 0.0],
    "inertial_axis": [0.0, 0.0, 1.0],
    "half_angle_deg": 5.0,
}
_OF_A_METHOD: Final[Mapping[str, dict[str, Any]]] = {
    "terminal_set": {"max_torque": 0.0},  # the set is within reach
    "planned": {"zone_names": [], "zones": {}, "plan": {"duration": 0.8}},  # a plan knows no zones
}
_TARGET: Final = {"target_rotation_vector": [0.1, 0.0, 0.0], "max_momentum": 1.0}
_PREDICTED: Final = ("feedback", "shooting")
"""Methods whose closed loop is predicted in compiled code."""


def flights() -> Iterator[dict[str, Any]]:
    """Yield scenarios, by section: every method and variant, and each compiled prediction."""
    for method in METHODS:
        for variant in method.variants or ("exact",):
            own = _OF_A_METHOD.get(method.name, {})
            yield _flight({"method": method.name, "variant": variant, **own})
    yield _flight({"method": "neighboring_extremal", "nominal_rotation_vector": [0.0, 0.0, 0.1]})
    for name in _PREDICTED:
        yield _flight({"method": name}, {"governor": ATTITUDE.name, **_TARGET})


def compile_further(scenario: Scenario) -> None:
    """Compile what no flight needs: batches of solves, audit, transfers."""
    ShootingSolver(problem_of(scenario)).solve_batch(np.eye(3)[None], np.zeros((1, 3)))
    certifier = Certifier.from_scenario(scenario)
    if certifier is not None:
        certifier.warm_up()
    motion.warm_up(RigidBodyPlant.from_scenario(scenario))
    PLANNER.warm_up()


def _flight(controller: dict[str, Any], governor: dict[str, Any] | None = None) -> dict[str, Any]:
    zones = {"zone_names": ["zone"], "zones": {"zone": _ZONE}}
    return {
        "plant": {
            "inertia": _SPHEROID,
            "initial_momentum": [0.0, 0.0, 1e-3],
            "time_step": 0.4,
            "duration": 1.0,
        },
        "nmpc_controller": {**zones, **controller},
        "reference_governor": governor or {},
    }


WARMUP: Final = (flights, compile_further)
