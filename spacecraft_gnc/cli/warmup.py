"""``gnc warmup``: compile every kernel into the cache, so that no flight waits for the compiler."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from spacecraft_gnc.cli._common import QuietOption

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

    from spacecraft_gnc.loop.controllers import problem_of
    from spacecraft_gnc.ocp import ShootingSolver
    from spacecraft_gnc.scenario import from_sections, load, registry

    started = time.perf_counter()
    loaded = [load(path) for path in scenarios or ()]
    along_a_run = {"method": "neighboring_extremal", "nominal_rotation_vector": [0.0, 0.0, 0.1]}
    body = {"inertia": _SPHEROID}
    loaded.append(from_sections({"plant": body, "nmpc_controller": along_a_run}, "warmup"))
    for method, built_in in registry.BUILT_IN["controllers"].items():
        for variant in built_in.variants or ("",):
            controller: dict[str, Any] = {"method": method, "zone_names": ["zone"]}
            controller["zones"] = {"zone": _ZONE}
            if method == "terminal_set":
                controller["max_torque"] = 0.0  # the set is within reach
            if variant:
                controller["variant"] = variant
            plant = {"inertia": _SPHEROID, "initial_momentum": [0.0, 0.0, 0.1], "duration": 1.0}
            loaded.append(from_sections({"plant": plant, "nmpc_controller": controller}, "warmup"))
    for scenario in loaded:
        for core in (
            scenario.build_plant(),
            scenario.build_controller(),
            scenario.build_governor(),
        ):
            core.warm_up()
    loaded[-1].build().run()
    ShootingSolver(problem_of(loaded[-1])).solve_batch(np.eye(3)[None], np.zeros((1, 3)))
    if not quiet:
        print(f"kernels ready after {time.perf_counter() - started:.1f} s")
