"""Costs of recorded and new plans under the recorded problem, with and without penalties."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from spacecraft_gnc.loop.protocols import Controller, Reference, State
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.rigid_body.controllers.report import solution_of
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import problem_of

if TYPE_CHECKING:
    from spacecraft_gnc.ocp import AttitudeOcp, Solution
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario


class Price(NamedTuple):
    """Cost of one plan; NaN where it cannot be told."""

    cost: float = math.nan
    """As the recorded method counts it."""
    plain: float = math.nan
    """Without penalties; NaN where both methods solve the same problem."""
    penalty: float = math.nan
    """The penalties alone; NaN likewise."""
    torque_excess: float = math.nan
    """Largest torque of the plan minus the limit [N m]."""
    zone_excess_deg: float = math.nan
    """Deepest that the plan goes into a pointing zone [deg]; negative: it stays outside."""


class Pricing:
    """Prices new plans and recorded ones by the recorded problem.

    Where the two methods pay for limits in different ways, a plan that leaves one by a hair costs
    any amount by the other's count, so the costs without penalties are told as well. A recorded
    plan is not read: the controller that flew is asked for it again.

    Parameters
    ----------
    recorded, revised
        Scenarios of both controllers.
    """

    def __init__(self, recorded: Scenario, revised: Scenario) -> None:
        self._same = _same_problem(recorded, revised)
        self._hard = recorded.method.hard_limits
        self._ocp: AttitudeOcp | None = None
        self._flown: Controller[Any, Any] | None = None
        if not self._same and _is_penalized(recorded):
            self._ocp = problem_of(recorded)
            self._plain = replace(self._ocp, max_torque=0.0, zones=())
            self._flown = None if self._hard else recorded.build_controller()

    def new(self, solution: Solution | None, state: State) -> Price:
        """Return the price of the plan of a solve from ``state``."""
        if solution is None or not solution.converged:
            return Price()  # the plan of a failed solve may be anything
        if self._same:
            return Price(solution.cost)
        ocp = self._ocp
        if ocp is None or len(solution.torques) != ocp.horizon:
            return Price()
        controls = solution.torques @ ocp.allocation.T
        start = (controls, state.attitude, state.momentum, solution.tracked)
        plain = self._plain.cost(*start)
        penalty = 0.0 if self._hard else ocp.cost(*start) - plain
        return Price(plain + penalty, plain, penalty, *_excess(ocp, controls, solution.attitudes))

    def recorded(self, state: State, reference: Reference, cost: float) -> Price:
        """Return the price of the plan that flew from ``state`` at a recorded ``cost``."""
        if self._flown is not None:
            return self.new(solution_of(self._flown.command(state, reference)), state)
        if self._ocp is not None:
            return Price(cost, cost, 0.0)
        return Price(cost)


def _excess(ocp: AttitudeOcp, controls: Array, attitudes: Array) -> tuple[float, float]:
    """Return by how much a plan exceeds the torque limit [N m], and enters a zone [deg]."""
    largest = float(np.linalg.norm(controls, axis=1).max())
    seen = attitudes[1:-1]  # the last one carries no penalty
    margins = [zone.margin(seen).min() for zone in ocp.zones if len(seen)]
    return (
        largest - ocp.max_torque if ocp.max_torque else math.nan,
        -math.degrees(min(margins)) if margins else math.nan,
    )


def _is_penalized(scenario: Scenario) -> bool:
    """Tell whether a method minimizes the cost of `AttitudeOcp`."""
    return "torque_penalty" in scenario.method.reads


def _same_problem(recorded: Scenario, revised: Scenario) -> bool:
    """Tell whether both minimize the same cost."""
    if not (_is_penalized(recorded) and _is_penalized(revised)):
        return recorded is revised
    if recorded.method.hard_limits != revised.method.hard_limits:
        return False
    one, other = problem_of(recorded), problem_of(revised)
    return one.horizon == other.horizon and all(
        np.array_equal(a, b) for a, b in zip(_numbers(one), _numbers(other), strict=True)
    )


def _numbers(ocp: AttitudeOcp) -> tuple[Array, Array, Array]:
    return ocp.body.packed, ocp.data, ocp.zone_rows
