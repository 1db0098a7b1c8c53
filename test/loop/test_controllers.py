"""Controllers beside the plain one: neighboring extremals, continuation, scipy's solvers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.loop import Reference, Source, State
from spacecraft_gnc.ocp import (
    FsolveSolver,
    NeighboringExtremal,
    ShootingOptions,
    ShootingSolver,
    SlsqpSolver,
    StateContinuation,
    Status,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.neighboring_extremal.controller import (
    NominalRunController,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import (
    FsolveController,
    OnlineNeighboringController,
    ShootingController,
    SlsqpController,
    SolverController,
)

LIMIT = 0.01
REST = np.zeros(3)
TARGET = Reference(np.eye(3), REST, REST)
START = State(0, lie.exp(np.array([0.25, 0.5, 0.5])), REST)
TOO_FAST = np.array([0.0, 3.0, 0.0])
NOWHERE = np.full((3, 3), np.nan)


@pytest.fixture
def ocp(build):
    return build().controller.solver.ocp


def nominal(ocp, exact_every=0, n_steps=30):
    exact = ShootingController(ShootingSolver(ocp))
    solver = ShootingSolver(ocp)
    return NominalRunController(exact, solver, START.attitude, REST, n_steps, exact_every)


def fly(ocp, controller, n_steps, state=START):
    """Sources and states along a closed loop."""
    controller.reset()
    commands = []
    for _ in range(n_steps):
        command = controller.command(state, TARGET)
        commands.append(command)
        R, Pi = ocp.body.step(state.attitude, state.momentum, command.control)
        state = State(state.step + 1, R, Pi)
    return commands, state


def test_the_nominal_run_is_flown_along_itself(ocp):
    exact, end = fly(ocp, ShootingController(ShootingSolver(ocp)), 30)
    corrected, same_end = fly(ocp, nominal(ocp), 30)
    assert {command.source for command in corrected} == {Source.NEIGHBORING_EXTREMAL}
    assert all(command.report is None and command.status is None for command in corrected)
    assert lie.angle_between(end.attitude, same_end.attitude) < 1e-6
    for one, other in zip(exact, corrected, strict=True):
        # Cut to the limit, which the penalty exceeds by 3e-9.
        assert np.abs(one.control - other.control).max() < 1e-8


def test_an_exact_solve_is_made_every_so_many_steps_and_beyond_the_end(ocp):
    commands, _ = fly(ocp, nominal(ocp, exact_every=4, n_steps=10), 14)
    exact = [k for k, command in enumerate(commands) if command.source is Source.OPTIMAL]
    assert exact == [0, 4, 8, 10, 11, 12, 13]


def test_a_nominal_run_is_flown_anew_for_another_target(ocp):
    controller = nominal(ocp)
    controller.command(START, TARGET)
    first = controller._run
    controller.command(State(1, *START[1:]), TARGET)
    assert controller._run is first
    turned = Reference(lie.exp(np.array([0.0, 0.0, 0.2])), REST, REST)
    command = controller.command(START, turned)
    assert controller._run is not first
    expected = ShootingSolver(ocp).solve(START.attitude, REST, turned.attitude)
    assert np.abs(command.control - expected.torques[0]).max() < 1e-8
    controller.reset()
    assert controller._run is not None


def test_the_nominal_run_answers_no_state_by_zero(ocp):
    command = nominal(ocp).command(State(3, NOWHERE, REST), TARGET)
    assert command.source is Source.ZERO
    assert not command.control.any()


@pytest.mark.parametrize("why", ["start", "target"])
def test_without_a_nominal_run_every_solve_is_exact(ocp, why):
    controller = nominal(ocp)
    if why == "start":  # one from which nothing can be flown
        controller._start = (START.attitude, TOO_FAST)
        command = controller.command(START, TARGET)
        assert command.source is Source.OPTIMAL
        assert controller._nominal(TARGET) is None
        return
    command = controller.command(START, Reference(NOWHERE, REST, REST))
    assert command.source is Source.ZERO
    assert controller.command(START, TARGET).source is Source.NEIGHBORING_EXTREMAL


def test_the_nominal_run_respects_the_limit_far_from_it(ocp):
    far = State(3, lie.exp(np.array([2.0, -1.0, 0.5])), np.array([0.1, 0.2, -0.1]))
    command = nominal(ocp).command(far, TARGET)
    assert command.source is Source.NEIGHBORING_EXTREMAL
    assert np.linalg.norm(command.control) == pytest.approx(LIMIT, rel=1e-14)


def test_the_online_controller_names_what_it_flies(ocp):
    controller = OnlineNeighboringController(NeighboringExtremal(ocp))
    commands, _ = fly(ocp, controller, 60)
    sources = [command.source for command in commands]
    assert sources[0] is Source.OPTIMAL
    assert sources.count(Source.NEIGHBORING_EXTREMAL) > 30
    assert set(sources) == {Source.OPTIMAL, Source.NEIGHBORING_EXTREMAL}
    for command in commands:
        corrected = command.source is Source.NEIGHBORING_EXTREMAL
        assert (command.report.solution.formulation == "neighboring_extremal") == corrected
    again, _ = fly(ocp, controller, 60)  # fly resets: the same flight, bit for bit
    assert [c.source for c in again] == sources
    assert all(np.array_equal(a.control, b.control) for a, b in zip(again, commands, strict=True))


def test_a_failure_does_not_poison_the_online_controller(ocp):
    controller = OnlineNeighboringController(NeighboringExtremal(ocp))
    fresh = OnlineNeighboringController(NeighboringExtremal(ocp))
    fly(ocp, controller, 5)
    failed = controller.command(State(5, START.attitude, TOO_FAST), TARGET)
    assert failed.report.solution.status is Status.UNSOLVABLE_STEP
    assert controller.command(State(6, NOWHERE, REST), TARGET).source > Source.OPTIMAL
    after = controller.command(State(7, *START[1:]), TARGET)
    expected = fresh.command(State(7, *START[1:]), TARGET)
    assert after.source is Source.OPTIMAL
    assert np.array_equal(after.control, expected.control)


def test_a_continuation_is_tried_where_a_solve_fails(ocp):
    few = ShootingOptions(max_iterations=2)
    plain = SolverController(ShootingSolver(ocp, options=few))
    detour = SolverController(
        ShootingSolver(ocp, options=few), None, StateContinuation(ocp, ShootingOptions())
    )
    assert plain.command(START, TARGET).source is Source.FEEDBACK
    command = detour.command(START, TARGET)
    assert command.source is Source.OPTIMAL
    exact = ShootingSolver(ocp).solve(START.attitude, REST)
    assert np.abs(command.control - exact.torques[0]).max() < 1e-11
    assert np.array_equal(detour._warm_start, command.report.solution.warm_start)


@pytest.mark.parametrize(
    ("controller", "solver"), [(SlsqpController, SlsqpSolver), (FsolveController, FsolveSolver)]
)
def test_scipys_solvers_fly(ocp, controller, solver):
    assert controller.slow
    flown = controller(solver(ocp))
    flown.warm_up()
    commands, state = fly(ocp, flown, 6)
    # slsqp may go on to its last iteration at the first step: its differences are noise by then.
    assert {command.source for command in commands[1:]} <= {Source.OPTIMAL}
    _, exact = fly(ocp, ShootingController(ShootingSolver(ocp)), 6)
    assert lie.angle_between(state.attitude, exact.attitude) < math.radians(0.5)
    assert flown.command(State(9, NOWHERE, REST), TARGET).source > Source.OPTIMAL


class Detour:
    """A continuation that finds what it is told to find."""

    def __init__(self, solution, patience):
        self.solution, self.patience, self.calls = solution, patience, 0

    def solve(self, attitude, momentum, reference=None):
        self.calls += 1
        return self.solution


def test_a_solve_that_takes_long_is_compared_with_another_start(ocp):
    direct = ShootingSolver(ocp).solve(START.attitude, REST)
    for patience, cost, calls, ours in (
        (direct.iterations, 0.0, 0, True),  # short enough
        (direct.iterations - 1, 2.0 * direct.cost, 1, True),  # the other is dearer
        (direct.iterations - 1, 0.5 * direct.cost, 1, False),
    ):
        other = direct.replace(cost=cost, torques=0.5 * direct.torques)
        detour = Detour(other, patience)
        flown = ShootingController(ShootingSolver(ocp), None, detour).command(START, TARGET)
        assert detour.calls == calls
        assert flown.source is Source.OPTIMAL
        assert np.array_equal(flown.control, (direct if ours else other).torques[0])
        assert flown.report.solution.iterations == direct.iterations * (1 + calls)


def test_the_online_sequence_does_not_correct_what_another_start_found(ocp):
    direct = ShootingSolver(ocp).solve(START.attitude, REST)
    for cost, exact in ((0.5 * direct.cost, 2), (2.0 * direct.cost, 1)):
        sequence = NeighboringExtremal(ocp)
        detour = Detour(direct.replace(cost=cost, torques=direct.torques.copy()), 0)
        controller = OnlineNeighboringController(sequence, None, detour)
        controller.command(START, TARGET)
        detour.patience = math.inf
        attitude, momentum = ocp.body.step(START.attitude, REST, direct.torques[0])
        controller.command(State(1, attitude, momentum), TARGET)
        assert (sequence.solved, sequence.corrected) == (exact, 2 - exact)
