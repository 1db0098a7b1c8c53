"""Audit of neighboring extremals, each against an exact solve of the same step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.ocp import ShootingSolver
from spacecraft_gnc.ocp.neighboring import FORMULATION as NEIGHBORING
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier, Plans
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import options_of

if TYPE_CHECKING:
    from spacecraft_gnc.audit.evidence import Evidence
    from spacecraft_gnc.audit.ledger import Ledger
    from spacecraft_gnc.types import Array

CORRECTIONS: Final = "neighboring extremal = exact solve"
AGES: Final = "neighboring extremals follow an exact solve"
BEYOND: Final = 5.0
"""How many times ``ne_tolerance`` the flown torque may be off: its error is estimated in flight."""


class CorrectionAudit:
    """Solves exactly, from the plan itself, what a neighboring extremal answered on line."""

    def __init__(self, evidence: Evidence, certifier: Certifier, ledger: Ledger) -> None:
        self._certifier, self._ledger = certifier, ledger
        self._scenario = evidence.scenario
        self._solver: ShootingSolver | None = None
        self._unsolved = 0
        self._last = 0.0
        self._age: float = np.inf  # corrections since the last exact solve
        self._step, self._reference, self._moving = -1, b"", False

    def audit(self, steps: NDArray[np.int64], plans: Plans, rows: dict[str, NDArray[Any]]) -> None:
        """Audit the neighboring extremals among the solves of a block."""
        chosen = np.flatnonzero(rows["formulation"] == NEIGHBORING)
        scales = self._scales(plans, rows)
        young = self._young(steps, plans, rows)
        if not chosen.size:
            return
        where = "solver_status.formulation"
        self._ledger.require(
            AGES, "at most ne_max_age after it", steps[chosen], where, young[chosen]
        )
        if self._solver is None:
            self._solver = ShootingSolver(self._certifier.ocp, options=options_of(self._scenario))
        off, scale = np.full(len(chosen), np.nan), scales[chosen]
        for j, i in enumerate(chosen.tolist()):
            plan = Plans(*(values[i : i + 1] for values in plans))
            guess, _ = self._certifier.multipliers(plan)
            start = plan.attitudes[0, 0], plan.momenta[0, 0], plan.reference(0)
            exact = self._solver.solve(*start, guess)
            if exact.converged:
                first = self._certifier.ocp.realizable(exact.torques[0])  # cut to the limit, too
                off[j] = np.linalg.norm(first - plan.torques[0, 0])
        known = np.isfinite(off)
        self._unsolved += int((~known).sum())
        allowed = BEYOND * self._scenario.controller.ne_tolerance * scale
        where = "solver_status.predicted_torques"
        self._ledger.bound(CORRECTIONS, steps[chosen][known], where, off[known], allowed[known],
                           "N m")  # fmt: skip
        if self._unsolved:
            self._ledger.check(CORRECTIONS, "", f"{self._unsolved} steps have no exact solve")

    def _young(
        self, steps: NDArray[np.int64], plans: Plans, rows: dict[str, NDArray[Any]]
    ) -> NDArray[np.bool_]:
        """Tell which solves are exact, or correct an exact one in time.

        Of the same reference, where it rests; one that moves is followed.
        After a step without a plan here, whatever it was, corrections count from that step.
        """
        young = np.ones(len(steps), dtype=bool)
        for i, step in enumerate(steps.tolist()):
            reference, moving = plans.references[i].tobytes(), bool(plans.feedforward[i].any())
            if rows["formulation"][i] != NEIGHBORING or (step != self._step + 1 and step > 0):
                self._age = 0.0
            elif reference != self._reference and not (moving or self._moving):
                self._age = np.inf
            if rows["formulation"][i] == NEIGHBORING:
                self._age += 1.0
                young[i] = self._age <= self._scenario.controller.ne_max_age
            self._step, self._reference, self._moving = step, reference, moving
        return young

    def _scales(self, plans: Plans, rows: dict[str, NDArray[Any]]) -> Array:
        """Return (m,) torques [N m] of which ``ne_tolerance`` is a share.

        The limit; without one, the largest torque of the last exact plan.
        """
        limit = self._certifier.ocp.max_torque
        if limit > 0.0:
            return np.full(len(plans.torques), limit)
        largest = np.linalg.norm(plans.torques, axis=2).max(axis=1)
        scales = np.empty(len(largest))
        for i, formulation in enumerate(rows["formulation"]):
            if formulation != NEIGHBORING:
                self._last = float(largest[i])
            scales[i] = max(self._last, float(largest[i]))
        return scales
