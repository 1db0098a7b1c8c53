"""Recorded plans, certified afresh from their own numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from spacecraft_gnc.ocp import AttitudeOcp
from spacecraft_gnc.ocp._data_kernels import ALPHA, MU0
from spacecraft_gnc.ocp._stage_kernels import ZONE_SIZE, work_size
from spacecraft_gnc.ocp._sweep_kernels import FACTOR_SIZE
from spacecraft_gnc.ocp._track_kernels import track_size
from spacecraft_gnc.types import Array, Reference, read_only
from spacecraft_gnc.vehicles.rigid_body.audit import _audit_kernels as kernels
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of

if TYPE_CHECKING:
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

PENALISED: Final = ("shooting", "neighboring_extremal", "fsolve")
HARD: Final = "slsqp"
TERMINAL: Final = "terminal_set"
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

    exists: Array
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
    largest: Array
    """Largest |u| [N m]."""
    curvature: Array
    """Smallest pivot of the second derivative [(N m)^-2]."""
    multiplier: Array
    """Multiplier nu of the terminal set; 0 without one."""
    made_of: Array
    """Scale of lambda2: the sum of the sizes of what adds up to it."""
    correction: Array
    """Largest change of a lambda2 by one Newton step from the plan, as a share of the largest."""
    costates: Array
    """(m, 6) of the first step."""


@dataclass(frozen=True, slots=True)
class Certifier:
    """The problem of a scenario, ready to certify plans."""

    ocp: AttitudeOcp
    data: Array
    """Its numbers, as the kernels take them; slsqp's limit is a hard one."""
    zone_rows: Array
    has_set: bool
    """Whether a multiplier of a terminal set is to be found."""
    has_law: bool = False
    """Whether a step without a solve is answered by a law, not by the failure ladder."""

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> Certifier | None:
        """Return the certifier of a scenario; None where its method makes no plans of ours."""
        method = scenario.controller.method
        if method in PENALISED:
            ocp = problem_of(scenario)
            along_a_run = not np.isnan(scenario.controller.nominal_rotation_vector).any()
            has_law = method == "neighboring_extremal" and along_a_run
            return cls(ocp, ocp.data, ocp.zone_rows, False, has_law)
        if method == HARD:
            return cls._hard(problem_of(scenario))
        if method == TERMINAL:
            from spacecraft_gnc.vehicles.rigid_body.controllers.terminal_set.controller import (
                TerminalSetController,
            )

            ocp = TerminalSetController.problem(scenario)
            return cls(ocp, ocp.data, ocp.zone_rows, ocp.level is not None)
        return None

    @classmethod
    def _hard(cls, ocp: AttitudeOcp) -> Certifier:
        """Limits as constraints: that of the torque is hard, the zones are no part of the cost."""
        data = ocp.data.copy()
        data[ALPHA] = (ocp.max_torque * TOUCHING) ** 2
        data[MU0] = math.inf
        return cls(ocp, read_only(data), read_only(np.zeros((0, ZONE_SIZE))), False)

    def controls(self, torques: Array) -> Array:
        """Return the controls (m, N, n) that make torques (m, N, 3), along the weight's axes."""
        ocp = self.ocp
        if np.array_equal(ocp.torque_map, np.eye(3)):
            return np.ascontiguousarray(torques @ ocp.control_axes)
        return np.ascontiguousarray(torques @ ocp.allocation.T @ ocp.control_axes)

    def warm_up(self) -> None:
        """Compile or load the kernel."""
        n = self.ocp.horizon
        still = np.tile(np.eye(3), (1, n + 1, 1, 1)), np.zeros((1, n + 1, 3)), np.zeros((1, n, 3))
        self.certify(Plans(np.eye(3)[None], *still, np.zeros((1, 6)), np.zeros((1, 2, 3))))

    def multipliers(self, plan: Plans) -> tuple[Array, float]:
        """Return the costates (N, 6) of one plan, and the multiplier of the terminal set."""
        found, costates = self._certify(plan)
        return costates, float(found.multiplier[0])

    def certify(self, plans: Plans) -> Certificates:
        """Work out what plans are worth."""
        return self._certify(plans)[0]

    def _certify(self, plans: Plans) -> tuple[Certificates, Array]:
        """Return the certificates, and the costates (N, 6) of the last plan."""
        ocp, swept = self.ocp, np.empty((2, self.ocp.horizon, 6))
        m, n = len(plans.torques), ocp.horizon
        numbers, costates = np.empty((m, kernels.NUMBERS)), plans.costates.copy()
        references = np.concatenate([plans.references, plans.feedforward], axis=1)
        track = np.empty(track_size(n, ocp.n_controls))
        back = np.ascontiguousarray(np.linalg.pinv(ocp.torque_map @ ocp.control_axes))
        kernels.certify(
            ocp.body.packed, self.data, self.zone_rows, references, plans.attitudes,
            plans.momenta, plans.torques, self.controls(plans.torques), costates, back,
            self.has_set, swept, np.zeros((n, work_size(ocp.n_controls))),
            np.zeros((n, FACTOR_SIZE)), np.empty((2, n, 3)), track,
            np.empty(ocp.data.shape), numbers,
        )  # fmt: skip
        at = numbers.T
        found = Certificates(
            at[kernels.STATUS] == 0.0,
            at[kernels.ATTITUDE_DEFECT],
            at[kernels.MOMENTUM_DEFECT],
            at[kernels.FIRST_DEFECT],
            at[kernels.RESIDUAL],
            at[kernels.RADIUS_DEFECT],
            at[kernels.COST],
            np.sqrt(at[kernels.LARGEST]),
            at[kernels.CURVATURE],
            at[kernels.MULTIPLIER],
            np.maximum(at[kernels.MADE_OF], at[kernels.COSTATE]),
            at[kernels.CORRECTION] / np.maximum(at[kernels.COSTATE], 1e-300),
            costates,
        )
        return found, swept[0]
