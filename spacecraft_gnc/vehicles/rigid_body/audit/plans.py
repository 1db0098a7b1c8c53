"""Recorded plans, certified again from their own numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.ocp import AttitudeOcp
from spacecraft_gnc.ocp.neighboring import FORMULATION as NEIGHBORING
from spacecraft_gnc.ocp.shooting import AUTOMATIC
from spacecraft_gnc.types import Array, Reference
from spacecraft_gnc.vehicles.rigid_body.audit.conditions import (
    cost_of,
    least_cost,
    limit_of,
    made_of,
    stages_of,
    sweep,
    track_of,
)
from spacecraft_gnc.vehicles.rigid_body.audit.problem import Problem
from spacecraft_gnc.vehicles.rigid_body.audit.second_order import (
    correction,
    factors_of,
    smallest_pivot,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

HARD: Final = "slsqp"
"""Formulation with the limits as constraints of its own."""
ROUNDING: Final = 1e-13
"""Relative: a few hundred roundings, of the sums over a horizon."""
COSINE: Final = 2.0**-50
"""Rounding of the cosine between an axis and that of a zone."""
TOUCHING: Final = 1.0 - 1e-6  # share of the limit from which slsqp's counts as active


class Plans(NamedTuple):
    """Plans of m steps over N steps each, and what they were made for."""

    references: Array
    """(m, 3, 3) attitudes tracked at the start."""
    attitudes: Array
    """(m, N+1, 3, 3)"""
    momenta: Array
    """(m, N+1, 3) [N m s]"""
    torques: Array
    """(m, N, 3) [N m]"""
    costates: Array
    """(m, 6) of the first step, as published."""
    feedforward: Array
    """(m, 2, 3) angular velocity [rad/s] and torque [N m] with which the references move."""

    def reference(self, i: int) -> Reference:
        """Return what plan ``i`` tracks."""
        return Reference(self.references[i], *self.feedforward[i])


class Certificates(NamedTuple):
    """What plans (m) are worth, worked out from them."""

    exists: NDArray[np.bool_]
    """Whether every step of the integrator exists."""
    attitude_defect: Array
    """Largest difference of a planned rotation from the integrator's [-]."""
    momentum_defect: Array
    """The same of the momenta [N m s], after the first step."""
    first_defect: Array
    """The same of the first step."""
    residual: Array
    """Euclidean norm of the first-order conditions in the units of lambda2."""
    radius_defect: Array
    """Largest difference of |u| from what the conditions say where the limit acts [N m]."""
    cost: Array
    cost_rounding: Array
    """What rounding may make of the cost: it is of squares of what a plan is off its reference."""
    largest: Array
    """Largest |u| [N m]."""
    curvature: Array
    """Smallest pivot of the second derivative [(N m)^-2]."""
    multiplier: Array
    """Multiplier nu of the terminal set; 0 without one."""
    made_of: Array
    """Scale of lambda2: the sum of the sizes of what adds up to it."""
    rounding: Array
    """(m, 2) What rounding may make of a lambda1 and a lambda2."""
    correction: Array
    """Largest change of a lambda2 by one Newton step from the plan, as a share of the largest, but
    for what rounding may make of it."""
    costates: Array
    """(m, 6) of the first step."""


@dataclass(frozen=True, slots=True)
class Certifier:
    """The problem of a scenario, ready to certify plans."""

    problem: Problem
    formulations: tuple[str, ...]
    """How the method solves its conditions, as its plans say."""
    has_set: bool = False
    """Whether a multiplier of a terminal set is to be found."""
    has_law: bool = False
    """Whether a step without a solve is answered by a law, not by the failure ladder."""
    watches: bool = True
    """Whether the method looks for standstills."""
    command: str = "torque_command.torque"
    """Field of what the solver commands."""
    tracking: Callable[[Scenario], Any] | None = None
    """Builds what solves, where the controller does more; None: the controller."""

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> Certifier | None:
        """Return the certifier of a scenario; None where its method makes no plans of ours."""
        named = scenario.method.certifier
        found: Certifier | None = None if named is None else named.load()(scenario)
        return found

    @property
    def ocp(self) -> AttitudeOcp:
        """The problem as the method has it."""
        return self.problem.ocp

    def controller(self, scenario: Scenario) -> Any:
        """Return a new controller that solves as the flown one did."""
        return scenario.build_controller() if self.tracking is None else self.tracking(scenario)

    def warm_up(self) -> None:
        """Compile or load the kernel."""
        self.problem.turns(np.zeros((1, 3)))

    def multipliers(self, plan: Plans) -> tuple[Array, float]:
        """Return the costates (N, 6) of one plan, and the multiplier of the terminal set."""
        found, costates = self._certify(plan)
        return costates[0], float(found.multiplier[0])

    def certify(self, plans: Plans) -> Certificates:
        """Work out what plans are worth."""
        return self._certify(plans)[0]

    @np.errstate(all="ignore")  # numbers of a recording may be of any size
    def _certify(self, plans: Plans) -> tuple[Certificates, Array]:
        """Return the certificates, and the costates (m, N, 6)."""
        problem, R, Pi = self.problem, plans.attitudes, plans.momenta
        u = plans.torques
        if not np.array_equal(self.ocp.torque_map, np.eye(3)):
            u = u @ self.ocp.allocation.T
        F, exists = problem.turns(Pi[:, :-1])
        track = track_of(problem, plans.references, plans.feedforward)
        s = stages_of(problem, R, Pi, u, track, F)
        turned = np.abs(R[:, :-1] @ F - R[:, 1:]).max(axis=(1, 2, 3))
        pushed = np.abs(s.p + self.ocp.time_step * plans.torques - Pi[:, 1:]).max(axis=2)
        share = np.ones(len(u))
        if self.has_set:  # nu from the first costate, which is linear in it
            first = sweep(problem, s, share)[:, 0]
            slope = sweep(problem, s, 2.0 * share)[:, 0] - first
            square = np.sum(slope * slope, axis=1)
            along = np.sum(slope * (plans.costates - first), axis=1)
            share = 1.0 + np.divide(along, square, out=np.zeros(len(u)), where=square > 0.0)
        lam = sweep(problem, s, share)
        limit = limit_of(problem, s, lam)
        factors = factors_of(problem, s, lam, limit.sigma, share)
        costate = np.linalg.norm(lam[..., 3:], axis=2).max(axis=1)
        terms, steep = made_of(problem, s, share)
        size = np.maximum(terms[:, 1], costate)
        corrected = correction(problem, s, factors, limit.left)
        cost, least = cost_of(problem, s, limit.sigma), least_cost(problem, s)
        rounding = ROUNDING * terms + COSINE * steep
        corrected = np.maximum(corrected - rounding[:, 1], 0.0)
        exist = np.asarray(exists.all(axis=1) & track.exists)
        found = Certificates(
            exists=exist,
            attitude_defect=turned,
            momentum_defect=pushed[:, 1:].max(axis=1, initial=0.0),
            first_defect=pushed[:, 0],
            residual=np.linalg.norm(limit.left, axis=(1, 2)),
            radius_defect=limit.radius_defect,
            cost=cost,
            cost_rounding=least + 2.0 * np.sqrt(cost * least),
            largest=np.linalg.norm(u, axis=2).max(axis=1),
            curvature=smallest_pivot(problem, factors),
            multiplier=share - 1.0,
            made_of=size,
            rounding=rounding,
            correction=corrected / np.maximum(costate, 1e-300),
            costates=lam[:, 0],
        )
        return _of_existing(found, plans.costates), lam


def _of_existing(found: Certificates, claimed: Array) -> Certificates:
    """Return certificates that say nothing of plans with a step that does not exist."""
    if found.exists.all():
        return found
    kept = {
        name: np.where(found.exists, values, 0.0)
        for name, values in found._asdict().items()
        if name != "exists" and values.ndim == 1
    }
    costates = np.where(found.exists[:, None], found.costates, claimed)
    return found._replace(**kept, costates=costates)


# The certifiers of the methods, as each of them names its own.


def of_penalties(scenario: Scenario) -> Certifier:
    """Certify plans of Newton's method on the cost with penalties."""
    return Certifier(Problem.of(problem_of(scenario)), (_formulation(scenario),))


def of_tracking(scenario: Scenario) -> Certifier:
    """Certify, likewise, those that track a plan; bounds are kept after them."""
    from spacecraft_gnc.vehicles.rigid_body.controllers.planned.tracking import tracking_of

    certifier = of_penalties(scenario)
    return replace(certifier, command="plan_status.nominal_torque", tracking=tracking_of)


def of_corrections(scenario: Scenario) -> Certifier:
    """Certify, likewise, those of neighboring extremals: on line, or of a law along a run."""
    has_law = not bool(np.isnan(scenario.controller.nominal_rotation_vector).any())
    formulations = (_formulation(scenario), *(() if has_law else (NEIGHBORING,)))
    return Certifier(Problem.of(problem_of(scenario)), formulations, has_law=has_law)


def of_equations(scenario: Scenario) -> Certifier:
    """Certify plans of fsolve."""
    return Certifier(Problem.of(problem_of(scenario)), (scenario.controller.method,))


def of_constraints(scenario: Scenario) -> Certifier:
    """Certify plans of slsqp: its limits are constraints, and zones no part of the cost."""
    ocp = problem_of(scenario)
    return Certifier(Problem.of(ocp, ocp.max_torque * TOUCHING), (HARD,))


def of_terminal_set(scenario: Scenario) -> Certifier:
    """Certify plans with a terminal set."""
    from spacecraft_gnc.vehicles.rigid_body.controllers.terminal_set.controller import (
        TerminalSetController,
    )

    ocp = TerminalSetController.problem(scenario)
    has_set = ocp.level is not None
    return Certifier(Problem.of(ocp), (AUTOMATIC,), has_set=has_set, watches=False)


def _formulation(scenario: Scenario) -> str:
    named = scenario.controller.formulation
    return AUTOMATIC if named == "auto" else str(named)
