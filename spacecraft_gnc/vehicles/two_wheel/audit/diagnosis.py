"""Audit of the diagnosis of the wheels, against recorded speeds, the truth, and the momentum.

It shares no code with the monitor, nor with what finds the attitude to hold: residuals and bounds
are computed anew from the recorded speeds, health is held against that of the simulation, and what
is said of rest against the equation of momentum along the direction that no wheel can give.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.types import Array, Vector3
from spacecraft_gnc.vehicles.two_wheel.controllers.report import Mode, Rest
from spacecraft_gnc.vehicles.two_wheel.scenario import Scenario
from spacecraft_gnc.vehicles.two_wheel.signals import DIAGNOSIS, STATE

_RESIDUAL: Final = "residuals of the wheels"
_BOUND: Final = "bounds of the residuals"
_EXCLUDED: Final = "wheels excluded by the residual test"
_TRUTH: Final = "no wheel excluded that answers"
_MODE: Final = "mode of flight"
_REST: Final = "rest or rotation that is held"
_TARGET: Final = "rest at the target"
_ROTATION: Final = "attitude that is held is a rotation"
_LOSS: Final = "pointing that is lost"
_ROUNDING: Final = 1e-12
"""Share of the largest speed that recorded and recomputed numbers may differ by."""
_STILL: Final = 2e-9
"""Rate [rad/s] below which a spacecraft is at rest; the controller takes half of it."""
_SPANS: Final = 1e-6


def audit_diagnosis(evidence: Evidence, ledger: Ledger) -> None:
    """Check every diagnosis of a method that watches the wheels."""
    columns = evidence.columns[DIAGNOSIS]
    steps = evidence.common(DIAGNOSIS, STATE, REFERENCE) if columns.steps.size else columns.steps
    watched = steps.size and np.isfinite(evidence.rows(DIAGNOSIS, "threshold", steps)).any()
    if not watched:
        why = f"method {evidence.scenario.controller.method} watches no wheel"
        ledger.skip(_RESIDUAL, why)
        return
    _audit_test(evidence, ledger, steps[1:][np.diff(steps) == 1])
    _audit_truth(evidence, ledger, steps)
    _audit_rest(evidence, ledger, steps)


def _audit_test(evidence: Evidence, ledger: Ledger, steps: NDArray[np.int64]) -> None:
    """Compute residuals and bounds of the steps that follow on one another."""
    s = evidence.scenario
    c, period = s.controller, s.period
    before, after = (evidence.rows(STATE, "wheel_speed", k) for k in (steps - 1, steps))
    told = evidence.rows(STATE, "applied_acceleration", steps)
    top = c.max_wheel_speed or math.inf
    most = c.max_wheel_acceleration or math.inf
    due = np.clip(before + period * np.clip(told, -most, most), -top, top)
    viscous, coulomb = (
        np.broadcast_to(value if value.size else 0.0, c.wheel_inertias.shape)
        for value in (c.wheel_viscous_friction, c.wheel_coulomb_friction)
    )
    rub = viscous * np.maximum(np.abs(before), np.abs(after)) + coulomb
    residual, threshold, response = (
        evidence.rows(DIAGNOSIS, name, steps) for name in ("residual", "threshold", "response")
    )
    limit = _ROUNDING * max(1.0, float(np.abs(before).max(initial=0.0)))
    ledger.bound(_RESIDUAL, steps, f"{DIAGNOSIS}.residual", residual - (after - due), limit,
                 "rad/s")  # fmt: skip
    ledger.bound(_BOUND, steps, f"{DIAGNOSIS}.threshold",
                 threshold - period * rub / c.wheel_inertias, limit, "rad/s")  # fmt: skip
    came = response * (due - before) - np.clip(after - before, *_ends(due - before))
    told_apart = np.isnan(response) & (np.abs(due - before) <= threshold)
    ledger.bound(_RESIDUAL, steps, f"{DIAGNOSIS}.response", np.where(told_apart, 0.0, came), limit,
                 "rad/s")  # fmt: skip
    healthy, earlier = (evidence.rows(DIAGNOSIS, "healthy", k) != 0.0 for k in (steps, steps - 1))
    kept = (healthy == (earlier & (np.abs(residual) <= threshold))).all(axis=1)
    ledger.require(_EXCLUDED, "once its bound is passed", steps, f"{DIAGNOSIS}.healthy", kept)


def _ends(change: Array) -> tuple[Array, Array]:
    """Return the least and the largest change that is told as a share of one."""
    return np.minimum(-change, 2.0 * change), np.maximum(-change, 2.0 * change)


def _audit_truth(evidence: Evidence, ledger: Ledger, steps: NDArray[np.int64]) -> None:
    """Require that only wheels which are lost count as lost."""
    healthy = evidence.rows(DIAGNOSIS, "healthy", steps) != 0.0
    truth = evidence.rows(STATE, "healthy", steps) != 0.0
    ledger.require(_TRUTH, "as the simulation knows", steps, f"{DIAGNOSIS}.healthy",
                   (healthy | ~truth).all(axis=1))  # fmt: skip


def _audit_rest(evidence: Evidence, ledger: Ledger, steps: NDArray[np.int64]) -> None:
    """Check mode, and the attitude and the rate that are held, of every step."""
    told = {name: evidence.rows(DIAGNOSIS, name, steps) for name in DIAGNOSIS.fields}
    speeds, momenta = (
        evidence.rows(STATE, name, steps) for name in ("wheel_speed", "total_momentum")
    )
    targets = evidence.rows(REFERENCE, "attitude", steps)
    held = told["held_attitude"]
    modes, balanced, angles = [], [], []
    for i in range(len(steps)):
        wheels = _Left.of(evidence.scenario, told["healthy"][i] != 0.0)
        attitude, rest = held[i].reshape(3, 3), Rest(int(told["rest"][i]))
        modes.append(Mode(int(told["mode"][i])) in wheels.modes(rest))
        body, rate = attitude.T @ momenta[i], told["remaining_rate"][i]
        off = wheels.imbalance(body, rate, speeds[i], rest) if wheels.rank == 2 else 0.0
        balanced.append(off)
        axis = rate if rest is Rest.NOWHERE and wheels.rank == 2 else None
        angles.append(_angle(attitude, targets[i].reshape(3, 3), axis) - told["pointing_loss"][i])
    ledger.require(_MODE, "of the wheels left", steps, f"{DIAGNOSIS}.mode", np.array(modes))
    ledger.bound(_REST, steps, f"{DIAGNOSIS}.remaining_rate", np.array(balanced), _STILL, "rad/s")
    ledger.bound(_LOSS, steps, f"{DIAGNOSIS}.pointing_loss", np.array(angles), 1e-7, "rad")
    rotations = held.reshape(-1, 3, 3)
    defect = np.einsum("nji,njk->nik", rotations, rotations) - np.eye(3)
    ledger.bound(_ROTATION, steps, f"{DIAGNOSIS}.held_attitude", defect, _ROUNDING)
    there = told["rest"].ravel() == Rest.AT_TARGET
    where = f"{DIAGNOSIS}.held_attitude"
    ledger.compare(_TARGET, steps[there], {where: held[there]}, {where: targets[there]})
    nothing = np.zeros((int(there.sum()), 3))
    where = f"{DIAGNOSIS}.remaining_rate"
    ledger.compare(_TARGET, steps[there], {where: told["remaining_rate"][there]}, {where: nothing})


@dataclass(frozen=True, slots=True, eq=False)
class _Left:
    """Wheels that are left, as the controller believes them."""

    inertia: Array
    normal: Vector3
    """Direction in which they take in no momentum; of any use where ``rank`` is 2."""
    lost: Array
    """(3, n) momentum of each wheel that is lost, per speed."""
    healthy: NDArray[np.bool_]
    rank: int

    @classmethod
    def of(cls, scenario: Scenario, healthy: NDArray[np.bool_]) -> _Left:
        c = scenario.controller
        axes = c.wheel_axes / np.sqrt((c.wheel_axes**2).sum(axis=0))
        values, vectors = np.linalg.eigh(axes[:, healthy] @ axes[:, healthy].T)
        lost = (axes * c.wheel_inertias)[:, ~healthy]
        rank = int(np.count_nonzero(values > _SPANS**2))
        return cls(np.array(c.inertia), vectors[:, 0], lost, healthy, rank)

    def modes(self, rest: Rest) -> tuple[Mode, ...]:
        """Return the modes that go with these wheels and what is said of rest."""
        if self.rank == 3:
            return (Mode.NOMINAL,) if self.healthy.all() else (Mode.REALLOCATED,)
        if self.rank == 2 and rest is Rest.AT_TARGET:
            return (Mode.UNDERACTUATED, Mode.HOLDING)
        return (Mode.HOLDING,)

    def imbalance(self, body: Vector3, rate: Vector3, speeds: Array, rest: Rest) -> float:
        """Return by which rate [rad/s] what is held is not so, or not the least one.

        ``body`` is the total momentum in the body at the attitude held. Lost wheels keep the speeds
        of now, or come to rest, where the spacecraft does.
        """
        across = self.inertia @ self.normal
        size = math.sqrt(float(across @ across))
        due = float(self.normal @ body) - float(across @ rate)
        kept = (self.normal @ self.lost) * speeds[~self.healthy]
        if rest is not Rest.NOWHERE:
            ends = product((0.0, 1.0), repeat=len(kept))
            return min(abs(due - float(kept @ np.array(end))) for end in ends) / size
        about = body if float(body @ body) > (_STILL * size) ** 2 else across
        aside = np.cross(rate, about) / math.sqrt(float(about @ about))
        return max(abs(due - float(kept.sum())) / size, math.sqrt(float(aside @ aside)))


def _angle(held: Array, target: Array, axis: Vector3 | None) -> float:
    """Return the angle [rad] between attitudes, or between an axis of the body in both."""
    if axis is None:
        chord = held - target
        return 2.0 * math.asin(min(1.0, math.sqrt(float((chord**2).sum()) / 8.0)))
    one, other = held @ axis, target @ axis
    cross = np.cross(one, other)
    return math.atan2(math.sqrt(float(cross @ cross)), float(one @ other))
