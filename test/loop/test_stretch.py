"""Steps flown at once have the numbers of single ones, bit for bit."""

from __future__ import annotations

import math
from dataclasses import fields
from time import perf_counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from spacecraft_gnc import lie
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.errors import ParameterError
from spacecraft_gnc.governors import PassThroughGovernor
from spacecraft_gnc.loop import ClosedLoop, Source
from spacecraft_gnc.ocp import (
    AttitudeOcp,
    AutomaticContinuation,
    PointingZone,
    ShootingOptions,
    ShootingSolver,
    Status,
    Weights,
)
from spacecraft_gnc.vehicles.rigid_body.controllers.solvers import ShootingController
from spacecraft_gnc.vehicles.rigid_body.controllers.standstill import StandstillMonitor
from spacecraft_gnc.vehicles.rigid_body.plant import RigidBodyPlant
from spacecraft_gnc.vehicles.rigid_body.stretch import ShootingStretch

UNTIMED = "solve_time"


def assert_same(first, second):
    for name in (field.name for field in fields(first)):
        ours, theirs = np.asarray(getattr(first, name)), np.asarray(getattr(second, name))
        assert ours.dtype == theirs.dtype
        if name == UNTIMED:
            assert np.array_equal(np.isfinite(ours), np.isfinite(theirs))
        else:
            assert ours.tobytes() == theirs.tobytes(), name


def step_by_step(loop):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ShootingStretch, "fly", lambda *_: None)
        return loop.run()


def both(loop):
    """Fly step by step, then at once; return both flights and the steps of each stretch."""
    lengths, fly, single = [], ShootingStretch.fly, step_by_step(loop)

    def counted(stretch, *problem):
        flown = fly(stretch, *problem)
        lengths.append(0 if flown is None else flown.n_steps)
        return flown

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ShootingStretch, "fly", counted)
        return single, loop.run(), lengths


AHEAD = np.array([0.0, 0.0, 1.5])
VECTORS = st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array)


@st.composite
def loops(draw):
    """Return a loop: any body, start, horizon, limit, zones, monitor and continuation."""
    turn = lie.exp(2.0 * draw(VECTORS))
    moments = np.array([draw(st.floats(0.6, 1.0)) for _ in range(3)])
    inertia = turn @ np.diag(moments) @ turn.T
    inertia = 0.5 * (inertia + inertia.T)
    period, substeps = draw(st.sampled_from([0.2, 0.4, 1.0])), draw(st.sampled_from([1, 2, 5]))
    plant = RigidBodyPlant(
        RigidBody(inertia, period / substeps),
        lie.exp(1.8 * draw(VECTORS)),
        draw(st.sampled_from([0.0, 0.01, 0.2])) * draw(VECTORS),
        draw(st.sampled_from([1, 2, 40])),
        substeps,
    )
    zones = tuple(
        PointingZone("exclusion", [1.0, 0.0, 0.0], draw(VECTORS) + AHEAD, 0.3, 1e3)
        for _ in range(draw(st.integers(0, 2)))
    )
    ocp = AttitudeOcp(
        inertia * draw(st.sampled_from([1.0, 1.1])),
        period,
        draw(st.sampled_from([1, 2, 5, 12])),
        Weights(terminal_attitude=draw(st.sampled_from([0.01, 1.0]))),
        draw(st.sampled_from([0.0, 0.01, 0.05])),
        draw(st.sampled_from([1e4, 1e10])),
        zones,
    )
    options = ShootingOptions(
        max_iterations=draw(st.sampled_from([2, 3, 50])),
        formulation=draw(st.sampled_from(["auto", "single_shooting"])),
        step_rule=draw(st.sampled_from(["backtracking", "full", "damped"])),
    )
    solver = ShootingSolver(ocp, draw(st.sampled_from(["exact", "estimated_du"])), options)
    monitor = StandstillMonitor(ocp, draw(st.sampled_from([0.0, 0.001, 0.3])))
    way = draw(st.sampled_from([None, AutomaticContinuation]))
    return ClosedLoop(
        plant,
        ShootingController(solver, monitor, None if way is None else way(ocp, options)),
        PassThroughGovernor(lie.exp(draw(VECTORS))),
    )


@settings(deadline=None, max_examples=80)
@given(loop=loops())
def test_any_loop_flies_the_same(loop):
    single, at_once, _ = both(loop)
    assert_same(single, at_once)


def test_an_ordinary_flight_is_one_stretch(build):
    loop = build()
    single, at_once, lengths = both(loop)
    assert_same(single, at_once)
    assert lengths == [375]
    assert_same(loop.run(), single)  # and leaves nothing behind


def test_each_solve_of_a_stretch_is_timed(build):
    begun = perf_counter()
    flight = build().run()
    passed = perf_counter() - begun
    assert flight.solve_time.min() > 0.0
    assert len(set(flight.solve_time.tolist())) > 10
    assert flight.solve_time.sum() < passed


def test_a_long_flight_is_cut_where_a_signal_may_interrupt_it(build):
    seen = []
    loop = build(2500)
    flight = loop.run(lambda step, n: seen.append((step, n)))
    assert seen == [(1000, 2500), (2000, 2500), (2500, 2500)]
    assert_same(flight, step_by_step(loop))


def test_a_standstill_is_left_to_the_controller(build):
    """Half a turn about the axis of the largest moment: the loop stalls there."""
    loop = build(60, start=(0.0, 0.0, math.pi), watch=())
    single, at_once, lengths = both(loop)
    assert_same(single, at_once)
    assert {Status.STALLED, Status.ESCAPING} & set(single.status.tolist())
    assert 0 in lengths


def test_the_ladder_continues_the_plan_of_a_stretch(build):
    """From the third step on no solve converges: the plan before it was flown at once."""
    loop = build(12, start=(1.0, -0.5, 0.4))
    few = ShootingOptions(max_iterations=1)
    loop.controller.solver = ShootingSolver(loop.controller.solver.ocp, options=few)
    single, at_once, _ = both(loop)
    assert_same(single, at_once)
    assert set(single.source.tolist()) - {Source.OPTIMAL}


def test_a_step_that_does_not_exist_is_refused_alike():
    body = RigidBody(np.diag([1.0, 1.0, 0.2]), 0.4)
    ocp = AttitudeOcp(np.diag([1.0, 1.0, 0.9]), 0.4, 2, Weights(1.0, 0.0, 1e-3, 1.0, 0.0))
    plant = RigidBodyPlant(body, lie.exp(np.array([0.0, 0.0, 2.0])), [0.0, 0.0, 0.0], 400)
    loop = ClosedLoop(
        plant, ShootingController(ShootingSolver(ocp)), PassThroughGovernor(np.eye(3))
    )
    messages = []
    for fly in (step_by_step, ClosedLoop.run):
        with pytest.raises(ParameterError) as refusal:
            fly(loop)
        messages.append(str(refusal.value))
    assert messages[0] == messages[1]


class Derived(RigidBodyPlant):
    """A plant that may do anything in a step."""


class Shaped(PassThroughGovernor):
    """A governor that may decide anything."""


class Other(RigidBody):
    """A body that may move in any way."""


class Wary(StandstillMonitor):
    """A monitor that may look for anything."""


def test_what_is_derived_flies_step_by_step(build):
    loop = build(5)
    plant, controller, governor = loop.plant, loop.controller, loop.governor
    assert plant.stretch(controller, governor, 5) is not None
    derived = Derived(plant.body, np.eye(3), np.zeros(3), 5)
    assert derived.stretch(controller, governor, 5) is None
    assert plant.stretch(controller, Shaped(np.eye(3)), 5) is None
    body = Other(plant.body.inertia, plant.body.time_step)
    moved = RigidBodyPlant(body, np.eye(3), np.zeros(3), 5)
    assert moved.stretch(controller, governor, 5) is None
    watched = ShootingController(controller.solver, Wary(controller.solver.ocp, 0.1))
    assert plant.stretch(watched, governor, 5) is None
    chord = ShootingSolver(controller.solver.ocp, options=ShootingOptions(step_rule="chord"))
    assert plant.stretch(ShootingController(chord), governor, 5) is None
    twin = RigidBodyPlant(plant.body, np.eye(3), np.zeros(3), 5)
    flights = [ClosedLoop(each, controller, governor).run() for each in (derived, twin)]
    assert_same(*flights)


def test_a_log_holds_what_steps_have_in_common(build):
    """Every column is stored, whether it varies from step to step or not."""
    flight = build(7).run()
    for name, column in flight.columns():
        values = getattr(flight, name)
        assert len(values) == (3 if column.at_end else 7)
        if not name.startswith("plan"):  # none is flown
            assert not np.isnan(values).any(), name
