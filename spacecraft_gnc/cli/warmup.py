"""``gnc warmup``: compile every kernel into the cache, so that no flight waits for the compiler."""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from spacecraft_gnc import SILENT_COMPILER
from spacecraft_gnc.cli._common import QuietOption

_FEW_COLLECTIONS: Final = 200_000
"""Objects to the next collection of garbage, which else takes 7 % of the time of compiling."""
_Task = tuple[str, int]
"""A vehicle, and which of its flights to fly; the number behind the last: what no flight needs."""


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
    from spacecraft_gnc.scenario import load_fleet

    started = time.perf_counter()
    fleets = [load_fleet(path) for path in scenarios or ()]
    tasks = deque(_tasks())
    # From both ends, because neighbors share kernels, which two processes would both compile.
    with ThreadPoolExecutor() as threads:
        try:
            list(threads.map(_work_off, [tasks.popleft, tasks.pop][: os.cpu_count()]))
        except BaseException:
            tasks.clear()
            for worker in multiprocessing.active_children():
                worker.terminate()
            raise
    for scenario in [one for fleet in fleets for one in fleet.agents.values()]:
        for core in (
            scenario.build_plant(),
            scenario.build_controller(),
            scenario.build_governor(),
        ):
            core.warm_up()
    if not quiet:
        print(f"kernels ready after {time.perf_counter() - started:.1f} s")


def _warmups() -> dict[str, tuple[Any, Any]]:
    """Return by vehicle what yields its flights, and what compiles the rest."""
    from spacecraft_gnc.vehicles import registry

    vehicles = {name: registry.vehicle_of(name) for name in registry.own_names(registry.VEHICLES)}
    return {name: one.warmup.load() for name, one in vehicles.items() if one.warmup is not None}


def _tasks() -> list[_Task]:
    """Return what is to be compiled, that of the vehicle with most flights first."""
    counts = {name: len(list(flights())) for name, (flights, _) in _warmups().items()}
    names = sorted(counts, key=lambda name: -counts[name])
    return [(name, number) for name in names for number in range(counts[name] + 1)]


def _work_off(take: Callable[[], _Task]) -> None:
    """Have a process compile one task after the other, until there is none to take."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, context, _prepare) as worker:
        while True:
            try:
                task = take()
            except IndexError:
                return
            worker.submit(_compile, *task).result()


def _prepare() -> None:
    """Set a process up: without a word, and with less garbage collection."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    os.environ[SILENT_COMPILER] = "1"
    gc.set_threshold(_FEW_COLLECTIONS)


def _compile(name: str, number: int) -> None:
    """Compile the kernels of a task."""
    from spacecraft_gnc.scenario import from_sections

    flights, compile_further = _warmups()[name]
    sections = list(flights())
    if number < len(sections):
        from_sections(sections[number], "warmup").build().run()
    else:
        compile_further(from_sections(sections[0], "warmup"))
