"""Neighboring extremals flown in place of solves, each against an exact solve of the same step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.analysis.audit.plans import Certifier, Plans
from spacecraft_gnc.loop.controllers import options_of
from spacecraft_gnc.ocp import ShootingSolver
from spacecraft_gnc.ocp.neighboring import FORMULATION as NEIGHBORING

if TYPE_CHECKING:
    from spacecraft_gnc.analysis.audit.evidence import Evidence
    from spacecraft_gnc.analysis.audit.ledger import Ledger

CORRECTIONS: Final = "neighboring extremal = exact solve"
BEYOND: Final = 5.0
"""How many times ``ne_tolerance`` the flown torque may be off: the error is estimated in flight."""


class CorrectionAudit:
    """Solves exactly, from the plan itself, what a neighboring extremal answered on line."""

    def __init__(self, evidence: Evidence, certifier: Certifier, ledger: Ledger) -> None:
        self._certifier, self._ledger = certifier, ledger
        self._scenario = evidence.scenario
        self._solver: ShootingSolver | None = None
        self._unsolved = 0

    def audit(self, steps: NDArray[np.int64], plans: Plans, rows: dict[str, NDArray[Any]]) -> None:
        """Audit the neighboring extremals among the solves of a block."""
        chosen = np.flatnonzero(rows["formulation"] == NEIGHBORING)
        if not chosen.size:
            return
        if self._solver is None:
            self._solver = ShootingSolver(self._certifier.ocp, options=options_of(self._scenario))
        off, scale = np.full(len(chosen), np.nan), np.empty(len(chosen))
        limit = self._certifier.ocp.max_torque
        for j, i in enumerate(chosen.tolist()):
            plan = Plans(*(values[i : i + 1] for values in plans))
            guess, _ = self._certifier.multipliers(plan)
            start = plan.attitudes[0, 0], plan.momenta[0, 0], plan.references[0]
            exact = self._solver.solve(*start, guess)
            scale[j] = limit or float(np.linalg.norm(exact.torques, axis=1).max())
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
