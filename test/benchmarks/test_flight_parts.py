"""The parts that benchmarks/flight_parts.py times make up whole flights."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np

PARTS = runpy.run_path(str(Path(__file__).parents[2] / "benchmarks" / "flight_parts.py"))
SCENARIO = "gupta2015_case1"


def test_every_part_of_every_flight_is_timed():
    found = PARTS["parts"](SCENARIO, 2)
    assert all(part.times.shape == (2,) and (part.times > 0.0).all() for part in found)
    times = [part.times for part in found]
    np.testing.assert_allclose(times[4], sum(times[:4]))
    assert "metrics" in {part.name for part in found}


def test_flights_differ_and_are_the_same_on_every_call():
    first, second = (list(PARTS["variations"](SCENARIO, 3)) for _ in range(2))
    assert first == second
    assert first[0] != first[1]
