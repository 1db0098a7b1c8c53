"""Flights of the shipped scenarios in other units of mass, time and cost: the same, rescaled.

In units that are powers of two every rounding is the same too, so that nothing but a constant with
a unit can make a difference: equality is bit for bit. In other units what differs is rounding.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rescaled import rescaled

from spacecraft_gnc.scenario import load, load_fleet

pytestmark = pytest.mark.long

CONFIG = Path(__file__).parents[2] / "config"


def is_one_rigid_body(path: Path) -> bool:
    agents = [*load_fleet(path).agents]
    return len(agents) == 1 and load(path).vehicle.name == "rigid_body"


SCENARIOS = sorted(path.name for path in CONFIG.glob("*.yaml") if is_one_rigid_body(path))
PLAIN = (1.0, 1.0, 1.0)
POWERS = (2.0**-18, 2.0**5, 2.0**9)
OTHERS = [(1e-6, 1.0, 1.0), (1e5, 1.0, 1.0), (1.0, 60.0, 1.0), (1.0, 1.0, 1e-9)]
STEPS = 40
# Rounding, over so many steps: a standstill multiplies it by a few times 1.2 a step.
SAME_ATTITUDE, SAME_TORQUE = 1e-9, 1e-9
_FLOWN: dict[tuple[str, tuple[float, float, float], str], Any] = {}


def flown(name: str, units: tuple[float, float, float], method: str = "") -> Any:
    """Flight and governor; those of a scenario in its own units are flown once."""
    key = (name, units, method)
    if key not in _FLOWN:
        changes = {"nmpc_controller.method": method} if method else {}
        loop = rescaled(CONFIG / name, units, STEPS, changes).build()
        _FLOWN[key] = loop.run(), loop.governor
    return _FLOWN[key]


def counts(flight: Any) -> list[Any]:
    return [flight.status, flight.source, flight.alpha]


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_flight_in_powers_of_two_is_the_same_bit_for_bit(name: str) -> None:
    plain, governor = flown(name, PLAIN)
    other, other_governor = flown(name, POWERS)
    mass, time, cost = POWERS
    assert plain.n_steps >= STEPS
    assert np.array_equal(other.attitude, plain.attitude)
    assert np.array_equal(other.momentum * (time / mass), plain.momentum)
    assert np.array_equal(other.torque * (time**2 / mass), plain.torque)
    assert np.array_equal(other.iterations, plain.iterations)
    assert np.array_equal(other.cost, cost * plain.cost, equal_nan=True)
    for one, same in zip(counts(other), counts(plain), strict=True):
        assert np.array_equal(one, same, equal_nan=True)
    if hasattr(governor, "predictor"):
        assert other_governor.predictor.horizon == governor.predictor.horizon


@pytest.mark.parametrize("units", OTHERS, ids=str)
@pytest.mark.parametrize("name", SCENARIOS)
def test_a_flight_in_other_units_differs_by_rounding(
    name: str, units: tuple[float, float, float]
) -> None:
    plain, governor = flown(name, PLAIN)
    other, other_governor = flown(name, units)
    mass, time, _ = units
    assert np.abs(other.attitude - plain.attitude).max() <= SAME_ATTITUDE
    torque = other.torque * (time**2 / mass)
    assert np.abs(torque - plain.torque).max() <= SAME_TORQUE * np.abs(plain.torque).max()
    for one, same in zip(counts(other), counts(plain), strict=True):
        assert np.allclose(one, same, rtol=0.0, atol=1e-9, equal_nan=True)
    if hasattr(governor, "predictor"):
        assert other_governor.predictor.horizon == governor.predictor.horizon


@pytest.mark.parametrize("method", ["slsqp", "fsolve", "neighboring_extremal", "feedback"])
def test_each_method_flies_the_same_in_powers_of_two(method: str) -> None:
    plain, _ = flown("gupta2015_case1.yaml", PLAIN, method)
    other, _ = flown("gupta2015_case1.yaml", POWERS, method)
    mass, time, _ = POWERS
    assert np.array_equal(other.torque * (time**2 / mass), plain.torque)
    for one, same in zip(counts(other), counts(plain), strict=True):
        assert np.array_equal(one, same, equal_nan=True)


@pytest.mark.parametrize("units", OTHERS, ids=str)
def test_slsqp_finds_the_same_torques_to_its_tolerance(units: tuple[float, float, float]) -> None:
    """Forward differences of the cost: their rounding is another one in other units."""
    plain, _ = flown("gupta2015_case1.yaml", PLAIN, "slsqp")
    other, _ = flown("gupta2015_case1.yaml", units, "slsqp")
    mass, time, _ = units
    assert np.array_equal(other.source, plain.source)
    assert np.abs(other.torque * (time**2 / mass) - plain.torque).max() <= 1e-4 * 0.01
