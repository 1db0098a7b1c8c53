"""``gnc warmup``: compile every kernel into the cache, so that no flight waits for the compiler."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from spacecraft_gnc.cli._common import QuietOption

if TYPE_CHECKING:
    from spacecraft_gnc.scenario import Scenario

_PREDICTED: Final = ("feedback", "shooting")
"""Methods whose closed loop is predicted in compiled code."""
_SPHEROID = [1.0, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 0.8]  # [kg m^2]
_ZONE = {
    "kind": "exclusion",
    "body_axis": [1.0, 0.0, 0.0],
    "inertial_axis": [0.0, 0.0, 1.0],
    "half_angle_deg": 5.0,
}


def warmup(
    scenarios: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="SCENARIO.yaml", readable=False, help="Warm up for these scenarios as well."
        ),
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Compile the kernels of the built-in cores, and of the scenarios given, into the cache."""
    import numpy as np

    from spacecraft_gnc.ocp import ShootingSolver
    from spacecraft_gnc.scenario import load
    from spacecraft_gnc.vehicles.rigid_body.audit import motion
    from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier
    from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of
    from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant

    started = time.perf_counter()
    built_in = [*_methods(), *_governors()]
    for scenario in [load(path) for path in scenarios or ()]:
        for core in (
            scenario.build_plant(),
            scenario.build_controller(),
            scenario.build_governor(),
        ):
            core.warm_up()
    for scenario in built_in:
        scenario.build().run()
    ShootingSolver(problem_of(built_in[0])).solve_batch(np.eye(3)[None], np.zeros((1, 3)))
    certifier = Certifier.from_scenario(built_in[0])
    if certifier is not None:
        certifier.warm_up()
    motion.warm_up(RigidBodyPlant.from_scenario(built_in[0]))
    if not quiet:
        print(f"kernels ready after {time.perf_counter() - started:.1f} s")


def _methods() -> Iterator[Scenario]:
    """Yield a short flight of every built-in method and variant."""
    from spacecraft_gnc.scenario import registry

    for method, built_in in registry.BUILT_IN["controllers"].items():
        for variant in built_in.traits.variants or ("exact",):
            controller: dict[str, Any] = {"method": method, "variant": variant}
            if method == "terminal_set":
                controller["max_torque"] = 0.0  # the set is within reach
            yield _flight(controller)
    yield _flight({"method": "neighboring_extremal", "nominal_rotation_vector": [0.0, 0.0, 0.1]})


def _governors() -> Iterator[Scenario]:
    """Yield a short flight of every built-in governor, before each loop that is predicted."""
    from spacecraft_gnc.scenario import registry

    for governor in registry.BUILT_IN["governors"]:
        for method in _PREDICTED:
            if governor != "none" and method in registry.BUILT_IN["controllers"]:
                target = {"target_rotation_vector": [0.1, 0.0, 0.0], "max_momentum": 1.0}
                yield _flight({"method": method}, {"governor": governor, **target})


def _flight(controller: dict[str, Any], governor: dict[str, Any] | None = None) -> Scenario:
    from spacecraft_gnc.scenario import from_sections

    zones = {"zone_names": ["zone"], "zones": {"zone": _ZONE}}
    sections = {
        "plant": {
            "inertia": _SPHEROID,
            "initial_momentum": [0.0, 0.0, 1e-3],
            "time_step": 0.4,
            "duration": 1.0,
        },
        "nmpc_controller": {**zones, **controller},
        "reference_governor": governor or {},
    }
    return from_sections(sections, "warmup")
