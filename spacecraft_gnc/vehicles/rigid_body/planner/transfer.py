"""Transfer that a scenario plans: body, time, bounds, start and goal.

What flies on board plans with the inertia that the controller believes. Its bounds are those of the
scenario less a reserve, which is left to what tracks the plan.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from spacecraft_gnc import lie
from spacecraft_gnc.errors import GncError, ParameterError, RecordingError
from spacecraft_gnc.parameters.problems import InvalidScenario, Problem, problem_of
from spacecraft_gnc.types import Array, read_only
from spacecraft_gnc.vehicles.rigid_body.scenario import Scenario, known_inertia

if TYPE_CHECKING:  # the solver's kernels are not needed to read parameters
    from spacecraft_gnc.ocp.transfer import AttitudeTransfer, TransferSolution
    from spacecraft_gnc.vehicles.rigid_body.parameters.plan import PlanParameters
    from spacecraft_gnc.vehicles.vehicle import GovernorLaw, Method

_ROUNDING: Final = 1e-9  # relative, of a duration in periods
_MOST: Final = 100_000  # steps of a plan: some seconds, and 200 MB
_SOUGHT: Final = 5000  # steps within which the shortest time is sought, at least
_CONTROLLER, _GOVERNOR = "nmpc_controller", "reference_governor"


def makes_plans(part: Method | GovernorLaw) -> bool:
    """Tell whether a method or a governor law plans a transfer."""
    return "plan.duration" in part.reads


def plans(scenario: Scenario) -> bool:
    """Tell whether the method or the governor of a scenario flies plans."""
    return makes_plans(scenario.method) or makes_plans(scenario.law)


def planning_section(scenario: Scenario) -> str:
    """Return the section whose method or law plans: the controller's first.

    Raises
    ------
    InvalidScenario
        If neither plans.
    """
    if makes_plans(scenario.method):
        return _CONTROLLER
    if makes_plans(scenario.law):
        return _GOVERNOR
    value = f"{scenario.method.name}, with governor {scenario.law.name}: neither plans a transfer"
    need, key = "method: planned, or governor: planned", f"{_CONTROLLER}.method"
    raise InvalidScenario([Problem(scenario.path, None, key, value, need, _how_to_plan(scenario))])


def plan_parameters(scenario: Scenario) -> PlanParameters:
    """Return the group ``plan`` of what plans (`planning_section`).

    Raises
    ------
    InvalidScenario
        If nothing plans.
    """
    controller = planning_section(scenario) == _CONTROLLER
    return scenario.controller.plan if controller else scenario.governor.plan


def real_limits(scenario: Scenario) -> Array:
    """Return lower and upper torque [N m], lower and upper momentum [N m s] (4, 3), componentwise.

    Infinite where there is none.

    Raises
    ------
    InvalidScenario
        If nothing plans, or a bound is none.
    """
    plan = plan_parameters(scenario)
    torque = _pair(scenario, "plan.torque_bounds", plan.torque_bounds)
    momentum = _pair(scenario, "plan.momentum_bounds", plan.momentum_bounds)
    return read_only(np.vstack([torque, momentum]))


def planned_limits(scenario: Scenario) -> Array:
    """Return the bounds of the plan (4, 3): those of `real_limits`, less the reserves.

    Raises
    ------
    InvalidScenario
        As `real_limits`.
    """
    plan = plan_parameters(scenario)
    kept = 1.0 - np.array([plan.torque_reserve, plan.momentum_reserve])
    return read_only(real_limits(scenario) * kept.repeat(2)[:, None])


def planned_steps(scenario: Scenario) -> int:
    """Return N, the control periods of ``plan.duration``.

    Raises
    ------
    InvalidScenario
        If nothing plans, or the duration is no whole number of periods, or too many of them.
    """
    duration, period = plan_parameters(scenario).duration, scenario.period
    steps = round(duration / period)
    if steps > _MOST:
        value = f"{duration!r} s, {steps} control periods"
        remedy = "shorten it, or lengthen nmpc_controller.time_step"
        raise _refused(scenario, "plan.duration", value, f"at most {_MOST} of them", remedy)
    if steps >= 2 and abs(steps * period - duration) <= _ROUNDING * duration:
        return steps
    need = f"a whole number of control periods of {period:g} s, two or more"
    remedy = f"give {max(steps, 2) * period:.12g}"
    raise _refused(scenario, "plan.duration", f"{duration!r} s", need, remedy)


def transfer_of(scenario: Scenario) -> AttitudeTransfer:
    """Return the transfer from the plant's start to the governor's target, at rest there.

    Raises
    ------
    InvalidScenario
        If nothing plans, the inertia is not known, a bound or the duration is refused, the first
        momentum lies outside the planned bounds, or these leave no hope.
    """
    from spacecraft_gnc.dynamics import RigidBody
    from spacecraft_gnc.ocp.transfer import AttitudeTransfer

    plant, limits = scenario.plant, planned_limits(scenario)
    inertia = known_inertia(scenario, _CONTROLLER, scenario.controller.inertia)
    n_steps = planned_steps(scenario)
    _require_start(scenario, limits)
    try:
        transfer = AttitudeTransfer(
            body=RigidBody(inertia, scenario.period),
            n_steps=n_steps,
            start=lie.exp(plant.initial_rotation_vector),
            goal=lie.exp(scenario.governor.target_rotation_vector),
            start_momentum=plant.initial_momentum,
            torque=(limits[0], limits[1]),
            momentum=(limits[2], limits[3]),
        )
    except GncError as error:
        problem = problem_of(error, scenario.path, planning_section(scenario), ())
        if problem is None:
            raise
        key = _KEYS.get(str(error).partition(":")[0], "")
        raise InvalidScenario([replace(problem, key=key or problem.key)]) from error
    _require_hope(scenario, transfer)
    return transfer


def first_plan(scenario: Scenario) -> TransferSolution:
    """Return the plan that a flight begins with: the one of ``plan.file``, else that is found.

    Raises
    ------
    InvalidScenario
        As `transfer_of`; if the file cannot be read or is a plan of another transfer; or if no plan
        is found, with the shortest time for which one is.
    """
    from spacecraft_gnc.ocp.transfer import TransferSolver

    problem, plan = transfer_of(scenario), plan_parameters(scenario)
    if plan.file:
        return _stored(scenario, problem, plan.file)
    solution = TransferSolver(starts=plan.starts).solve(problem)
    if not solution.converged:
        raise InvalidScenario([too_short(scenario, solution)])
    return solution


def too_short(scenario: Scenario, solution: TransferSolution) -> Problem:
    """Return why no plan was found, with the shortest time for which one is."""
    from spacecraft_gnc.ocp.transfer import (
        TransferSolver,
        shortest_possible_steps,
        shortest_transfer,
    )

    problem, key = solution.problem, f"{planning_section(scenario)}.plan.duration"
    h, starts = problem.body.time_step, plan_parameters(scenario).starts
    proven = shortest_possible_steps(problem)
    least = f"no torque within the bounds makes it in less than {proven * h:.6g} s"
    value = f"{problem.duration:.6g} s, in which no plan was found"
    if proven <= problem.n_steps:
        value += f" from {len(solution.tried)} starts"
    try:
        shortest = shortest_transfer(problem, TransferSolver(starts=starts))
    except ParameterError:
        need, remedy = f"a transfer within the bounds ({least})", "widen them"
    else:
        time = f"{shortest.problem.duration:.6g} s"
        need, remedy = f"more: {time} is the shortest found ({least})", "lengthen it"
        if shortest.problem.n_steps <= problem.n_steps:
            need, remedy = f"a time such as {time}, which was found ({least})", "give that"
        remedy += ", or widen the bounds"
    return Problem(scenario.path, None, key, value, need, remedy)


def _stored(scenario: Scenario, problem: AttitudeTransfer, name: str) -> TransferSolution:
    """Return the plan of a file; its path in a scenario's file is relative to that."""
    from spacecraft_gnc.vehicles.rigid_body.planner.file import difference, load_plan

    path = (Path(scenario.path).parent / name).absolute()
    try:
        found = load_plan(path).solution
        differing = difference(found.problem, problem)
        value = f"a plan of {differing}"
    except RecordingError as error:
        differing = str(error)
        value = differing.removeprefix(f"{path}: received ").partition("; required")[0]
    if differing:
        need = "a plan of this scenario's transfer"
        remedy = f"write one, with the same --set: gnc plan {scenario.path} --out ANOTHER.npz"
        raise _refused(scenario, "plan.file", f"'{path}', {value}", need, remedy)
    return found


def _how_to_plan(scenario: Scenario) -> str:
    """Return what makes a scenario plan: all of it, as far as that can be laid over a file."""
    if scenario.law.name != "none" or scenario.controller.zone_names:
        return (
            "write a file like that of phogat_figure4: method: planned, plan.duration, bounds of "
            "the plan in place of max_torque, governor: none, no zones"
        )
    most, period = scenario.controller.max_torque, scenario.period
    values = {"method": "planned", "plan.duration": f"{scenario.n_steps * period:.12g}"}
    if most > 0.0:
        values |= {"max_torque": "0.0", "plan.torque_bounds": f"[{most!r}]"}
    words = " ".join(f"--set '{_CONTROLLER}.{name}={value}'" for name, value in values.items())
    return f"add {words}, or other bounds, also plan.momentum_bounds, and another duration"


_KEYS: Final = {
    "inertia": "nmpc_controller.inertia",
    "start_momentum": "plant.initial_momentum",
}


def _pair(scenario: Scenario, name: str, given: Array) -> Array:
    """Return bounds as (2, 3), lower and upper: of none, 1, 3 or 6 numbers."""
    if given.size == 0:
        return np.array([[-np.inf] * 3, [np.inf] * 3])
    if given.size in (1, 3):
        pair = np.array([np.broadcast_to(-given, (3,)), np.broadcast_to(given, (3,))])
    elif given.size == 6:
        pair = given.reshape(2, 3)
    else:
        need = "1 number, 3 (one an axis) or 6 (lower three, upper three)"
        raise _refused(scenario, name, f"{given.size} numbers", need, "give one of these")
    if ((pair[0] < 0.0) & (pair[1] > 0.0)).all():
        return pair
    need = "bounds that zero lies within: lower ones below it, upper ones above"
    raise _refused(
        scenario, name, f"{given.tolist()}", need, "give positive numbers, .inf for no bound"
    )


def _require_start(scenario: Scenario, limits: Array) -> None:
    """Refuse a first momentum outside the bounds of the plan."""
    momentum = scenario.plant.initial_momentum
    if ((limits[2] <= momentum) & (momentum <= limits[3])).all():
        return
    low, high = limits[2].tolist(), limits[3].tolist()
    reserve = plan_parameters(scenario).momentum_reserve
    less = f" less plan.momentum_reserve, {reserve:g}" if reserve else ""
    need = f"within {low} to {high} N m s (plan.momentum_bounds{less})"
    value, remedy = f"{momentum.tolist()}", "start slower, or widen the bounds"
    key = "plant.initial_momentum"
    raise InvalidScenario([Problem(scenario.path, None, key, value, need, remedy)])


def _require_hope(scenario: Scenario, transfer: AttitudeTransfer) -> None:
    """Refuse bounds within which the transfer takes far longer than is planned for."""
    from spacecraft_gnc.ocp.transfer.certificate import is_too_short

    most = max(_SOUGHT, transfer.n_steps)
    if is_too_short(transfer, most):
        value = f"{transfer.duration:.6g} s"
        need = f"more than {most * scenario.period:.6g} s: no torque within the bounds is faster"
        raise _refused(scenario, "plan.duration", value, need, "lengthen it, or widen the bounds")


def _refused(scenario: Scenario, name: str, value: str, need: str, remedy: str) -> InvalidScenario:
    key = f"{planning_section(scenario)}.{name}"
    return InvalidScenario([Problem(scenario.path, None, key, value, need, remedy)])
