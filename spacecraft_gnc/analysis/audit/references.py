"""Whether the references are rotations, and move as the governor's decisions say."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit.evidence import Evidence, Progress
from spacecraft_gnc.analysis.audit.ledger import Ledger
from spacecraft_gnc.governors.search import CUT_POINT
from spacecraft_gnc.recording.steps import GOVERNOR_STATUS, REFERENCE, STATE
from spacecraft_gnc.types import Array

ROUNDING: Final = 1e-13
GEODESIC: Final = 1e-12
"""Largest difference of entries of a reference that was moved: a logarithm and an exponential."""
INFERRED: Final = 1e-8
"""The same towards a target that a first move has told."""
_ATTITUDE, _ORIENTATION = "attitude_reference.attitude", "attitude_reference.orientation"
_MOVES: Final = "reference moves by alpha"
BUILT_IN: Final = ("none", "attitude")


def audit_references(evidence: Evidence, ledger: Ledger, progress: Progress | None) -> None:
    """Check the references by themselves, then against the governor's decisions."""
    columns = evidence.columns[REFERENCE]
    if not columns.steps.size:
        ledger.skip("references are rotations", "attitude_reference was not recorded")
        return
    attitudes = columns.fields["attitude"].reshape(-1, 3, 3)
    defect = np.einsum("kji,kjl->kil", attitudes, attitudes) - np.eye(3)
    ledger.bound("references are rotations", columns.steps, _ATTITUDE, defect, ROUNDING)
    name = "quaternion = rotation matrix"
    again = np.array([lie.to_quaternion_xyzw(attitude) for attitude in attitudes])
    recorded = columns.fields["orientation"]
    ledger.compare(name, columns.steps, {_ORIENTATION: recorded}, {_ORIENTATION: again})
    _feedforward(evidence, ledger)
    _decisions(evidence, ledger)
    _moves(evidence, ledger, progress)


def _feedforward(evidence: Evidence, ledger: Ledger) -> None:
    """Check that the references of our own governors, which all stand still, ask for no motion."""
    columns, name = evidence.columns[REFERENCE], "feedforward of a fixed reference"
    governor = evidence.scenario.governor.governor
    if governor not in BUILT_IN:
        ledger.skip(name, f"governor {governor} is a plug-in's, whose reference may move")
        return
    for field in ("angular_velocity", "torque"):
        told, where = columns.fields[field], f"attitude_reference.{field}"
        ledger.compare(name, columns.steps, {where: told}, {where: np.zeros_like(told)})


def _decisions(evidence: Evidence, ledger: Ledger) -> None:
    """Check that a share lies between 0 and 1, and that what is admissible has room."""
    columns = evidence.columns[GOVERNOR_STATUS]
    name, sign = "alpha between 0 and 1", "margin >= 0 where admissible"
    if not columns.steps.size:
        for skipped in (name, sign):
            ledger.skip(skipped, "governor_status was not recorded")
        return
    alpha, margin = columns.fields["alpha"], columns.fields["margin"]
    kept = (alpha >= 0.0) & (alpha <= 1.0)
    ledger.require(name, "always", columns.steps, "governor_status.alpha", kept)
    admissible = columns.fields["admissible"]
    ledger.skip("margin predicted by the governor", "its sign is checked, not its size")
    where = "governor_status.margin"
    ledger.require(sign, "always", columns.steps, where, (margin >= 0.0) == admissible)


def _moves(evidence: Evidence, ledger: Ledger, progress: Progress | None) -> None:
    """Follow the reference: exp(alpha log(aim V^T)) V, by Kalabic (11)."""
    governor = evidence.scenario.governor.governor
    steps = evidence.common(REFERENCE, GOVERNOR_STATUS)
    if governor not in BUILT_IN or not steps.size:
        why = f"governor {governor} is a plug-in's" if steps.size else "not recorded"
        ledger.skip(_MOVES, why)
        return
    follower = _Follower(evidence, ledger)
    references = evidence.rows(REFERENCE, "attitude", steps).reshape(-1, 3, 3)
    decisions = {
        name: evidence.rows(GOVERNOR_STATUS, name, steps) for name in ("alpha", "waypoints")
    }
    for i, step in enumerate(steps.tolist()):
        follower.follow(step, references[i], decisions["alpha"][i], int(decisions["waypoints"][i]))
        if progress is not None and i % 1000 == 0:
            progress(i, len(steps))
    follower.close()


class _Follower:
    """Follows the reference step by step, and collects how far off it is.

    Of a slew no topic tells the target. A move that the known one does not explain is taken as the
    first towards another; every later one has to lead there, and the table says from where on.
    """

    def __init__(self, evidence: Evidence, ledger: Ledger) -> None:
        self._ledger, self._evidence = ledger, evidence
        g = evidence.scenario.governor
        self._aim = lie.exp(g.target_rotation_vector)
        self._governed = g.governor != "none"
        self._routed = self._governed and g.route
        self._shift = g.cut_point_shift
        self._held: Array | None = None
        self._last, self._waypoints = -1, 0
        self._steps: list[int] = []
        self._off: list[float] = []
        self._limits: list[float] = []
        self._on_the_way = 0
        self._slews: list[int] = []

    def follow(self, step: int, reference: Array, alpha: float, waypoints: int) -> None:
        """Compare the reference of one step with the last one, moved by ``alpha``."""
        held = self._before(step)
        through = max(waypoints, self._waypoints)  # the last waypoint counts no more once reached
        self._held, self._last, self._waypoints = reference, step, waypoints
        if held is None:
            return
        if alpha > 0.0 and through:
            self._on_the_way += 1
            return
        off = float(np.abs(reference - self._moved(held, alpha)).max())
        limit = INFERRED if self._slews else GEODESIC
        if alpha == 1.0 and self._routed and not off <= limit:
            self._on_the_way += 1  # a waypoint, reached in the step that it was chosen in
            return
        if alpha > 0.0 and not off <= limit:
            self._slews.append(step)
            self._aim = reference
            if alpha < 1.0:
                self._aim = lie.exp(lie.log(reference @ held.T) / alpha) @ held
            return
        self._steps.append(step)
        self._off.append(off)
        self._limits.append(0.0 if alpha == 0.0 and step else limit)  # a held one is the same

    def _before(self, step: int) -> Array | None:
        """Return the reference that was held; the governor starts at the state or where told."""
        if self._held is not None and self._last == step - 1:
            return self._held
        if step > 0:
            return None
        if not self._governed:
            return self._aim
        given = self._evidence.scenario.governor.initial_reference_rotation_vector
        if np.isfinite(given).all():
            return lie.exp(given)
        start = self._evidence.rows(STATE, "attitude", np.array([0])).reshape(3, 3)
        return lie.orthonormalize(start) if np.isfinite(start).all() else None

    def _moved(self, held: Array, alpha: float) -> Array:
        if alpha == 0.0:
            return held
        vector = lie.log(self._aim @ held.T)
        angle = float(np.linalg.norm(vector))
        cut = self._governed and angle > math.pi - CUT_POINT
        if cut:
            vector *= (1.0 - self._shift) * math.pi / angle
        if alpha == 1.0 and not cut:
            return self._aim
        return np.asarray(lie.exp(alpha * vector) @ held)

    def close(self) -> None:
        """Enter what was found."""
        steps: NDArray[np.int64] = np.array(self._steps, dtype=np.int64)
        limits = np.array(self._limits)
        self._ledger.bound(_MOVES, steps, _ATTITUDE, np.array(self._off), limits)
        notes = []
        if self._on_the_way:
            notes.append(f"{self._on_the_way} steps towards waypoints, which no topic holds")
        if self._slews:
            first = self._slews[0]
            notes.append(f"{len(self._slews)} targets that no topic holds, from step {first} on")
        if notes:
            self._ledger.check(_MOVES, "", "; ".join(notes))
