"""Whatever a flight calls was compiled, or loaded, before it: `warm_up` leaves nothing out."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

from spacecraft_gnc.scenario import load

CONFIG = Path(__file__).resolve().parents[2] / "config"
GOVERNED = ("kalabic2014_governor", "governed_nmpc")


def signatures() -> dict[str, int]:
    """Return how many signatures of each of our kernels are loaded."""
    # not isinstance, which asks what a dead weak reference stands for
    kernels = [item for item in gc.get_objects() if issubclass(type(item), Dispatcher)]
    return {
        f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}": len(kernel.signatures)
        for kernel in kernels
        if kernel.py_func.__module__.startswith("spacecraft_gnc")
    }


@pytest.mark.parametrize("name", GOVERNED)
def test_nothing_is_compiled_in_flight(name: str) -> None:
    loop = load(CONFIG / f"{name}.yaml", ["plant.duration=20.0"]).build()
    for core in (loop.plant, loop.controller, loop.governor):
        core.warm_up()
    before = signatures()
    assert before
    loop.run()
    assert signatures() == before
