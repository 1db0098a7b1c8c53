"""Plans of transfers in a bag: what the scenario asks for, optimal, and from where the body was.

Each is certified from its own numbers (`transfer_conditions`, `transfer_curvature`); the planner is
not asked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.audit.evidence import Evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.governors.planned.report import Cause
from spacecraft_gnc.status import Status
from spacecraft_gnc.types import Array, Matrix3
from spacecraft_gnc.vehicles.rigid_body.audit.believed import Believed
from spacecraft_gnc.vehicles.rigid_body.audit.transfer_conditions import (
    FirstOrder,
    Transfer,
    first_order,
)
from spacecraft_gnc.vehicles.rigid_body.audit.transfer_curvature import is_curved
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import (
    plan_parameters,
    planned_limits,
    planned_steps,
)
from spacecraft_gnc.vehicles.rigid_body.signals import ATTITUDE_PLAN, STATE

if TYPE_CHECKING:
    from spacecraft_gnc.audit.evidence import Progress
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

TOLERANCE: Final = 1e-8
"""Largest residual of an optimal plan, over the units of torque and momentum."""
ROUNDING: Final = 1e-12
"""Of a turn, over the units, and of a cost."""
START: Final = 1e-9
"""Distance of a start from the predicted one: [rad], and over the largest momentum."""
CURVATURE: Final = 1e-5
"""Share of the told lower bound on the curvature that need not be there."""
WHOLE: Final = "plans of transfers, whole"
_CONDITIONS: Final = {
    "plan of a transfer: rotations": ("rotations", "attitudes", ROUNDING),
    "plan of a transfer: turns of the momenta": ("turns", "attitudes", ROUNDING),
    "plan of a transfer: no turn of another branch": ("branch", "attitudes", 0.0),
    "plan of a transfer: momenta of the torques": ("momenta", "momenta", TOLERANCE),
    "plan of a transfer: ends at the goal": ("end_attitude", "attitudes", TOLERANCE),
    "plan of a transfer: ends at rest": ("end_momentum", "momenta", TOLERANCE),
    "plan of a transfer: stationary by the torque": ("torques", "co_momenta", TOLERANCE),
    "plan of a transfer: co-momenta": ("co_momenta", "co_momenta", TOLERANCE),
    "plan of a transfer: within the bounds": ("bounds", "torques", TOLERANCE),
    "plan of a transfer: signs of the multipliers": ("signs", "torque_multipliers", TOLERANCE),
}
_SIZES: Final = {
    "attitudes": (9, 1), "momenta": (3, 1), "torques": (3, 0), "co_momenta": (3, 0),
    "torque_multipliers": (3, 0), "momentum_multipliers": (3, 1),
}  # fmt: skip
"""Numbers of a node, and nodes more than N, by field."""


class Told(NamedTuple):
    """A plan as it was told."""

    step: int
    """At which it was taken."""
    number: int
    first_step: int
    cause: int
    plan: Transfer
    told: Mapping[str, float]
    """``status``, ``cost``, ``residual``, ``min_curvature``."""

    @property
    def n_steps(self) -> int:
        """N."""
        return len(self.plan.torques)

    def torques(self, step: int, count: int) -> Array:
        """Return the torques (count, 3) from a control step on [N m]; zero after the end."""
        planned = self.plan.torques[max(0, step - self.first_step) :][:count]
        return np.vstack([planned, np.zeros((count - len(planned), 3))])


def read_told(evidence: Evidence, ledger: Ledger) -> tuple[Told, ...]:
    """Return the plans of a bag in the order of their steps, but for those that are not whole."""
    columns = evidence.columns[ATTITUDE_PLAN]
    found = []
    for i in range(columns.steps.size):
        row = {name: values[i] for name, values in columns.fields.items()}
        count = int(np.isfinite(row["torques"]).sum())
        n = count // 3
        whole = n >= 1 and all(
            np.isfinite(row[name]).sum() == width * (n + more)
            for name, (width, more) in _SIZES.items()
        )
        at = columns.steps[i : i + 1]
        ledger.require(WHOLE, "N and N + 1 nodes", at, str(ATTITUDE_PLAN), np.array([whole]))
        if whole:
            found.append(_told(int(at[0]), row, n))
    return tuple(found)


def _told(step: int, row: Mapping[str, Any], n: int) -> Told:
    def nodes(name: str) -> Array:
        width, more = _SIZES[name]
        values = np.asarray(row[name], dtype=np.float64)[: width * (n + more)]
        return np.ascontiguousarray(values).reshape(n + more, width)

    plan = Transfer(
        inertia=row["inertia"].reshape(3, 3),
        time_step=float(row["time_step"]),
        limits=np.concatenate([row["torque_bounds"], row["momentum_bounds"]]).reshape(4, 3),
        goal=row["goal"].reshape(3, 3),
        attitudes=nodes("attitudes").reshape(-1, 3, 3),
        momenta=nodes("momenta"),
        torques=nodes("torques"),
        co_momenta=nodes("co_momenta"),
        zeta=row["zeta"],
        torque_multipliers=nodes("torque_multipliers"),
        momentum_multipliers=nodes("momentum_multipliers"),
    )
    told = {name: float(row[name]) for name in ("status", "cost", "residual", "min_curvature")}
    number, first, cause = (int(row[name]) for name in ("number", "first_step", "cause"))
    return Told(step, number, first, cause, plan, told)


class TransferAudit:
    """Checks told plans one by one."""

    def __init__(self, evidence: Evidence, ledger: Ledger) -> None:
        self._evidence, self._ledger = evidence, ledger
        self._scenario: Scenario = evidence.scenario
        self._limits = planned_limits(self._scenario)
        self._believed = Believed.of(self._scenario)

    def audit(
        self,
        plans: tuple[Told, ...],
        targets: Mapping[int, Matrix3],
        ahead: Mapping[int, Array],
        progress: Progress | None,
    ) -> None:
        """Enter the checks of plans.

        Parameters
        ----------
        plans
            In the order of their steps.
        targets
            (3, 3) what was wanted, by step.
        ahead
            (m, 3) torques that the tracking foresaw, by the step at which a plan was asked for;
            those of the plan before follow. Steps of which this is not known are left out.
        progress
            Called with the plans done and in all.
        """
        for i, each in enumerate(plans):
            self._asked_for(each, targets)
            self._lasts(each, plans[:i])
            self._starts(each, plans[:i], ahead)
            self._certify(each)
            if progress is not None:
                progress(i + 1, len(plans))

    def _asked_for(self, each: Told, targets: Mapping[int, Matrix3]) -> None:
        """Compare a plan with what the scenario asks for."""
        name, plan, limits = "plan of a transfer: as the scenario asks", each.plan, self._limits
        first, start = each.cause == Cause.START, plan.momenta[0]
        if not first:
            low, high = limits[2:]
            limits = np.vstack([limits[:2], np.minimum(low, start), np.maximum(high, start)])
        asked = each.first_step if first else self.asked(each)
        goal = targets.get(asked)
        if first:
            goal = lie.exp(self._scenario.governor.target_rotation_vector)
        expected = {
            "inertia": self._believed.inertia,
            "time_step": np.array([self._believed.period]),
            "bounds": limits,
            **({} if goal is None else {"goal": goal}),
        }
        recorded = {
            "inertia": plan.inertia, "time_step": np.array([plan.time_step]),
            "bounds": plan.limits, "goal": plan.goal,
        }  # fmt: skip
        for field, values in expected.items():
            where = f"{ATTITUDE_PLAN}.{field}"
            self._compare(name, each, where, recorded[field], values)

    def asked(self, each: Told) -> int:
        """Return the step at which a further plan was asked for."""
        return each.first_step - plan_parameters(self._scenario).replan_lead

    def _lasts(self, each: Told, earlier: tuple[Told, ...]) -> None:
        """Require the scenario's time, of a further plan what was left or more."""
        wanted = planned_steps(self._scenario)
        kept = each.n_steps == wanted
        if each.cause != Cause.START and earlier:
            if each.cause == Cause.DEVIATION:
                wanted = earlier[-1].first_step + earlier[-1].n_steps - each.first_step
            kept = each.n_steps >= wanted
        name, need = "plan of a transfer: its duration", "plan.duration, or what is left of it"
        self._require(name, need, each, "torques", kept)

    def _starts(self, each: Told, earlier: tuple[Told, ...], ahead: Mapping[int, Array]) -> None:
        """Compare the start of a plan with the scenario's, or with a prediction from where it was.

        The body that is believed is carried on from the state at which the plan was asked for, by
        what the tracking foresaw, or by the plan before.
        """
        name, plan = "plan of a transfer: its start", each.plan
        if each.cause == Cause.START:
            plant = self._scenario.plant
            R, Pi = lie.exp(plant.initial_rotation_vector), plant.initial_momentum
        else:
            asked, lead = self.asked(each), plan_parameters(self._scenario).replan_lead
            at = np.array([asked])
            state = self._evidence.rows(STATE, "attitude", at).reshape(3, 3)
            momentum = self._evidence.rows(STATE, "angular_momentum", at)[0]
            if not earlier or asked not in ahead or not np.isfinite(momentum).all():
                self._ledger.check(name, "", f"step {asked} was not recorded: not foreseen")
                return
            torques, foreseen = earlier[-1].torques(asked, lead), ahead[asked][:lead]
            torques[: len(foreseen)] = foreseen
            R, Pi = self._believed.ahead(state, momentum, torques)
        off = plan.attitudes[0] - R
        self._bound(name, each, "attitudes", off.ravel(), START)
        scale = max(float(np.abs(plan.momenta).max()), 1e-300)
        self._bound(name, each, "momenta", (plan.momenta[0] - Pi) / scale, START)

    def _certify(self, each: Told) -> None:
        """Certify a plan by (5.6)-(5.8) and by its curvature."""
        plan, told = each.plan, each.told
        try:
            found = first_order(plan)
        except np.linalg.LinAlgError:  # of numbers that are no motion
            found = FirstOrder(*[math.inf] * len(FirstOrder._fields))
        for name, (part, field, limit) in _CONDITIONS.items():
            self._bound(name, each, field, np.array([getattr(found, part)]), limit)
        name = "plan of a transfer: residual told"
        off = max(abs(found.residual - told["residual"]), told["residual"])
        self._bound(name, each, "residual", np.array([off]), TOLERANCE)
        cost = 0.5 * float(np.sum(plan.torques**2))
        off = abs(cost - told["cost"]) / max(cost, 1e-300)
        self._bound("plan of a transfer: cost", each, "cost", np.array([off]), ROUNDING)
        optimal = told["status"] == Status.CONVERGED
        self._require("plan of a transfer: optimal", "status 0", each, "status", optimal)
        self._second_order(each)

    def _second_order(self, each: Told) -> None:
        bound = each.told["min_curvature"]
        try:
            kept = bound > 0.0 and is_curved(each.plan, bound * (1.0 - CURVATURE))
        except np.linalg.LinAlgError:  # of numbers that are no motion
            kept = False
        name = "plan of a transfer: curvature where no bound acts"
        self._require(name, "> 0, and at least what is told", each, "min_curvature", kept)

    # Entries of one plan.

    def _at(self, each: Told) -> Any:
        return np.array([each.step])

    def _bound(self, name: str, each: Told, field: str, off: Array, limit: float) -> None:
        where = f"{ATTITUDE_PLAN}.{field}"
        self._ledger.bound(name, self._at(each), where, off[None], limit)

    def _require(self, name: str, tolerance: str, each: Told, field: str, kept: bool) -> None:
        where = f"{ATTITUDE_PLAN}.{field}"
        self._ledger.require(name, tolerance, self._at(each), where, np.array([kept]))

    def _compare(self, name: str, each: Told, where: str, told: Array, expected: Array) -> None:
        recorded, wanted = {where: told.reshape(1, -1)}, {where: expected.reshape(1, -1)}
        self._ledger.compare(name, self._at(each), recorded, wanted)
