"""Repeat the search for standstills wherever the controller searches."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc import lie
from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.ocp.neighboring import FORMULATION as NEIGHBORING
from spacecraft_gnc.status import Status
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier, Plans
from spacecraft_gnc.vehicles.rigid_body.audit.rungs import restored, sample
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import monitor_of
from spacecraft_gnc.vehicles.rigid_body.controllers.standstill import Finding

STANDSTILLS: Final = "standstills, looked for again"
RADIUS: Final = 1e-6
"""Difference of a spectral radius: of eigenvalues that may be double."""
_RADIUS_FIELD: Final = "solver_status.closed_loop_radius"
_AS_REPORTED: Final = "as reported"
_SAID: Final = (Status.STALLED, Status.ESCAPING)


class StandstillAudit:
    """Looks for a standstill at each step whose optimal plan flew, and compares with the report."""

    def __init__(
        self, evidence: Evidence, certifier: Certifier, ledger: Ledger, counts: Counts
    ) -> None:
        self._evidence, self._certifier = evidence, certifier
        self._ledger, self._counts = ledger, counts
        self._monitor = None
        if certifier.watches:
            self._monitor = monitor_of(evidence.scenario, certifier.ocp)
        self._first: tuple[int, str] | None = None

    def audit(self, solved: NDArray[np.int64], plans: Plans, rows: dict[str, NDArray[Any]]) -> None:
        """Audit the solves of a block."""
        said = np.isin(rows["status"], _SAID) | np.isfinite(rows["closed_loop_radius"])
        looked = np.zeros(len(solved), dtype=bool)
        if self._monitor is not None:
            looked = np.asarray(rows["formulation"] != NEIGHBORING)
        self._counts.standstills_looked_for += int(looked.sum())
        self._counts.standstills_reported += int(said.sum())
        kept = np.ones(len(solved), dtype=bool)
        for i in np.flatnonzero(said | (looked & self._is_quiet(plans))).tolist():
            found = None
            if self._monitor is not None and looked[i]:
                found = self._monitor.examine(restored(self._certifier, plans, rows, i))
            self._counts.standstills_found += found is not None
            told = self._compare(int(solved[i]), found, rows, i)
            kept[i] = not told
            if told and self._first is None:
                self._first = int(solved[i]), told
        if self._monitor is None and not said.any():
            method = self._evidence.scenario.controller.method
            self._ledger.skip(STANDSTILLS, f"method {method} looks for none")
            return
        at = looked | said
        where = "solver_status.status"
        self._ledger.require(STANDSTILLS, _AS_REPORTED, solved[at], where, kept[at])
        if self._first is not None:
            self._ledger.check(STANDSTILLS, _AS_REPORTED, self._first[1])

    def _is_quiet(self, plans: Plans) -> NDArray[np.bool_]:
        """Tell where the monitor may have something to say, by what it asks first."""
        if self._monitor is None:
            return np.zeros(len(plans.torques), dtype=bool)
        first = plans.attitudes[:, 0]
        quiet = self._monitor.may_stand(
            lie.angles_between(plans.references, first),
            lie.angles_between(first, plans.attitudes[:, -1]),
            np.linalg.norm(plans.momenta[:, 0], axis=1),
            np.linalg.norm(plans.torques[:, 0], axis=1),
        )
        return np.asarray(quiet)

    def _compare(
        self, step: int, found: Finding | None, rows: dict[str, NDArray[Any]], i: int
    ) -> str:
        """Compare what was found with the report; return what is wrong with the latter."""
        status, radius = int(rows["status"][i]), float(rows["closed_loop_radius"][i])
        said = status in _SAID or np.isfinite(radius)
        if found is None:
            return "a standstill is reported where there is none" if said else ""
        expected = Status.ESCAPING if found.standstill.escaping else Status.STALLED
        if not said:
            return (
                f"a standstill is not reported: {expected.name}, closed-loop radius "
                f"{found.standstill.radius:.9g}"
            )
        self._details(step, found, rows, i)
        return "" if status == expected else f"{expected.name} is found, another status reported"

    def _details(self, step: int, found: Finding, rows: dict[str, NDArray[Any]], i: int) -> None:
        ledger, at = self._ledger, np.array([step])
        off = np.array([found.standstill.radius - rows["closed_loop_radius"][i]])
        ledger.bound("standstill", at, _RADIUS_FIELD, off, RADIUS)
        same = np.array([found.standstill.active_constraint == rows["active_constraint"][i]])
        ledger.require(
            "constraint leaned on", "the same", at, "solver_status.active_constraint", same
        )
        if found.standstill.escaping:
            flown, where = sample(self._evidence, step).torque[None], self._certifier.command
            scale = self._certifier.ocp.max_torque or max(float(np.abs(flown).max()), 1e-300)
            ledger.compare(
                "command that leaves a standstill", at, {where: flown},
                {where: found.torque[None]}, RADIUS * scale, "N m",
            )  # fmt: skip
