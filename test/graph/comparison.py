"""A flight of the graph against the same flight without ROS."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.loop.flight import Flight
from spacecraft_gnc.scenario import load_fleet

CASE1 = Path(__file__).resolve().parents[2] / "config" / "gupta2015_case1.yaml"
WALL = {"solve_time"}
"""Columns of wall time."""


def compared(flight: Flight) -> tuple[str, ...]:
    """Return the columns of a flight that two flights of a scenario share, to the last bit."""
    return ("time", *sorted({name for name, _ in flight.columns()} - WALL))


def assert_equals_simulation(bag: Path, *overrides: str, scenario: Path = CASE1) -> None:
    """Every number of a bag is that of `gnc simulate`, to the last bit."""
    for agent, loop in load_fleet(scenario, overrides).build().items():
        assert_equals_flight(bag, loop.run(), agent)


def assert_equals_flight(bag: Path, simulated: Flight, agent: str = "") -> None:
    """Every number of a bag is that of a flight without ROS, to the last bit."""
    flown = read_flight(bag, namespace=agent or None)
    assert not flown.info.missing
    assert not flown.info.overridden
    for name in compared(simulated):
        ours, theirs = (np.asarray(getattr(f, name)) for f in (flown.trajectory, simulated))
        # a step without a solve has no residual: NaN on both sides
        assert ours.dtype == theirs.dtype, (agent, name)
        assert np.array_equal(ours, theirs, equal_nan=True), (agent, name)
