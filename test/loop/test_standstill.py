"""The certificate of the loop at a standstill, and the way out of an unstable one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from spacecraft_gnc import lie
from spacecraft_gnc.loop import Reference, State
from spacecraft_gnc.ocp import AttitudeOcp, PointingZone, ShootingSolver, Status, Weights
from spacecraft_gnc.vehicles.rigid_body.controllers import standstill as module
from spacecraft_gnc.vehicles.rigid_body.controllers.standstill import StandstillMonitor

LIMIT = 0.01
REST = np.zeros(3)
TARGET = Reference(np.eye(3), REST, REST)
HALF_TURNS = np.vstack([math.pi * np.eye(3), -math.pi * np.eye(3)])
# Case II: the zone lies across the way of a turn about z.
STAR = PointingZone("exclusion", [1, 0, 0], [0.9276, 0.3736, 0.0], math.radians(4.9965), 1e3)
# Body x must stay within 20 deg of a direction 57 deg from where the target has it.
WINDOW = PointingZone("inclusion", [1, 0, 0], [math.cos(1), math.sin(1), 0], math.radians(20), 1e3)


def errors_deg(flown):
    attitudes = [*flown.attitude, flown.final_attitude]
    return np.degrees([lie.angle_between(np.eye(3), attitude) for attitude in attitudes])


def findings(loop):
    """Fly a loop; the flight, and (step, command) wherever the monitor had something to say."""
    said, solve = [], loop.controller.command

    def command(state, reference):
        found = solve(state, reference)
        if found.report.standstill is not None:
            said.append((state.step, found))
        return found

    loop.controller.command = command
    return loop.run(), said


def test_nothing_is_said_in_ordinary_flight(build):
    watched, said = findings(build(watch=()))
    assert said == []
    plain = build().run()
    assert np.array_equal(watched.torque, plain.torque)  # nor is anything changed
    assert np.array_equal(watched.status, plain.status)


@pytest.mark.parametrize("seed", range(6))
def test_nothing_is_said_on_the_way_from_other_starts(build, seed):
    start = np.random.default_rng(seed).normal(size=3)
    _, said = findings(build(400, start=start / np.linalg.norm(start) * 2.0, watch=()))
    assert said == []


def test_nothing_is_said_of_a_loop_that_is_only_slow(build):
    slow = build(300, watch=(), weights=Weights(stage_torque=1e4))
    flown, said = findings(slow)
    assert said == []
    assert errors_deg(flown)[0] - errors_deg(flown)[-1] > 1.0  # it does move
    # In one horizon it turns by next to nothing, which is what looks like a standstill.
    assert lie.angle_between(flown.attitude[0], flown.attitude[5]) < 1e-4


@pytest.mark.parametrize("start", HALF_TURNS, ids=["x", "y", "z", "-x", "-y", "-z"])
def test_half_a_turn_away_the_loop_escapes_and_arrives(build, start):
    flown, said = findings(build(750, start=start, watch=()))
    assert [step for step, _ in said] == [0]
    _, command = said[0]
    assert command.status is Status.ESCAPING
    assert command.report.standstill.escaping
    assert command.report.standstill.radius > 1.05
    assert command.report.standstill.active_constraint == ""
    assert command.report.solution.converged  # at a minimum of its horizon: no solve sees it
    assert 0.0 < np.linalg.norm(command.control) <= LIMIT * (1.0 + 1e-15)
    assert flown.status[0] == Status.ESCAPING
    assert set(flown.status[1:]) == {Status.CONVERGED}
    assert errors_deg(flown)[-1] < 0.1  # after 300 s
    assert np.linalg.norm(flown.torque, axis=1).max() < LIMIT + 1e-8


def test_half_a_turn_about_any_axis_is_left(build):
    """Off the principal axes the tail is slower: 0.16 deg at 300 s, 0.1 deg by 320 s."""
    rng = np.random.default_rng(0)
    for axis in [np.ones(3), [1.0, 1.0, 0.0], *rng.normal(size=(5, 3))]:
        start = math.pi * np.array(axis) / np.linalg.norm(axis)
        flown, said = findings(build(800, start=start, watch=()))
        assert [(step, command.status) for step, command in said] == [(0, Status.ESCAPING)]
        assert errors_deg(flown)[750] < 0.2
        assert errors_deg(flown)[-1] < 0.1


def test_left_alone_half_a_turn_away_nothing_moves(build):
    flown = build(50, start=(math.pi, 0.0, 0.0)).run()
    assert errors_deg(flown)[-1] == pytest.approx(180.0)


def test_the_escape_has_one_sign_and_keeps_the_way_already_left(build):
    """The unstable mode of a half turn about x: a turn about x by either side."""
    controller = build(watch=()).controller

    def torque(offset):
        attitude = lie.exp(np.array([math.pi + offset, 0.0, 0.0]))
        return controller.command(State(0, attitude, REST), TARGET).control[0]

    assert torque(0.0) > 0.0  # below rounding: the largest component is positive
    assert torque(0.0) == torque(0.0)
    assert torque(1e-9) > 0.0
    assert torque(-1e-9) > 0.0
    assert torque(1e-4) > 0.0
    assert torque(-1e-4) < 0.0


@pytest.mark.parametrize("limit", [1e-5, 0.0], ids=["tight", "none"])
def test_the_push_fits_the_limit(build, limit):
    command = build(start=(math.pi, 0, 0), watch=(), max_torque=limit).controller.command(
        State(0, lie.exp(np.array([math.pi, 0.0, 0.0])), REST), TARGET
    )
    assert command.status is Status.ESCAPING
    # 1 % of the error over one horizon: PUSH pi J_min / (h N h).
    free = 0.01 * math.pi * 0.8 / (0.4 * 2.0)
    assert np.linalg.norm(command.control) == pytest.approx(limit or free, rel=1e-9)


def test_the_push_is_one_that_the_actuators_can_give(build):
    B = np.array([[1.0, 0.2], [0.0, 0.7], [0.3, -0.5]])
    loop = build(start=(0.0, math.pi, 0.0), watch=(), actuators=B)
    command = loop.controller.command(loop.plant.state, TARGET)
    controls = loop.controller.solver.ocp.allocation @ command.control
    assert command.status is Status.ESCAPING
    assert np.linalg.norm(controls) <= LIMIT * (1.0 + 1e-14)
    assert np.abs(B @ controls - command.control).max() < 1e-17


def test_a_stall_at_the_edge_of_a_window_is_named(build):
    """The target lies outside an inclusion zone: the loop ends at its edge, which is stable."""
    flown, said = findings(build(750, start=(0, 0, 1), watch=["window"], zones=(WINDOW,)))
    assert len(said) > 500
    for _, command in said:
        assert command.status is Status.STALLED
        assert 0.9 < command.report.standstill.radius < 1.0
        assert not command.report.standstill.escaping
        assert command.report.standstill.active_constraint == "window"
        assert np.array_equal(
            command.control, command.report.solution.torques[0]
        )  # nothing is added
    assert said[-1][0] == 749
    assert flown.status[-1] == Status.STALLED
    edge = math.degrees(1.0) - 20.0  # the soft edge gives way a little
    assert errors_deg(flown)[-1] == pytest.approx(edge, abs=0.01)


def test_without_an_actuator_to_go_round_the_loop_is_stalled(build):
    """Case II with one actuator, about z: the idle axes have radius 1, as near as it is known."""
    loop = build(200, start=(0, 0, 0.5), watch=["star"], zones=(STAR,), actuators=np.eye(3)[:, 2:])
    flown, said = findings(loop)
    assert len(said) > 100
    assert {command.status for _, command in said} == {Status.STALLED}
    assert {command.report.standstill.active_constraint for _, command in said} == {"star"}
    assert all(abs(command.report.standstill.radius - 1.0) < 1e-6 for _, command in said)
    assert errors_deg(flown)[-1] == pytest.approx(26.88, abs=0.01)


def test_the_same_place_with_all_actuators_is_left(build):
    flown, said = findings(build(750, start=(0, 0, 0.5), watch=["star"], zones=(STAR,)))
    assert [command.status for _, command in said] == [Status.ESCAPING]
    assert said[0][1].report.standstill.active_constraint == "star"
    assert said[0][1].report.standstill.radius == pytest.approx(1.22, abs=0.01)
    assert errors_deg(flown)[-1] < 0.1


def parked(monitor_limit=LIMIT, zones=()):
    """A solution at rest half a turn from its target, and its problem."""
    ocp = AttitudeOcp(np.diag([1.0, 0.8, 0.8]), 0.4, 5, Weights(), monitor_limit, 1e10, zones)
    return ocp, ShootingSolver(ocp).solve(lie.exp(np.array([math.pi, 0.0, 0.0])), REST)


def stub(monkeypatch, radius, mode=0):
    """Have the loop linearized as diagonal, with one eigenvalue of a given size."""

    class Stub:
        closed_loop = np.diag([radius if i == mode else 0.5 for i in range(6)])

    monkeypatch.setattr(module, "linearize", lambda _: Stub)


def test_the_torque_limit_is_named_where_it_is_what_binds(monkeypatch):
    """By a stub: no problem is known whose loop rests at its torque limit."""
    ocp, solution = parked()
    stub(monkeypatch, 0.9)
    monitor = StandstillMonitor(ocp, 1e-3)
    assert monitor.examine(solution).standstill == (0.9, False, "")
    at_limit = solution.replace(torque_margin=1e-6)
    assert monitor.examine(at_limit).standstill == (0.9, False, "torque limit")


def test_zones_without_names_are_numbered(monkeypatch):
    ocp, solution = parked(zones=(STAR, PointingZone("exclusion", [0, 1, 0], [0, 0, 1], 0.2, 1.0)))
    stub(monkeypatch, 0.9)
    touching = solution.replace(zone_margins=np.array([0.2, -0.01]))
    assert StandstillMonitor(ocp, 1e-3).examine(touching).standstill.active_constraint == "zone 1"


def test_a_mode_that_no_actuator_reaches_is_no_escape(monkeypatch):
    ocp, solution = parked()
    stub(monkeypatch, 1.2, mode=0)  # its left eigenvector has no momentum part
    finding = StandstillMonitor(ocp, 1e-3).examine(solution)
    assert finding.standstill == (1.2, False, "")
    assert np.array_equal(finding.torque, solution.torques[0])
    stub(monkeypatch, 1.2, mode=4)
    assert StandstillMonitor(ocp, 1e-3).examine(solution).standstill.escaping


@pytest.mark.parametrize(("radius", "escaping"), [(1.0 + 1e-8, False), (1.0 + 1e-5, True)])
def test_a_radius_within_rounding_of_one_is_stable(monkeypatch, radius, escaping):
    ocp, solution = parked()
    stub(monkeypatch, radius, mode=4)
    assert StandstillMonitor(ocp, 1e-3).examine(solution).standstill.escaping == escaping


def test_arrived_moving_or_switched_off_it_is_silent():
    ocp, solution = parked()
    assert StandstillMonitor(ocp, 1e-3).examine(solution) is not None
    assert StandstillMonitor(ocp, 0.0).examine(solution) is None
    assert StandstillMonitor(ocp, 3.2).examine(solution) is None  # further than half a turn
    solver = ShootingSolver(ocp)
    away = solver.solve(lie.exp(np.array([math.pi, 0.0, 0.0])), np.array([0.01, 0.0, 0.0]))
    assert StandstillMonitor(ocp, 1e-3).examine(away) is None


@pytest.mark.parametrize("mass", [1e-11, 1e-6, 1e8, 1e13])
def test_the_way_out_is_the_same_for_a_body_of_any_size(mass):
    """All masses times a number: the same problem in other units."""

    def found(a):
        weights = Weights(0.01, 0.01 / a**2, 1.0 / a**2, 0.01, 0.01 / a**2)
        inertia = a * np.diag([1.0, 0.8, 0.8])
        ocp = AttitudeOcp(inertia, 0.4, 5, weights, a * LIMIT, 1e10 / a**4)
        solution = ShootingSolver(ocp).solve(lie.exp([math.pi, 0.0, 0.0]), REST)
        assert solution.converged
        return StandstillMonitor(ocp, math.radians(0.1)).examine(solution)

    one, other = found(1.0), found(mass)
    assert other.standstill.escaping
    assert other.standstill.radius == pytest.approx(one.standstill.radius, rel=1e-9)
    assert other.torque / mass == pytest.approx(one.torque, rel=1e-9)
