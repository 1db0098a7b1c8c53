"""Flights in other units of mass, time and cost: the audit passes, the summary is the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from flown_bags import fly
from rescaled import rescaled

from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import read_flight

CONFIG = Path(__file__).parents[2] / "config"
UNITS = [(1e-6, 1.0, 1.0), (1e5, 1.0, 1.0), (1.0, 60.0, 1.0), (1.0, 1.0, 1e-9)]
STEPS = 20
NAMES = (
    "gupta2015_case1",  # on the limit
    "gupta2015_case2",  # a standstill that is left
    "bagherzadeh2023_ne_exact10",
    "kalabic2014_nmpc",
    "kalabic2014_governor",
)
# What an audit counts, and a summary has without a unit.
ALIKE = (
    "steps", "saturated_steps", "unconverged_steps", "stalled_steps", "escaping_steps", "sources",
    "fallback_steps", "neighboring_share", "inadmissible_steps",
)  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_the_audit_passes_and_the_summary_is_the_same(name: str, tmp_path: Path) -> None:
    expected = recorded(name, (1.0, 1.0, 1.0), tmp_path / "plain")
    for i, units in enumerate(UNITS):
        mass, time, cost = units
        found = recorded(name, units, tmp_path / str(i))
        assert {key: found[key] for key in ALIKE} == {key: expected[key] for key in ALIKE}
        assert found["final_error_deg"] == pytest.approx(expected["final_error_deg"], rel=1e-9)
        torque = expected["max_torque"] * mass / time**2
        assert found["max_torque"] == pytest.approx(torque, rel=1e-9)
        if expected["cost"] is not None:
            assert found["cost"] == pytest.approx(expected["cost"] * cost, rel=1e-9)


def recorded(name: str, units: tuple[float, float, float], folder: Path) -> dict[str, Any]:
    """Fly, record and audit a scenario in other units; return its summary."""
    folder.mkdir()
    bag = fly(folder, rescaled(CONFIG / f"{name}.yaml", units, STEPS).sections)
    audit = audit_bag(bag)
    assert audit.passed, audit.first
    trajectory, info = read_flight(bag)
    return summarize(trajectory, info.scenario)
