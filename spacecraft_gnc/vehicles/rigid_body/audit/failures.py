"""Solve claimed failures again, with the recorded settings from the recorded states.

A controller that calls its solves failed may fly its fallback law for ever: so each claim is put to
the flown controller once more. Where it now finds a plan, the plan is certified by the audit's own
kernels, and the claim is refuted; where it fails in the same way, it has failed again, no more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp.solution import Solution
from spacecraft_gnc.ocp.terminal_problem import TerminalSetOcp
from spacecraft_gnc.signals.attitude import REFERENCE
from spacecraft_gnc.status import NO_SOLVE, Status
from spacecraft_gnc.vehicles.rigid_body.audit.certificate import CORRECTED
from spacecraft_gnc.vehicles.rigid_body.audit.plans import HARD, ROUNDING, Certifier, Plans
from spacecraft_gnc.vehicles.rigid_body.audit.rungs import Sample, restored, sample
from spacecraft_gnc.vehicles.rigid_body.controllers.report import solution_of
from spacecraft_gnc.vehicles.rigid_body.signals import SOLVER_STATUS, STATE, TORQUE

if TYPE_CHECKING:
    from spacecraft_gnc.audit.counts import Counts
    from spacecraft_gnc.audit.evidence import Evidence
    from spacecraft_gnc.audit.ledger import Ledger
    from spacecraft_gnc.loop.protocols import Command, Reference, State
    from spacecraft_gnc.recording.columns import Columns
    from spacecraft_gnc.types import Array
    from spacecraft_gnc.vehicles.rigid_body.audit.certificate import CertificateAudit

FAILURES: Final = "claimed failures, solved again"
_STATUS: Final = "solver_status.status"
_SAME: Final = "the same failure"


class _Solving(Protocol):
    """What is asked of the controllers that make plans."""

    def reset(self) -> None: ...

    def warm_up(self) -> None: ...

    def solve(
        self, state: State, reference: Reference, warm_start: Array | None
    ) -> Solution | None: ...

    def command(self, state: State, reference: Reference) -> Command: ...


class _Before(NamedTuple):
    """The last solve before a step."""

    step: int
    solved: bool
    plan: Solution | None
    """Restored from the bag; None where it failed, or where its plan is not whole."""


class FailureAudit:
    """Solves the claimed failures of a flight again, block by block.

    Parameters
    ----------
    evidence
        The flight.
    certifier
        Problem of its method.
    certificate
        Says what a converged solve may leave.
    ledger, counts
        Get the verdicts.
    any_failure
        Whether a failure of another kind will do, as between machines with other libraries.
    """

    def __init__(
        self,
        evidence: Evidence,
        certifier: Certifier,
        certificate: CertificateAudit,
        ledger: Ledger,
        counts: Counts,
        any_failure: bool,
    ) -> None:
        self._evidence, self._certifier, self._certificate = evidence, certifier, certificate
        self._ledger, self._counts = ledger, counts
        # the chord goes on with a factorization of earlier steps: the whole flight is repeated
        self._along = evidence.scenario.controller.step_rule == "chord"
        self._any = any_failure or self._along
        self._repeated = 0
        self._unrepeatable = 0
        self._controller: _Solving | None = None
        self._last: _Before | None = None
        self._refuted: tuple[int, str] | None = None
        self._cold_only = 0

    def audit(
        self,
        block: Columns,
        claimed: NDArray[np.int64],
        solved: NDArray[np.int64],
        plans: Plans,
        rows: dict[str, NDArray[Any]],
    ) -> None:
        """Audit the steps ``claimed`` to have failed; plans and rows are those of ``solved``."""
        statuses = block.fields["status"]
        attempts = block.steps[self._is_attempt(statuses)]
        converged = block.steps[np.isin(statuses, SOLVED)]

        def before(step: int) -> _Before | None:
            at = int(np.searchsorted(attempts, step)) - 1
            if at < 0:
                return self._last
            last = int(attempts[at])
            row = int(np.searchsorted(solved, last))
            whole = row < len(solved) and solved[row] == last
            plan = restored(self._certifier, plans, rows, row) if whole else None
            return _Before(last, bool(np.isin(last, converged)), plan)

        for step in claimed.tolist():
            status = int(statuses[np.searchsorted(block.steps, step)])
            self._again(step, status, before(step))
        if attempts.size:
            self._last = before(int(attempts[-1]) + 1)

    def audit_unsaid(self) -> None:
        """Solve again, cold, what fell back at steps of which no solver message was recorded."""
        columns = self._evidence.columns
        if not columns[TORQUE].steps.size:
            return
        fell_back = np.isin(columns[TORQUE].fields["source"], _FALLBACKS)
        steps = np.setdiff1d(columns[TORQUE].steps[fell_back], columns[SOLVER_STATUS].steps)
        for topic in (STATE, REFERENCE):
            steps = np.intersect1d(steps, columns[topic].steps)
        for step in steps[steps < self._evidence.n].tolist():
            self._cold_only += 1
            self._again(step, _UNSAID, None)

    def _is_attempt(self, statuses: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Tell of which messages a solve was due: not where a law answers by itself."""
        if self._certifier.has_law:
            return np.asarray(statuses != NO_SOLVE)
        return np.ones(len(statuses), dtype=bool)

    def _again(self, step: int, claimed: int, before: _Before | None) -> None:
        found, counts = sample(self._evidence, step), self._counts
        if self._along and not self._is_whole(step):
            self._unrepeatable += 1
            self._note()
            return
        again = self._along_the_flight(step) if self._along else self._alone(found, before)
        counts.solves_repeated += 1
        status = NO_SOLVE if again is None else int(again.status)
        failed = again is None or not again.converged
        confirmed = status == claimed or (failed and (self._any or claimed == _UNSAID))
        counts.failures_confirmed += confirmed
        fallback = found.source in (*_FALLBACKS, Source.NEIGHBORING_EXTREMAL)
        counts.fallbacks += fallback
        counts.fallbacks_justified += fallback and confirmed
        at = np.array([step])
        self._ledger.require(FAILURES, _SAME, at, _STATUS, np.array([confirmed]))
        if not confirmed and (self._refuted is None or step < self._refuted[0]):
            self._refuted = step, self._told(claimed, again)
        self._note()

    def _alone(self, found: Sample, before: _Before | None) -> Solution | None:
        """Solve a step again by itself."""
        controller, warm = self._started(found.state.step, before)
        return controller.solve(found.state, found.reference, warm)

    def _is_whole(self, step: int) -> bool:
        """Tell whether states and references were recorded up to a step."""
        columns = self._evidence.columns
        return all(
            int(np.searchsorted(columns[topic].steps, step)) == step for topic in (STATE, REFERENCE)
        )

    def _along_the_flight(self, step: int) -> Solution | None:
        """Solve all steps from the last one repeated on again, and return the solution of this."""
        controller, command = self._built(), None
        for k in range(self._repeated, step + 1):
            found = sample(self._evidence, k)
            command = controller.command(found.state, found.reference)
        self._repeated = step + 1
        return None if command is None else solution_of(command)

    def _started(self, step: int, before: _Before | None) -> tuple[_Solving, Array | None]:
        """Return the controller, and the warm start that it had as far as the bag tells it.

        After a solve that failed, and at the first step, there is none.
        """
        controller = self._built()
        controller.reset()
        if before is None or not before.solved:
            return controller, None
        adjacent = before.step == step - 1 or self._certifier.has_law
        if not adjacent or before.plan is None:
            self._cold_only += 1
            return controller, None
        if self._certifier.problem.end is not None:
            # its solver also starts from the multiplier of the terminal set found last
            last = sample(self._evidence, before.step)
            controller.solve(last.state, last.reference, before.plan.costates)
        return controller, before.plan.warm_start

    def _built(self) -> _Solving:
        if self._controller is None:
            controller = self._certifier.controller(self._evidence.scenario)
            self._controller = cast("_Solving", controller)
            self._controller.warm_up()
        return self._controller

    def _told(self, claimed: int, again: Solution | None) -> str:
        """Say what a solve came to whose failure was claimed."""
        claim = f"{_name(claimed)} claimed"
        if again is None:
            return f"{claim}, but the solver refuses the state"
        if not again.converged:
            return f"{claim}, but the solve ends as {again.status.name}"
        found = f"{claim}, but the solve converges after {again.iterations} iterations"
        return f"{found}; {self._certified(again)}"

    def _certified(self, again: Solution) -> str:
        """Certify a plan by the audit's own formulas."""
        plan = (
            again.reference, again.attitudes, again.momenta, again.torques, again.costates[0],
            again.feedforward,
        )  # fmt: skip
        found = self._certifier.certify(Plans(*(np.ascontiguousarray(x[None]) for x in plan)))
        share = float(found.residual[0] / max(float(found.made_of[0]), 1e-300))
        kept = share <= self._certificate.share_left(again.formulation)
        kept |= bool(found.correction[0] <= CORRECTED)
        is_minimum = found.curvature[0] > 0.0 or again.formulation == HARD
        off = max(found.first_defect[0], found.momentum_defect[0])
        flies = found.exists[0] and found.attitude_defect[0] <= ROUNDING
        flies = flies and off <= ROUNDING * np.abs(again.momenta).max()
        if kept and is_minimum and flies and self._reaches(again, found.largest[0]):
            return f"certified: residual {share:.1g} of its terms, curvature > 0"
        return f"not certified by the audit: residual {share:.1g} of its terms"

    def _reaches(self, again: Solution, largest: float) -> bool:
        """Tell whether a plan ends in the terminal set within the torque limit, where there is one.

        That alone refutes INFEASIBLE.
        """
        ocp = self._certifier.ocp
        if not isinstance(ocp, TerminalSetOcp) or ocp.level is None:
            return True
        state = ocp.terminal_state(again.attitudes, again.momenta, again.reference)
        inside = ocp.level_of(state) <= ocp.level.value * (1.0 + ROUNDING)
        return inside and (ocp.max_torque == 0.0 or largest <= ocp.max_torque * (1.0 + ROUNDING))

    def _note(self) -> None:
        counts, notes = self._counts, []
        if self._refuted is not None:
            notes.append(self._refuted[1])
        refuted = counts.solves_repeated - counts.failures_confirmed
        notes.append(f"{counts.failures_confirmed} failed again, {refuted} did not")
        if self._cold_only:
            notes.append(f"{self._cold_only} from a cold start only: the plan before is missing")
        if self._unrepeatable:
            why = "messages before them are missing, on which the chord depends"
            notes.append(f"{self._unrepeatable} not solved again: {why}")
        self._ledger.check(FAILURES, _SAME, "; ".join(notes))


SOLVED: Final = (Status.CONVERGED, Status.STALLED, Status.ESCAPING)
"""How a step ends whose solve converged."""


_FALLBACKS: Final = [source for source in Source if source.is_fallback]
_UNSAID: Final = -1
"""Status of a step of which only the command was recorded."""


def _name(status: int) -> str:
    if status in (NO_SOLVE, _UNSAID):
        return "NO_SOLVE" if status == NO_SOLVE else "a fallback"
    return Status(status).name if status in list(Status) else f"status {status}"
