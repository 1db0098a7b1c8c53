"""Audit of the diagnosis of a lost thruster direction, by the audit's own linear model."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.docking.audit.equations import ATTITUDE, OFFSET, RATE, VELOCITY, cross
from spacecraft_gnc.vehicles.docking.audit.law import Model, model_error
from spacecraft_gnc.vehicles.docking.audit.motion import recorded_rows
from spacecraft_gnc.vehicles.docking.scenario import Scenario
from spacecraft_gnc.vehicles.docking.signals import GOVERNOR_STATUS, STATE

_ERROR: Final = "response to the force, foretold"
_LOST: Final = "direction concluded lost"
_TRUTH: Final = "no direction concluded lost that answers"
_ROUNDING: Final = 1e-10
"""Share of the distance [1/s], and the speed [m/s]."""
_MODEL, _DEVIATIONS, _EXPLAINED = 2e-5, 6.5, 0.3
"""What the documented test tolerates: [m/s] of the model, deviations of noise, share of a miss."""
_AXES: Final = np.vstack([np.eye(3), -np.eye(3)])


def audit_diagnosis(evidence: Evidence, ledger: Ledger, model: Model) -> None:
    """Foretell every response again, and conclude from it what the governor had to conclude."""
    kind = evidence.scenario.governor.governor
    steps = evidence.common(GOVERNOR_STATUS, STATE)
    if not steps.size or kind not in ("periodic", "time_invariant"):
        ledger.skip(_ERROR, f"governor {kind} watches no thruster, or its status was not recorded")
        return
    watch = _Watch(evidence.scenario, model if kind == "periodic" else model.mean)
    y = recorded_rows(evidence, steps, "measured_")
    applied = evidence.rows(STATE, "applied_wrench", steps)[:, :3]
    follows = np.append(False, np.diff(steps) == 1)
    miss = watch.misses(steps, y, applied, follows)
    errors = np.abs(miss).max(axis=1)
    where, told = f"{GOVERNOR_STATUS}.response_error", _told(evidence, "response_error", steps)
    unknown = np.isnan(told) == ~follows
    ledger.require(_ERROR, "known where two states follow", steps, where, unknown)
    limit = (_ROUNDING + model_error(evidence.scenario)) * (
        1.0 + np.linalg.norm(y[:, OFFSET], axis=1)
    )
    ledger.bound(_ERROR, steps[follows], where, (told - errors)[follows], limit[follows], "m/s")
    where, told = f"{GOVERNOR_STATUS}.lost_thruster", _told(evidence, "lost_thruster", steps)
    made = watch.conclusions(miss, y, applied)
    ledger.compare(_LOST, steps, {where: told}, {where: made.astype(float)})
    _audit_truth(evidence, ledger, steps, told)


def _told(evidence: Evidence, name: str, steps: NDArray[np.int64]) -> Array:
    return evidence.rows(GOVERNOR_STATUS, name, steps)


def _audit_truth(evidence: Evidence, ledger: Ledger, steps: NDArray[np.int64], told: Array) -> None:
    """Require that what is concluded lost is lost in truth."""
    lost = np.flatnonzero(told >= 0)
    if not lost.size:
        ledger.skip(_TRUTH, "no direction was concluded lost")
        return
    answers = evidence.rows(STATE, "thrusters", steps[lost])
    kept = answers[np.arange(lost.size), np.minimum(told[lost].astype(int), 5)] == 0.0
    where = f"{GOVERNOR_STATUS}.lost_thruster"
    ledger.require(_TRUTH, "the truth", steps[lost], where, kept)


class _Watch:
    """The test of the responses."""

    def __init__(self, scenario: Scenario, model: Model) -> None:
        p = scenario.plant
        self.model, self.port = model, p.deputy_port
        self.limit = p.max_force if p.saturates else math.inf
        arm = float(np.linalg.norm(p.deputy_port))
        swing = float(np.abs(model.A[:, 3:6, :3]).max())
        velocity = math.hypot(p.velocity_noise, arm * p.rate_noise)
        position = math.hypot(p.position_noise, arm * p.attitude_noise)
        deviation = math.hypot(math.sqrt(2.0) * velocity, swing * position)
        self.threshold = _MODEL + _DEVIATIONS * deviation

    def misses(
        self, steps: NDArray[np.int64], y: Array, applied: Array, follows: NDArray[np.bool_]
    ) -> Array:
        """Return how the velocities (m, 3) differ from those foretold; NaN: nothing to foretell."""
        center = self._centers(y)
        k = (steps - 1) % len(self.model.A)
        force = np.clip(applied, -self.limit, self.limit) - self.model.U0[k, :3]
        before = np.roll(center, 1, axis=0)
        foretold = np.einsum("nij,nj->ni", self.model.A[k, 3:6, :6], before)
        foretold += np.einsum("nij,nj->ni", self.model.B[k, 3:6, :3], force)
        self.push = self.model.B[k, 3:6, :3]
        return np.where(follows[:, None], center[:, 3:] - foretold, np.nan)

    def _centers(self, y: Array) -> Array:
        """Return offset and velocity (m, 6) of the center of mass from where it is docked."""
        arm = y[:, ATTITUDE].reshape(-1, 3, 3) @ self.port
        drift = y[:, VELOCITY] - cross(y[:, RATE], arm)
        return np.hstack([y[:, OFFSET] - arm + self.port, drift])

    def conclusions(self, miss: Array, y: Array, applied: Array) -> NDArray[np.int64]:
        """Return the direction (m,) concluded lost by each step; -1: none."""
        found = np.full(len(miss), -1)
        force = np.clip(applied, -self.limit, self.limit)
        for i in np.flatnonzero(np.abs(miss).max(axis=1) > self.threshold).tolist():
            lost = self._explained(miss[i], force[i], y[i - 1, ATTITUDE], y[i, ATTITUDE], i)
            if lost >= 0:
                found[i:] = lost
                break
        return found

    def _explained(self, miss: Array, force: Array, before: Array, now: Array, i: int) -> int:
        """Return the direction whose loss leaves the least of a miss; -1: too much is left."""
        first, last = (Rotation.from_matrix(R.reshape(3, 3)) for R in (before, now))
        half = Rotation.from_rotvec(0.5 * (last * first.inv()).as_rotvec())
        axes = (half * first).apply(_AXES)
        given = np.maximum(axes @ force, 0.0)[:, None] * axes
        left = np.linalg.norm(miss + given @ self.push[i].T, axis=1)
        best = int(left.argmin())
        most = self.threshold + _EXPLAINED * float(np.linalg.norm(miss))
        return best if left[best] <= most else -1
