"""Check the recorded motion against the plant, and against the equations of motion."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence, Progress
from spacecraft_gnc.audit.ledger import Ledger, as_absolute
from spacecraft_gnc.errors import GncError
from spacecraft_gnc.signals.attitude import quaternion_of
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.two_wheel.audit.equations import Equations
from spacecraft_gnc.vehicles.two_wheel.audit.states import recorded_states
from spacecraft_gnc.vehicles.two_wheel.plant import GyrostatPlant
from spacecraft_gnc.vehicles.two_wheel.signals import STATE
from spacecraft_gnc.vehicles.two_wheel.state import WheelState

_EACH, _ROW = "integrator, from each state", "integrator, from the start"
_TOLD: Final = {
    _ROW: ("attitude", "angular_velocity", "wheel_speed", "total_momentum"),
    "quaternion = rotation matrix": ("orientation",),
    "energy told": ("kinetic_energy",),
    "health of the wheels": ("healthy",),
}
"""Fields of a state, by the check that compares them."""


def audit_motion(
    evidence: Evidence, ledger: Ledger, tolerance: float | None, progress: Progress | None
) -> None:
    """Integrate the flight again, by the plant's own code and by other equations."""
    plant: GyrostatPlant = evidence.scenario.build_plant()
    applied = evidence.rows(STATE, "applied_acceleration", np.arange(1, evidence.n + 1))
    _in_a_row(evidence, plant, applied, ledger, tolerance, progress)
    steps = _followed(evidence, applied)
    states = recorded_states(evidence, steps)
    _each_step(evidence, plant, states, applied[steps], ledger, tolerance)
    with np.errstate(over="ignore", invalid="ignore"):  # a damaged number fails, whatever its size
        _other_equations(evidence, steps, states, applied[steps], ledger)


def _where(name: str) -> str:
    return f"{STATE}.{name}"


def _followed(evidence: Evidence, applied: Array) -> NDArray[np.int64]:
    """Return the steps with a state before and after them, and a known acceleration."""
    steps = evidence.columns[STATE].steps
    before = steps[np.flatnonzero(np.diff(steps) == 1)]
    before = before[before < evidence.n]
    return np.asarray(before[np.isfinite(applied[before]).all(axis=1)])


def _in_a_row(
    evidence: Evidence,
    plant: GyrostatPlant,
    applied: Array,
    ledger: Ledger,
    tolerance: float | None,
    progress: Progress | None,
) -> None:
    """Fly the vehicle by the recorded accelerations from the scenario's start."""
    again = _flown_again(evidence, plant, applied, ledger, progress)
    steps = evidence.columns[STATE].steps
    steps = steps[steps < len(again["kinetic_energy"])]
    for check, names in _TOLD.items():
        for name in names:
            recorded = evidence.rows(STATE, name, steps)
            limit = None if name == "healthy" else as_absolute(tolerance, recorded)
            where = _where(name)
            ledger.compare(check, steps, {where: recorded}, {where: again[name][steps]}, limit)


def _flown_again(
    evidence: Evidence,
    plant: GyrostatPlant,
    applied: Array,
    ledger: Ledger,
    progress: Progress | None,
) -> dict[str, Array]:
    """Return what the plant tells of each state it comes through."""
    n = evidence.n
    told: dict[str, list[Array | float]] = {name: [] for names in _TOLD.values() for name in names}
    plant.reset()
    for k in range(n + 1):
        state = plant.state
        for name in ("attitude", "angular_velocity", "wheel_speed", "total_momentum", "healthy"):
            told[name].append(np.ravel(getattr(state, name)))
        told["orientation"].append(quaternion_of(state.attitude))
        told["kinetic_energy"].append(plant.gyrostat.kinetic_energy(state))
        if progress is not None and k % 1000 == 0:
            progress(k, n)
        if k == n or not np.isfinite(applied[k]).all():
            break
        try:
            plant.step(applied[k])
        except GncError:
            ledger.fail(_ROW, "the step exists", k, _where("angular_velocity"))
            break
    return {name: np.array(values, dtype=np.float64) for name, values in told.items()}


def _each_step(
    evidence: Evidence,
    plant: GyrostatPlant,
    states: list[WheelState],
    applied: Array,
    ledger: Ledger,
    tolerance: float | None,
) -> None:
    """Make each step from the recorded state before it, so that no difference hides another."""
    after = []
    for state, acceleration in zip(states, applied, strict=True):
        try:
            after.append(plant.advance(state, acceleration))
        except GncError:
            ledger.fail(_EACH, "the step exists", state.step, _where("angular_velocity"))
            break
    steps = np.array([state.step for state in after], dtype=np.int64)
    for name in ("attitude", "angular_velocity", "wheel_speed"):
        recorded, where = evidence.rows(STATE, name, steps), _where(name)
        again = np.array([np.ravel(getattr(state, name)) for state in after])
        limit = as_absolute(tolerance, evidence.columns[STATE].fields[name])
        ledger.compare(_EACH, steps, {where: recorded}, {where: again}, limit)


def _other_equations(
    evidence: Evidence,
    steps: NDArray[np.int64],
    states: list[WheelState],
    applied: Array,
    ledger: Ledger,
) -> None:
    """Hold each state and each step against equations that share no code with the plant."""
    equations = Equations.of(evidence.scenario)
    everywhere = evidence.columns[STATE].steps
    momentum = evidence.rows(STATE, "total_momentum", everywhere)
    first = {_where("total_momentum"): np.broadcast_to(momentum[:1], momentum.shape)}
    ledger.compare(
        "total momentum constant", everywhere, {_where("total_momentum"): momentum}, first
    )
    off, limit = equations.momentum_defect(recorded_states(evidence, everywhere))
    ledger.bound("total momentum = R (J omega + A Js nu)", everywhere,
                 _where("angular_velocity"), off, limit, "N m s")  # fmt: skip
    if not steps.size:
        return
    turned, speeds, limits = equations.step(states, applied)
    after = steps + 1
    recorded = evidence.rows(STATE, "wheel_speed", after)
    ledger.bound("wheel speeds = accelerations within limits, friction and health", after,
                 _where("wheel_speed"), recorded - speeds, equations.speed_rounding(speeds),
                 "rad/s")  # fmt: skip
    attitudes = evidence.rows(STATE, "attitude", after).reshape(-1, 3, 3)
    ledger.bound("attitude = Runge-Kutta integration", after, _where("attitude"),
                 attitudes - turned, limits)  # fmt: skip
