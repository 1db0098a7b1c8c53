"""Check recorded states against the scenario's start and the equations of motion."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.formation.audit.equations import (
    RADIUS,
    Earth,
    hill_map,
    mean_motion,
    start,
)
from spacecraft_gnc.vehicles.formation.audit.told import of_craft, states_of
from spacecraft_gnc.vehicles.formation.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.formation.scenario import Scenario
from spacecraft_gnc.vehicles.formation.signals import STATE

_PARTS: Final = (("position", slice(3), "m"), ("velocity", slice(3, None), "m/s"))
_START: Final = "start = the scenario's"
_HILL: Final = "motion = Hill's equations, matrix exponential"
_EXACT: Final = "motion = two bodies about the Earth, DOP853"
_HEALTHY: Final = "craft that answer = the scenario's loss"
_ROUNDING: Final = 1e-13
"""Share of what adds up to a state: measured 1e-15."""
_EXACTLY: Final = 1.5e-15, 1.5e-14
"""Shares of the orbit's radius, and of its speed, that the integrators may miss: 1e-8 m and
1e-10 m/s at 350 km, where 2.4e-10 m and 3.8e-12 m/s were measured."""


def audit_motion(evidence: Evidence, ledger: Ledger) -> None:
    """Check the start, every step from the recorded state before it, and which craft answer."""
    with np.errstate(over="ignore", invalid="ignore"):  # a damaged number fails, whatever its size
        _start(evidence, ledger)
        _healthy(evidence, ledger)
        _each_step(evidence, ledger)


def healthy(scenario: Scenario, steps: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which craft (m, n) answer in steps: a loss counts from the next start on."""
    plant = scenario.plant
    answer = np.ones((len(steps), len(plant.spacecraft)), dtype=bool)
    if plant.spacecraft_lost:
        row = [name.strip("/") for name in plant.spacecraft].index(plant.spacecraft_lost.strip("/"))
        answer[steps * scenario.period >= plant.spacecraft_lost_at * (1.0 - 1e-9), row] = False
    return answer


def given(plant: PlantParameters, asked: Array) -> Array:
    """Return the changes of velocity (..., 3) that thrusters make of those asked for."""
    size = np.linalg.norm(asked, axis=-1, keepdims=True)
    limit = plant.max_delta_v if plant.saturates else math.inf
    share = np.ones_like(size)
    np.divide(limit, size, out=share, where=size > limit)
    return np.asarray(asked * share)


def _compare(
    ledger: Ledger, check: str, steps: NDArray[np.int64], off: Array, limits: Array
) -> None:
    """Enter differences of states (m, n, 6), each part to its bound."""
    for name, columns, unit in _PARTS:
        amount, bound = (rows[..., columns].reshape(len(steps), -1) for rows in (off, limits))
        ledger.bound(f"{check}: {name}", steps, f"{STATE}.{name}", amount, bound, unit)


def _start(evidence: Evidence, ledger: Ledger) -> None:
    """Hold the first state against the scenario."""
    steps, scenario = evidence.columns[STATE].steps[:1], evidence.scenario
    if not (steps == 0).all():
        ledger.skip(_START, "the first state was not recorded")
        return
    made = start(scenario.plant, scenario.period)[None]
    sizes = np.repeat([np.abs(made[..., c]).max() for _, c, _ in _PARTS], 3)
    limits = np.broadcast_to(_ROUNDING * sizes, made.shape)
    _compare(ledger, _START, steps, states_of(evidence, steps) - made, limits)


def _healthy(evidence: Evidence, ledger: Ledger) -> None:
    """Compare which craft answer."""
    steps, where = evidence.columns[STATE].steps, f"{STATE}.healthy"
    found = {where: evidence.rows(STATE, "healthy", steps)}
    ledger.compare(_HEALTHY, steps, found, {where: healthy(evidence.scenario, steps).astype(float)})


def _each_step(evidence: Evidence, ledger: Ledger) -> None:
    """Advance each state from the recorded one before it: no difference hides another."""
    scenario = evidence.scenario
    plant, period = scenario.plant, scenario.period
    exact = plant.motion != "hill"
    check = _EXACT if exact else _HILL
    steps, asked = _followed(evidence)
    if not steps.size:
        ledger.skip(check, "no two states follow one another")
        return
    x = states_of(evidence, steps)
    x[..., 3:] += np.where(healthy(scenario, steps)[..., None], given(plant, asked), 0.0)
    n = mean_motion(plant)
    A = hill_map(n, period)
    limits = _ROUNDING * (np.abs(x) @ np.abs(A).T)
    if exact:
        earth, radius = Earth(plant), RADIUS + plant.altitude
        chiefs = earth.chiefs(period * np.arange(steps[-1] + 1.0))[steps]
        made = earth.advanced(chiefs, np.nan_to_num(x), period)
        limits += np.repeat([_EXACTLY[0] * radius, _EXACTLY[1] * n * radius], 3)
    else:
        made = x @ A.T
    _compare(ledger, check, steps + 1, states_of(evidence, steps + 1) - made, limits)


def _followed(evidence: Evidence) -> tuple[NDArray[np.int64], Array]:
    """Return the steps with a state before and after them, and the delta-v asked for (m, n, 3)."""
    steps = evidence.columns[STATE].steps
    before = steps[np.flatnonzero(np.diff(steps) == 1)]
    before = before[before < evidence.n]
    asked = evidence.rows(STATE, "applied_delta_v", before + 1)
    return before, of_craft(asked, len(evidence.scenario.plant.spacecraft))
