"""Re-solution of every recorded step, by the same controller or another one.

The controller is given the recorded state and reference of each step, so it never flies away from
the recording: differences of the torques are differences of the controllers alone. Where a method
flew along plans, another one is given the motion of these plans to track.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacecraft_gnc.loop.flight import End, Step
from spacecraft_gnc.loop.flight_log import FlightLog
from spacecraft_gnc.loop.protocols import Controller, GovernorDecision, Reference, State
from spacecraft_gnc.types import Array
from spacecraft_gnc.vehicles.replay import complete_steps, require_period
from spacecraft_gnc.vehicles.rigid_body import series
from spacecraft_gnc.vehicles.rigid_body.controllers.report import plan_of, solution_of
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import makes_plans
from spacecraft_gnc.vehicles.rigid_body.resolve.prices import Price, Pricing

if TYPE_CHECKING:
    from spacecraft_gnc.loop.flight import Flight
    from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario

Progress = Callable[[int, int], None]
_NEEDED: Final = ("attitude", "reference", "momentum", "torque")


class Resolved(NamedTuple):
    """A recorded flight beside the answers of another controller; row i is step ``steps[i]``."""

    steps: NDArray[np.int64]
    """(m,) control steps compared; those without a recorded state, reference or torque are not."""
    recorded: Flight
    """(m,) rows as they flew."""
    replayed: Flight
    """The same states and references with the torques and solves of the other controller."""
    prices: tuple[tuple[Price, Price], ...]
    """(m) what each recorded plan and each new one costs by the recorded problem."""

    @property
    def cost_difference(self) -> Array:
        """(m,) cost of the new plan minus the recorded one, both by the recorded problem.

        NaN where one of them has no plan of a converged solve, or the horizons differ.
        """
        flown = np.where(series.unconverged(self.recorded), math.nan, self.recorded.cost)
        return np.array([new.cost for _, new in self.prices]) - flown

    @property
    def plain_cost_difference(self) -> Array:
        """(m,) the same without penalties; NaN also where both solve the same problem."""
        return np.array([new.plain - old.plain for old, new in self.prices])

    @property
    def torque_difference(self) -> Array:
        """(m,) norm of the difference of the torques [N m]."""
        return np.asarray(np.linalg.norm(self.replayed.torque - self.recorded.torque, axis=1))

    @property
    def first_difference(self) -> int | None:
        """First step whose torques are not equal bit for bit; None where all are."""
        differ = (self.replayed.torque != self.recorded.torque).any(axis=1)
        return int(self.steps[np.argmax(differ)]) if differ.any() else None


def resolve(
    flight: Flight,
    recorded: Scenario,
    revised: Scenario,
    *,
    steps: tuple[int, int] | None = None,
    cold: bool = False,
    progress: Progress | None = None,
) -> Resolved:
    """Solve every recorded step again.

    Parameters
    ----------
    flight
        What was flown.
    recorded
        Scenario that flew it; prices the new plans.
    revised
        Scenario of the other controller.
    steps
        First step and the one after the last, as for a slice; by default all.
    cold
        Forget the past before every step. Otherwise the controller keeps its history along the
        flight, as it would have in it: warm start, last optimum, last plan. At the first of
        ``steps`` it has none. The transfer that is planned is kept in any case.
    progress
        Called with (steps done, steps in all).

    Raises
    ------
    ParameterError
        If the periods of the two differ, or no step can be compared.
    """
    controller = revised.build_controller()
    require_period(controller, flight)
    chosen = complete_steps(flight, _NEEDED, steps, "torque")
    controller.warm_up()
    controller.reset()
    plans, pricing = _Plans(recorded, revised), Pricing(recorded, revised)
    forget = getattr(controller, "tracking", controller).reset
    log = FlightLog(type(flight), len(chosen), flight.period)
    prices: list[tuple[Price, Price]] = []
    walked = chosen
    if makes_plans(recorded.method) or makes_plans(revised.method):  # a plan rests on all before
        walked = complete_steps(flight, _NEEDED, (0, int(chosen[-1]) + 1), "torque")
    for k in walked.tolist():
        if cold:
            forget()
        state, given = _recorded(flight, k)
        decision = plans.tracked(state, given)
        command = controller.command(state, decision.reference)
        as_flown = pricing.recorded(state, given.reference, float(flight.cost[k]))
        if k < chosen[0]:
            continue
        log.add(len(prices), Step(state, flight.target[k], decision, command, command.control))
        prices.append((as_flown, pricing.new(solution_of(command), state)))
        if progress is not None:
            progress(len(prices), len(chosen))
    excerpt = _excerpt(flight, chosen)
    answers = log.finish(End(state, decision.reference))
    names = ("torque", "residual", "cost", "solve_time", "iterations", "status", "source")
    replayed = replace(excerpt, **{name: getattr(answers, name) for name in names})
    return Resolved(chosen, excerpt, replayed, tuple(prices))


def _recorded(flight: Flight, k: int) -> tuple[State, GovernorDecision]:
    """Return what the controller was given at step ``k``."""
    state = State(k, flight.attitude[k], flight.momentum[k])
    feedforward = flight.reference_rate[k], flight.reference_torque[k]
    reference = Reference(flight.reference[k], *feedforward)
    alpha, margin = float(flight.alpha[k]), float(flight.governor_margin[k])
    return state, GovernorDecision(reference, alpha, True, margin, "", 0)


class _Plans:
    """The controller that flew along plans, where another method is to track their motion."""

    def __init__(self, recorded: Scenario, revised: Scenario) -> None:
        self._flown: Controller[Any, Any] | None = None
        if makes_plans(recorded.method) and not makes_plans(revised.method):
            self._flown = recorded.build_controller()
            self._flown.warm_up()
            self._flown.reset()

    def tracked(self, state: State, decision: GovernorDecision) -> GovernorDecision:
        """Return the decision with the motion of the plan as its reference, if there is one."""
        if self._flown is None:
            return decision
        plan = plan_of(self._flown.command(state, decision.reference))
        return decision if plan is None else decision._replace(reference=plan.reference)


def _excerpt(flight: Flight, steps: NDArray[np.int64]) -> Flight:
    """Return the rows of ``steps``; what follows the last of them is its end."""
    n, after = flight.n_steps, int(steps[-1]) + 1
    rows = {
        item.name: getattr(flight, item.name)[steps]
        for item in fields(flight)
        if item.name != "period" and not item.name.startswith("final_")
    }
    ends = {}
    if after < n:
        ends = {f"final_{name}": getattr(flight, name)[after] for name in _STATES}
    return replace(flight, **rows, **ends)


_STATES = ("attitude", "momentum", "reference")
