"""``gnc warmup``: compile every kernel into the cache, so that no flight waits for the compiler."""

from __future__ import annotations

import gc
import time
from pathlib import Path
from typing import Annotated, Final

import typer

from spacecraft_gnc.cli._common import QuietOption

_FEW_COLLECTIONS: Final = 200_000
"""Objects to the next collection of garbage, which else takes 7 % of the time of compiling."""


def warmup(
    scenarios: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="SCENARIO.yaml", readable=False, help="Warm up for these scenarios as well."
        ),
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Compile the kernels of the built-in vehicles, and of the scenarios given, into the cache."""
    from spacecraft_gnc.scenario import from_sections, load_fleet
    from spacecraft_gnc.vehicles import registry

    started = time.perf_counter()
    gc.set_threshold(_FEW_COLLECTIONS)
    fleets = [load_fleet(path) for path in scenarios or ()]
    for scenario in [one for fleet in fleets for one in fleet.agents.values()]:
        for core in (
            scenario.build_plant(),
            scenario.build_controller(),
            scenario.build_governor(),
        ):
            core.warm_up()
    for name in registry.own_names(registry.VEHICLES):
        vehicle = registry.vehicle_of(name)
        if vehicle.warmup is None:
            continue
        flights, compile_further = vehicle.warmup.load()
        built_in = [from_sections(sections, "warmup") for sections in flights()]
        for scenario in built_in:
            scenario.build().run()
        compile_further(built_in[0])
    if not quiet:
        print(f"kernels ready after {time.perf_counter() - started:.1f} s")
