"""Check recorded states against the scenario's start and the equations of motion."""

from __future__ import annotations

from itertools import product
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence, Progress
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.signals.attitude import quaternion_of
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.audit.equations import (
    ATTITUDE,
    OFFSET,
    RATE,
    VELOCITY,
    Equations,
    rotations,
)
from spacecraft_gnc.vehicles.docking.parameters.plant import PlantParameters
from spacecraft_gnc.vehicles.docking.signals import STATE
from spacecraft_gnc.vehicles.docking.state import DIRECTIONS

PARTS: Final = {
    "port_offset": (OFFSET, "m"),
    "port_velocity": (VELOCITY, "m/s"),
    "attitude": (ATTITUDE, ""),
    "angular_velocity": (RATE, "rad/s"),
}
"""Columns of `equations` that hold a field, and its unit."""
_START: Final = "start = the scenario's"
_MOTION: Final = "motion = equations in the chief frame, DOP853"
_MARGINS: Final = "margins = least over the integrator steps"
_ROUNDING: Final = 1e-12
_CORNERS: Final = np.array(list(product((-0.5, 0.5), repeat=3)))


def recorded_rows(evidence: Evidence, steps: NDArray[np.int64], prefix: str = "") -> Array:
    """Return the states (m, 18) of steps, as `equations` reads them; ``measured_``: as measured."""
    return np.hstack([evidence.rows(STATE, f"{prefix}{name}", steps) for name in PARTS])


def audit_motion(evidence: Evidence, ledger: Ledger, progress: Progress | None) -> None:
    """Check the start, every step from the recorded state before it, and what a state tells."""
    with np.errstate(over="ignore", invalid="ignore"):  # a damaged number fails, whatever its size
        _start(evidence, ledger)
        _told(evidence, ledger)
        _each_step(evidence, ledger, progress)


def margins(plant: PlantParameters, y: Array) -> tuple[Array, Array]:
    """Return line-of-sight margins and clearances (m,) of rows (m, 18)."""
    slope = np.tan(np.radians(plant.line_of_sight_half_angle_deg))
    width = slope * y[:, 0] + plant.line_of_sight_slack
    sight = np.minimum.reduce([width - s * y[:, i] for i in (1, 2) for s in (-1.0, 1.0)])
    arms = _CORNERS * plant.deputy_size - plant.deputy_port
    vertices = y[:, None, OFFSET] + plant.chief_port
    vertices = vertices + np.einsum("nij,vj->nvi", y[:, ATTITUDE].reshape(-1, 3, 3), arms)
    return sight, vertices[..., 0].min(axis=1) - 0.5 * plant.chief_size[0]


def given(plant: PlantParameters, wrench: Array) -> Array:
    """Return what thrusters give (m, 6) of wrenches asked for, all directions healthy."""
    if not plant.saturates:
        return wrench
    limits = np.repeat([plant.max_force, plant.max_moment], 3)
    return np.asarray(np.clip(wrench, -limits, limits))


def _where(name: str) -> str:
    return f"{STATE}.{name}"


def _compare(
    ledger: Ledger, check: str, steps: NDArray[np.int64], found: Array, made: Array,
    bounds: dict[str, Array | float],
) -> None:  # fmt: skip
    """Compare rows of states, each part to its bound."""
    for name, (columns, unit) in PARTS.items():
        off = found[:, columns] - made[:, columns]
        line = f"{check}: {name.replace('_', ' ')}"
        ledger.bound(line, steps, _where(name), off, bounds[name], unit)


def _start(evidence: Evidence, ledger: Ledger) -> None:
    """Hold the first state against the scenario."""
    steps, p = evidence.columns[STATE].steps[:1], evidence.scenario.plant
    if not (steps == 0).all():
        ledger.skip(_START, "the first state was not recorded")
        return
    made = np.zeros((1, 18))
    made[0, OFFSET], made[0, VELOCITY] = p.initial_port_offset, p.initial_port_velocity
    made[0, RATE] = p.initial_angular_velocity
    made[:, ATTITUDE] = rotations(p.initial_rotation_vector[None]).reshape(1, 9)
    found = recorded_rows(evidence, steps)
    _compare(ledger, _START, steps, found, made, dict.fromkeys(PARTS, _ROUNDING))
    for name, value in zip(("line_of_sight_margin", "clearance"), margins(p, made), strict=True):
        off = evidence.rows(STATE, name, steps) - value
        ledger.bound(f"{_START}: margins", steps, _where(name), off, _bound_of(made), "m")


def _told(evidence: Evidence, ledger: Ledger) -> None:
    """Check what a state tells beside the motion: quaternion, thrusters, the chief's attitude."""
    steps, scenario = evidence.columns[STATE].steps, evidence.scenario
    R = evidence.rows(STATE, "attitude", steps).reshape(-1, 3, 3)
    found = {_where("orientation"): evidence.rows(STATE, "orientation", steps)}
    made = {_where("orientation"): np.array([quaternion_of(each) for each in R])}
    ledger.compare("quaternion = rotation matrix", steps, found, made)
    found = {_where("thrusters"): evidence.rows(STATE, "thrusters", steps)}
    made = {_where("thrusters"): thrusters(scenario.plant, scenario.period, steps).astype(float)}
    ledger.compare("thrusters = the scenario's loss", steps, found, made)
    made_chief = Equations.of(scenario.plant).chief_attitudes(scenario.period * steps)
    off = evidence.rows(STATE, "chief_attitude", steps) - made_chief.reshape(-1, 9)
    turned = _ROUNDING * (1.0 + scenario.plant.chief_spin_rate * scenario.period * steps)
    ledger.bound("attitude of the chief", steps, _where("chief_attitude"), off, turned)


def thrusters(plant: PlantParameters, period: float, steps: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which directions (m, 6) answer in steps: a loss counts from the next start on."""
    answer = np.ones((len(steps), 6), dtype=bool)
    if plant.thruster_lost:
        lost = steps * period >= plant.thruster_lost_at * (1.0 - 1e-9)
        answer[lost, DIRECTIONS.index(plant.thruster_lost)] = False
    return answer


def _each_step(evidence: Evidence, ledger: Ledger, progress: Progress | None) -> None:
    """Integrate each step from the recorded state before it: no difference hides another."""
    steps, wrench = _followed(evidence)
    if not steps.size:
        ledger.skip(_MOTION, "no two states follow one another")
        return
    scenario = evidence.scenario
    p, equations = scenario.plant, Equations.of(scenario.plant)
    y, n, h = recorded_rows(evidence, steps), scenario.substeps, scenario.period / scenario.substeps
    answer, acted = thrusters(p, scenario.period, steps), given(p, wrench)
    least: Any = (np.full(len(steps), np.inf),) * 2
    bends = np.zeros(len(steps), dtype=bool)
    limits = _bounds(equations, y, acted, scenario.period, n)
    for i in range(n):
        before = _lost(y, acted, answer)
        times = scenario.period * steps + i * h
        y = equations.advanced(times, y, acted, h, None if answer.all() else answer)
        bends |= (before * _lost(y, acted, answer) < 0.0).any(axis=1)
        least = tuple(map(np.minimum, least, margins(p, y)))
        if progress is not None:
            progress(i + 1, n)
    jump = np.where(bends, _bend(equations, y, acted, h), 0.0)
    limits["port_velocity"] = limits["port_velocity"] + jump
    limits["port_offset"] = limits["port_offset"] + scenario.period * jump
    found = recorded_rows(evidence, steps + 1)
    _compare(ledger, _MOTION, steps + 1, found, y, limits)
    bound = limits["port_offset"] + _bound_of(found) + limits["attitude"]
    for name, value in zip(("line_of_sight_margin", "clearance"), least, strict=True):
        off = evidence.rows(STATE, name, steps + 1) - value
        ledger.bound(_MARGINS, steps + 1, _where(name), off, bound, "m")


def _followed(evidence: Evidence) -> tuple[NDArray[np.int64], Array]:
    """Return the steps with a state before and after them, and the wrenches asked for."""
    steps = evidence.columns[STATE].steps
    before = steps[np.flatnonzero(np.diff(steps) == 1)]
    before = before[before < evidence.n]
    wrench = evidence.rows(STATE, "applied_wrench", before + 1)
    known = np.isfinite(wrench).all(axis=1)
    return before[known], wrench[known]


def _bound_of(y: Array) -> Array:
    """Return the rounding (m,) of offsets [m]."""
    return np.asarray(_ROUNDING * (10.0 + np.linalg.norm(y[:, OFFSET], axis=1)))


def _bounds(equations: Equations, y: Array, acted: Array, period: float, n: int) -> dict[str, Any]:
    """Return what the plant's method of fourth order may miss in a step, by field (m,).

    With the largest rate W, an integrator step h misses some 0.02 (h W)^5 rad; five times that is
    tolerated, and rounding.
    """
    push = np.abs(acted[:, 3:]).max(axis=1) / np.linalg.eigvalsh(equations.inertia)[0]
    rate = np.linalg.norm(y[:, RATE], axis=1) + np.linalg.norm(equations.spin)
    rate = rate + equations.mean_motion + np.sqrt(3.0) * push * period
    turned = 1e-11 + 0.1 * n * (rate * period / n) ** 5
    arm = 1.0 + float(np.linalg.norm(equations.deputy_port))
    return {
        "port_offset": arm * turned + _bound_of(y),
        "port_velocity": arm * turned * (rate + 1.0 / period) + _bound_of(y),
        "attitude": turned,
        "angular_velocity": turned * rate + _ROUNDING,
    }


def _lost(y: Array, acted: Array, answer: NDArray[np.bool_]) -> Array:
    """Return the components (m, 3) of the force in deputy axes of which a direction is lost."""
    R = y[:, ATTITUDE].reshape(-1, 3, 3)
    along = np.einsum("nji,nj->ni", R, acted[:, :3])
    return np.where(answer[:, :3] & answer[:, 3:], 0.0, along)


def _bend(equations: Equations, y: Array, acted: Array, h: float) -> Array:
    """Return what a method of fourth order may miss [m/s] where a lost component changes sign."""
    rate = np.linalg.norm(y[:, RATE], axis=1)
    return np.asarray(0.05 * h**2 * np.linalg.norm(acted[:, :3], axis=1) * rate / equations.mass)
