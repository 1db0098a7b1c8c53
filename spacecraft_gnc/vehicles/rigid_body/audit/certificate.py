"""Check each published certificate against its plan."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.ocp.neighboring import FORMULATION as NEIGHBORING
from spacecraft_gnc.ocp.terminal_problem import TerminalSetOcp
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.audit.plans import (
    HARD,
    ROUNDING,
    Certificates,
    Certifier,
    Plans,
)

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.controllers.methods import ControllerParameters

CURVATURE: Final = 1e-3
"""Relative: the published curvature is that of the last linearization, a Newton step away, which is
of the order of the square root of what the step left."""
CONDITIONS: Final = {
    "backward_sweep": 1e-12,
    "single_shooting": 1e-9,
    "neighboring_extremal": 1e-12,
    "slsqp": 1e-9,
    "fsolve": 1e-6,
}
"""Largest difference of the residual from the certificate's, as a share of what lambda2 is made of.

Single shooting and fsolve publish that of (44), forward; it is compared with the gradient's."""
CUT: Final = 1e-6
"""Share of the torque limit that a neighboring extremal's torque may be off, beside its cut."""
CUT_COST: Final = 1e-8
"""Share of the cost that this cut may change."""
LEFT: Final = 2.0
"""How many times ``residual_tolerance``, as a share of what lambda2 is made of, may be left."""
ROUNDED: Final = 1e-13
"""What rounding may leave besides, as the same share, for each step of the horizon."""
CORRECTED: Final = 1e-9
"""Largest share of a lambda2 that a Newton step may change where more is left."""
CORRECTIBLE: Final = 1e-6
"""Largest share of a lambda2 that a Newton step may change in any case, beside the tolerance's."""
SETTLED: Final = {"fsolve": 1e-6, "slsqp": 1e-3}
"""The same share of those that stop by tolerances of scipy, with derivatives by differences."""
AMPLIFIED: Final = 1e3
"""How many times larger than its residual the error of a forward run's costates may be."""
FORWARD_RUN: Final = ("single_shooting", "fsolve")
FORWARD: Final = 1e-6
"""Share of the largest first costate that those differ, which they find by a forward run."""
NU: Final = 1e-6
"""Multiplier of a terminal set that counts as zero."""
_ANGLE: Final = 1e-12  # [rad]
Rows = dict[str, NDArray[Any]]
"""Fields of solver messages (m, ...) by name."""


class CertificateAudit:
    """Compares certificates with what was found of their plans.

    Parameters
    ----------
    certifier
        Problem of the method.
    ledger
        Gets the verdicts.
    parameters
        Of the controller: when Newton's method stops, and by which steps it goes.
    """

    def __init__(
        self, certifier: Certifier, ledger: Ledger, parameters: ControllerParameters
    ) -> None:
        self._certifier = certifier
        self._ledger = ledger
        self._residual_tolerance = parameters.residual_tolerance
        rounded = ROUNDED * certifier.ocp.horizon
        self._newton_share = LEFT * parameters.residual_tolerance + rounded
        self._largest_correction = CORRECTIBLE + AMPLIFIED * parameters.residual_tolerance
        self._keeps_factors = parameters.step_rule == "chord"

    def audit(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, plans: Plans,
        found: Certificates,
    ) -> None:  # fmt: skip
        """Compare the certificates of one formulation."""
        self._dynamics(formulation, steps, plans, found)
        self._conditions(formulation, steps, rows, found)
        self._numbers(formulation, steps, rows, plans, found)

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
            cut = self._cut(found) * ocp.time_step
        bound(
            f"plan obeys the dynamics: momenta{_said(formulation)}", steps, where,
            np.maximum(found.momentum_defect, np.maximum(first - cut, 0.0)), ROUNDING * scale,
            "N m s",
        )  # fmt: skip

    def _conditions(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, found: Certificates
    ) -> None:
        ledger, ocp = self._ledger, self._certifier.ocp
        share = CONDITIONS.get(formulation)
        name = f"residual ({formulation})"
        if share is None:
            ledger.skip(name, "a formulation that is not known here")
            return
        if formulation == HARD and len(ocp.zones):
            free = np.asarray((rows["zone_margins"] > 1e-6).all(axis=1))
        else:
            free = np.ones(len(steps), dtype=bool)
        off = found.residual - rows["residual"]
        if formulation == NEIGHBORING and ocp.max_torque > 0.0:
            # there its multipliers are off by what no recorded number tells: it may claim more
            off = np.where(found.largest >= ocp.max_torque * (1.0 - CUT), np.maximum(off, 0.0), off)
        # along a torque on the limit what a stopped solve has left is no longer to be seen
        on_limit = (ocp.max_torque > 0.0) & (found.largest >= ocp.max_torque * (1.0 - CUT))
        limit = share * found.made_of + found.rounding[:, 1]
        if formulation in FORWARD_RUN:
            limit += AMPLIFIED * self._left(found)
        limit += np.where(on_limit, self._left(found), 0.0)
        ledger.bound(name, steps[free], "solver_status.residual", off[free], limit[free])
        self._converged(formulation, steps, rows["residual"], found, free)
        name = f"|u| where the limit acts{_said(formulation)}"
        if ocp.max_torque == 0.0:
            ledger.skip(name, "the scenario has no torque limit")
            return
        if formulation == HARD:
            ledger.skip(name, "slsqp keeps the limit as a constraint of its own")
            return
        penalty = 2.0 * self._certifier.problem.penalty * ocp.max_torque**2
        limit = 10.0 * ROUNDING * ocp.max_torque + self._left(found) / penalty
        if formulation == NEIGHBORING:
            limit += self._cut(found)
        where = "solver_status.predicted_torques"
        ledger.bound(name, steps, where, found.radius_defect, limit, "N m")

    def _converged(
        self, formulation: str, steps: NDArray[np.int64], residual: Array, found: Certificates,
        free: NDArray[np.bool_],
    ) -> None:  # fmt: skip
        """Require that little is left of what the residual is made of, in whatever units.

        Or that a Newton step would change next to nothing: under strong curvature, as that of a
        steep zone, rounding leaves more.
        """
        if formulation == NEIGHBORING:
            return
        share = residual / np.maximum(found.made_of, 1e-300)
        limit, where = self.share_left(formulation), "solver_status.residual"
        if formulation not in SETTLED:
            share = np.where(found.correction <= CORRECTED, np.minimum(share, limit), share)
            # Terms that say nothing of a torque, such as those of another axis, make a share small.
            share = np.where(found.correction <= self._largest_correction, share, np.inf)
        name = f"converged ({formulation})"
        self._ledger.bound(name, steps[free], where, share[free], limit, "of its terms")

    def share_left(self, formulation: str) -> float:
        """Return the largest residual of a converged solve, as a share of what it is made of."""
        return SETTLED.get(formulation, self._newton_share)

    def _cut(self, found: Certificates) -> Array:
        """Return (m,) how much a neighboring extremal's first torque may be cut to the limit.

        It is what the penalty lets through: sigma / (4 mu0 |u|), with sigma below |lambda2| / |u|.
        """
        ocp = self._certifier.ocp
        if ocp.max_torque == 0.0:
            return np.zeros(len(found.made_of))
        pushed = float(np.linalg.norm(ocp.torque_map, 2)) * found.made_of
        excess = pushed / (4.0 * self._certifier.problem.penalty * ocp.max_torque**2)
        return np.asarray(CUT * ocp.max_torque + excess)

    def _left(self, found: Certificates) -> Array:
        """Return (m,) residuals at which a Newton solve stops at the latest."""
        return np.asarray(self._newton_share * found.made_of)

    def _numbers(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, plans: Plans,
        found: Certificates,
    ) -> None:  # fmt: skip
        bound = self._ledger.bound
        share = FORWARD if formulation in FORWARD_RUN else ROUNDING
        off = found.cost - rows["cost"]
        scale = max(float(np.abs(found.cost).max()), 1e-300)
        limit = (CUT_COST if formulation == NEIGHBORING else 10.0 * ROUNDING) * scale
        limits = limit + self._left_of_cost(found) + found.cost_rounding
        if formulation == NEIGHBORING:
            limits += 2.0 * self._certifier.ocp.time_step * found.made_of * self._cut(found)
        bound(f"cost{_said(formulation)}", steps, "solver_status.cost", off, limits)
        claimed = rows["first_costate"]
        size = max(float(np.abs(claimed).max()), 1e-300)
        off = found.costates - claimed
        limits = np.maximum(share * size, np.repeat(found.rounding, 3, axis=1))
        if formulation in FORWARD_RUN:
            limits += AMPLIFIED * self._left(found)[:, None]
        bound("first costate", steps, "solver_status.first_costate", off, limits)
        self._margins(formulation, steps, rows, plans, found)
        self._curvature(formulation, steps, rows, found)
        if self._certifier.has_set:
            self._terminal_set(steps, plans, found)

    def _left_of_cost(self, found: Certificates) -> Array:
        """Return (m,) how much the cost of what exceeds the limit depends on what a solve left."""
        ocp = self._certifier.ocp
        if ocp.max_torque == 0.0:
            return np.zeros(len(found.largest))
        excess = np.maximum(found.largest**2 - ocp.max_torque**2, 0.0) / ocp.max_torque
        return np.asarray(ocp.horizon * ocp.time_step * excess * self._left(found))

    def _margins(
        self, formulation: str, steps: NDArray[np.int64], rows: Rows, plans: Plans,
        found: Certificates,
    ) -> None:  # fmt: skip
        ledger, ocp = self._ledger, self._certifier.ocp
        name, where = f"torque margin{_said(formulation)}", "solver_status.torque_margin"
        if ocp.max_torque > 0.0:
            off = ocp.max_torque - found.largest - rows["torque_margin"]
            limits = np.full(len(steps), 10.0 * ROUNDING * ocp.max_torque)
            if formulation == NEIGHBORING:
                limits += self._cut(found)
            ledger.bound(name, steps, where, off, limits, "N m")
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
        elif formulation == NEIGHBORING or self._keeps_factors:
            kept = (found.curvature > 0.0) == (claimed > 0.0)
            name = f"curvature{_said(formulation)}"
            ledger.require(name, "sign: of earlier factors", steps, where, kept)
        else:
            off = found.curvature / claimed - 1.0
            limit = max(CURVATURE, 10.0 * math.sqrt(self._residual_tolerance))
            ledger.bound(name, steps, where, off, limit, "relative")

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
    """Return what tells apart the lines of neighboring extremals, whose tolerances are wider."""
    return " (neighboring extremal)" if formulation == NEIGHBORING else ""
