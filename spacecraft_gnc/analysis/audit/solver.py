"""Whether each solve is worth what its certificate says, and whether its torque was commanded."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.analysis.audit.evidence import Evidence
from spacecraft_gnc.analysis.audit.ledger import Ledger
from spacecraft_gnc.analysis.audit.plans import HARD, Certificates, Certifier, Plans
from spacecraft_gnc.analysis.audit.rungs import NO_SOLVE, LadderAudit, StandstillAudit
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp.neighboring import FORMULATION as NEIGHBORING
from spacecraft_gnc.ocp.solution import Status
from spacecraft_gnc.ocp.terminal_problem import TerminalSetOcp
from spacecraft_gnc.recording.columns import Columns
from spacecraft_gnc.recording.steps import REFERENCE, STATE, TORQUE

SOLVED: Final = (Status.CONVERGED, Status.STALLED, Status.ESCAPING)
"""How a step ends whose solve converged."""
ROUNDING: Final = 1e-13
"""Relative: a few hundred roundings, of the sums over a horizon."""
CURVATURE: Final = 1e-3
"""Relative: the published curvature is that of the last linearisation, a Newton step away."""
CONDITIONS: Final = {
    "backward_sweep": 1e-12,
    "single_shooting": 1e-9,
    "neighboring_extremal": 1e-12,
    "slsqp": 1e-9,
    "fsolve": 1e-6,
}
"""Largest difference of the residual from the certificate's, as a share of 1 + max |lambda|.

Single shooting and fsolve publish that of (44), forward; it is compared with the gradient's."""
CUT: Final = 1e-6
"""Share of the torque limit by which a neighbouring extremal's first torque may be cut to it."""
CUT_COST: Final = 1e-8
"""Share of the cost that this cut may change."""
FORWARD_RUN: Final = ("single_shooting", "fsolve")
FORWARD: Final = 1e-6
"""Share of the largest first costate that those differ, which they find by a forward run."""
NU: Final = 1e-6
"""Multiplier of a terminal set that counts as zero."""
_ANGLE: Final = 1e-12  # [rad]
Rows = dict[str, NDArray[Any]]


class SolverAudit:
    """Audits solves block by block.

    Parameters
    ----------
    evidence
        The flight.
    certifier
        Problem of the method; None where it makes no plans that are known here.
    ledger
        Gets the verdicts.
    """

    def __init__(self, evidence: Evidence, certifier: Certifier, ledger: Ledger) -> None:
        self._evidence = evidence
        self._certifier = certifier
        self._ledger = ledger
        self._ladder = LadderAudit(evidence, certifier, ledger)
        self._standstill = StandstillAudit(evidence, certifier, ledger)

    def audit(self, block: Columns) -> None:
        """Audit a block of solver messages."""
        solved = np.isin(block.fields["status"], SOLVED)
        solved &= block.steps < self._evidence.n
        self._sources(block, solved)
        steps = block.steps[solved]
        rows = {name: values[solved] for name, values in block.fields.items()}
        whole = self._whole(steps, rows)
        steps, rows = steps[whole], {name: values[whole] for name, values in rows.items()}
        plans = self._plans(steps, rows)
        self._ladder.audit(self._fallbacks(block, solved), steps, plans, rows)
        if not steps.size:
            self._ledger.skip("plan starts at the state", "no solve converged")
            return
        self._standstill.audit(steps, plans, rows)
        found = self._certifier.certify(plans)
        for formulation in dict.fromkeys(rows["formulation"]):
            chosen = rows["formulation"] == formulation
            self._certificate(
                str(formulation),
                steps[chosen],
                {name: values[chosen] for name, values in rows.items()},
                Plans(*(values[chosen] for values in plans)),
                Certificates(*(values[chosen] for values in found)),
            )

    def _fallbacks(self, block: Columns, solved: NDArray[np.bool_]) -> NDArray[np.int64]:
        """Return the steps that the ladder answered: not those that a law answers by itself."""
        failed = ~solved & (block.steps < self._evidence.n)
        if self._certifier.has_law:
            failed &= block.fields["status"] != NO_SOLVE
        steps = block.steps[failed]
        for topic in (STATE, REFERENCE, TORQUE):
            steps = np.intersect1d(steps, self._evidence.columns[topic].steps)
        return steps

    def _sources(self, block: Columns, solved: NDArray[np.bool_]) -> None:
        """Require that a converged solve flies, and that only such a one is called optimal."""
        steps = block.steps[block.steps < self._evidence.n]
        steps = np.intersect1d(steps, self._evidence.columns[TORQUE].steps)
        at = np.searchsorted(block.steps, steps)
        source = self._evidence.rows(TORQUE, "source", steps)
        corrected = block.fields["formulation"][at] == NEIGHBORING
        best = np.where(corrected, Source.NEIGHBORING_EXTREMAL, Source.OPTIMAL)
        kept = np.where(solved[at], source == best, source > Source.OPTIMAL)
        self._ledger.require(
            "source follows from the status", "always", steps, "torque_command.source", kept
        )

    def _whole(self, steps: NDArray[np.int64], rows: Rows) -> NDArray[np.bool_]:
        """Return whose plan has the length of the horizon and whose step has all its messages."""
        n = self._certifier.ocp.horizon
        sizes = {
            "predicted_attitudes": 9 * (n + 1),
            "predicted_momenta": 3 * (n + 1),
            "predicted_torques": 3 * n,
        }
        name = "length of the plan"
        kept: NDArray[np.bool_] = np.ones(len(steps), dtype=bool)
        for field, size in sizes.items():
            values = rows[field]
            whole = np.isfinite(values[:, :size]).sum(axis=1) == size
            right = whole & (np.isfinite(values[:, size:]).sum(axis=1) == 0)
            self._ledger.require(name, f"N = {n}", steps, f"solver_status.{field}", right)
            kept &= right
        for topic in (STATE, REFERENCE):
            kept &= np.isin(steps, self._evidence.columns[topic].steps)
        return kept

    def _plans(self, steps: NDArray[np.int64], rows: Rows) -> Plans:
        n, m = self._certifier.ocp.horizon, len(steps)
        references = self._evidence.rows(REFERENCE, "attitude", steps)
        shapes = ((9 * (n + 1), (m, n + 1, 3, 3)), (3 * (n + 1), (m, n + 1, 3)), (3 * n, (m, n, 3)))
        names = ("predicted_attitudes", "predicted_momenta", "predicted_torques")
        attitudes, momenta, torques = (
            np.ascontiguousarray(rows[name][:, :size]).reshape(shape)
            for name, (size, shape) in zip(names, shapes, strict=True)
        )
        references = references.reshape(m, 3, 3)
        return Plans(references, attitudes, momenta, torques, rows["first_costate"])

    def _certificate(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, plans: Plans,
        found: Certificates,
    ) -> None:  # fmt: skip
        self._start_and_command(steps, rows, plans)
        self._dynamics(formulation, steps, plans, found)
        self._conditions(formulation, steps, rows, found)
        self._numbers(formulation, steps, rows, plans, found)

    def _start_and_command(self, steps: NDArray[np.int64], rows: Rows, plans: Plans) -> None:
        compare, evidence = self._ledger.compare, self._evidence
        where = "solver_status.predicted_attitudes"
        state = evidence.rows(STATE, "attitude", steps)
        first = plans.attitudes[:, 0].reshape(-1, 9)
        compare("plan starts at the state", steps, {where: first}, {where: state})
        where = "solver_status.predicted_momenta"
        momentum = evidence.rows(STATE, "angular_momentum", steps)
        compare("plan starts at the state", steps, {where: plans.momenta[:, 0]}, {where: momentum})
        flown = (rows["status"] != Status.ESCAPING) & np.isin(steps, evidence.columns[TORQUE].steps)
        where = "torque_command.torque"
        command = evidence.rows(TORQUE, "torque", steps[flown])
        compare(
            "command = first torque of the plan", steps[flown], {where: command},
            {where: plans.torques[flown, 0]},
        )  # fmt: skip

    def _dynamics(
        self, formulation: str, steps: NDArray[np.int64], plans: Plans, found: Certificates
    ) -> None:
        bound, ocp = self._ledger.bound, self._certifier.ocp
        where = "solver_status.predicted_attitudes"
        name = "plan obeys the dynamics: rotations"
        defect = np.where(found.exists, found.attitude_defect, np.nan)
        bound(name, steps, where, defect, ROUNDING)
        scale = max(float(np.abs(plans.momenta).max()), 1e-300)
        first = found.first_defect
        where, cut = "solver_status.predicted_momenta", np.zeros(len(steps))
        if formulation == NEIGHBORING:  # its first torque is cut to the limit after the rollout
            cut = np.full(len(steps), CUT * ocp.max_torque * ocp.time_step)
        bound(
            f"plan obeys the dynamics: momenta{_said(formulation)}", steps, where,
            np.maximum(found.momentum_defect, np.maximum(first - cut, 0.0)), ROUNDING * scale,
            "N m s",
        )  # fmt: skip

    def _conditions(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, found: Certificates
    ) -> None:
        ledger, ocp = self._ledger, self._certifier.ocp
        size = 1.0 + float(np.abs(found.costates).max(initial=0.0))
        share = CONDITIONS.get(formulation)
        name = f"residual ({formulation})"
        if share is None:
            ledger.skip(name, "a formulation that is not known here")
            return
        if formulation == HARD and len(ocp.zones):
            free = (rows["zone_margins"] > 1e-6).all(axis=1)
        else:
            free = np.ones(len(steps), dtype=bool)
        off = found.residual - rows["residual"]
        if formulation == NEIGHBORING and ocp.max_torque > 0.0:
            # along a torque on the limit its multipliers are off by what no recorded number tells
            on_limit = found.largest >= ocp.max_torque * (1.0 - CUT)
            off = np.where(on_limit, np.maximum(off, 0.0), off)
        ledger.bound(name, steps[free], "solver_status.residual", off[free], share * size)
        name = f"|u| where the limit acts{_said(formulation)}"
        if ocp.max_torque == 0.0:
            ledger.skip(name, "the scenario has no torque limit")
            return
        if formulation == HARD:
            ledger.skip(name, "slsqp keeps the limit as a constraint of its own")
            return
        tolerance = (CUT if formulation == NEIGHBORING else 10.0 * ROUNDING) * ocp.max_torque
        where = "solver_status.predicted_torques"
        ledger.bound(name, steps, where, found.radius_defect, tolerance, "N m")

    def _numbers(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, plans: Plans,
        found: Certificates,
    ) -> None:  # fmt: skip
        bound = self._ledger.bound
        share = FORWARD if formulation in FORWARD_RUN else ROUNDING
        off = found.cost - rows["cost"]
        scale = max(float(np.abs(found.cost).max()), 1e-300)
        limit = (CUT_COST if formulation == NEIGHBORING else 10.0 * ROUNDING) * scale
        bound(f"cost{_said(formulation)}", steps, "solver_status.cost", off, limit)
        claimed = rows["first_costate"]
        size = max(float(np.abs(claimed).max()), 1e-300)
        off = found.costates - claimed
        bound("first costate", steps, "solver_status.first_costate", off, share * size)
        self._margins(formulation, steps, rows, plans, found)
        self._curvature(formulation, steps, rows, found)
        if self._certifier.has_set:
            self._terminal_set(steps, plans, found)

    def _margins(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, plans: Plans,
        found: Certificates,
    ) -> None:  # fmt: skip
        ledger, ocp = self._ledger, self._certifier.ocp
        name, where = f"torque margin{_said(formulation)}", "solver_status.torque_margin"
        if ocp.max_torque > 0.0:
            off = ocp.max_torque - found.largest - rows["torque_margin"]
            share = CUT if formulation == NEIGHBORING else 10.0 * ROUNDING
            ledger.bound(name, steps, where, off, share * ocp.max_torque, "N m")
        else:
            kept = np.isposinf(rows["torque_margin"])
            ledger.require(name, "infinite: no limit", steps, where, kept)
        if not ocp.zones:
            ledger.skip("zone margins", "the scenario has no zones")
        for i, zone in enumerate(ocp.zones):
            margin = zone.margin(plans.attitudes).min(axis=1)
            where = f"solver_status.zone_margins[{i}]"
            off = margin - rows["zone_margins"][:, i]
            ledger.bound("zone margins", steps, where, off, _ANGLE, "rad")

    def _curvature(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, found: Certificates
    ) -> None:
        ledger, name, where = self._ledger, "curvature", "solver_status.min_curvature"
        claimed = rows["min_curvature"]
        if formulation == HARD:
            ledger.skip(name, "slsqp certifies no minimum")
        elif formulation == NEIGHBORING:
            kept = (found.curvature > 0.0) == (claimed > 0.0)
            name = f"curvature{_said(formulation)}"
            ledger.require(name, "sign: of an earlier solve", steps, where, kept)
        else:
            off = found.curvature / claimed - 1.0
            ledger.bound(name, steps, where, off, CURVATURE, "relative")

    def _terminal_set(self, steps: NDArray[np.int64], plans: Plans, found: Certificates) -> None:
        """Require nu >= 0, the end in the set, and on its border where nu > 0: Kalabic (29)."""
        ocp = self._certifier.ocp
        if not isinstance(ocp, TerminalSetOcp) or ocp.level is None:
            return
        ends = zip(plans.attitudes, plans.momenta, plans.references, strict=True)
        share = np.array([ocp.level_of(ocp.terminal_state(*end)) for end in ends]) / ocp.level.value
        where, name = "solver_status.predicted_attitudes", "end of the plan in the terminal set"
        self._ledger.bound(name, steps, where, np.maximum(share - 1.0, 0.0), 1e-9, "of its level")
        nu = found.multiplier
        kept = (nu > -NU) & ((nu < NU) | (share > 1.0 - 1e-6))
        self._ledger.require(
            "multiplier of the terminal set, from the first costate", "nu >= 0, > 0 on the border",
            steps, "solver_status.first_costate", kept,
        )  # fmt: skip


def _said(formulation: str) -> str:
    """Return what tells apart the lines of neighbouring extremals, whose tolerances are wider."""
    return " (neighbouring extremal)" if formulation == NEIGHBORING else ""
