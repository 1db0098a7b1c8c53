"""An audit solves claimed failures again and looks for standstills: a false claim is caught."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flown_bags import TERMINAL_SET, edited, first_of, fly, messages_of, rewrite, sections

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.ocp import Status
from spacecraft_gnc.recording import columns
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.vehicles.rigid_body.audit.failures import FAILURES
from spacecraft_gnc.vehicles.rigid_body.audit.standstills import STANDSTILLS

REST = [0.0, 0.0, 0.0]
DIRECT = sections(nmpc_controller={"continuation": "none"})
"""Nothing but the solve warm and cold."""
STAR = {
    "zone_names": ["star"],
    "zones": {
        "star": {
            "body_axis": [1.0, 0.0, 0.0],
            "inertial_axis": [0.9276, 0.3736, 0.0],
            "half_angle_deg": 5.0,
            "penalty": 1000.0,
        }
    },
}
SPUN = sections(
    plant={
        "duration": 8.0,
        "initial_rotation_vector": [0.01, 0.0, -0.01],
        "initial_momentum": [-0.066, -0.031, -0.052],
    },
    nmpc_controller={"max_iterations": 2, "continuation": "none"},
)
"""Two iterations are enough until the torque limit acts: real failures after real solves."""
NUDGED = sections(
    plant={"duration": 8.0, "initial_rotation_vector": [0.02, 0.0, 0.0], "initial_momentum": REST},
    nmpc_controller={"max_iterations": 2, "continuation": "none"},
)
FAR = {6: lie.exp([0.0, 0.0, 2.5]), 16: np.eye(3)}
"""Targets: too far for two iterations, and back."""
HELD = sections(**TERMINAL_SET)
"""An active terminal set."""
HALF_TURN = sections(
    plant={"initial_rotation_vector": [math.pi, 0.0, 0.0], "initial_momentum": REST}
)
"""Every horizon rests at a saddle of the closed loop: ESCAPING at step 0."""
PARKED = sections(
    plant={
        "duration": 60.0,
        "initial_rotation_vector": [0.0, 0.0, 0.5],
        "initial_momentum": REST,
    },
    nmpc_controller=STAR | {"actuators": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0]},
)
"""Two actuators cannot lead round the zone: STALLED in front of it, after an escape."""


def line(audit, name):
    (found,) = [check for check in audit.checks if check.name == name]
    return found


def sources_of(bag):
    return {Source(int(source)) for source in read_flight(bag).trajectory.source}


def statuses_of(bag):
    return [Status(int(status)) for status in read_flight(bag).trajectory.status]


# Honest bags.


@pytest.mark.parametrize(
    ("scenario", "targets", "rungs"),
    [
        (
            sections(nmpc_controller={"max_iterations": 1, "continuation": "none"}),
            {},
            {Source.FEEDBACK},
        ),
        (SPUN, {}, {Source.OPTIMAL, Source.NEIGHBORING_EXTREMAL, Source.FEEDBACK}),
        (NUDGED, FAR, {Source.OPTIMAL, Source.SHIFTED_PLAN, Source.FEEDBACK}),
    ],
    ids=["never solved", "spun", "target moved"],
)
def test_real_failures_fail_again_and_justify_what_flew(tmp_path, scenario, targets, rungs):
    flown = fly(tmp_path, scenario, targets=targets)
    assert sources_of(flown) == rungs
    failed = sum(status is Status.MAX_ITERATIONS for status in statuses_of(flown))
    audit = audit_bag(flown)
    assert audit.passed, audit.first
    counts = audit.counts
    assert counts.solves_repeated == counts.failures_confirmed == failed > 0
    assert counts.fallbacks == counts.fallbacks_justified == failed
    assert line(audit, FAILURES).note == f"{failed} failed again, 0 did not"


def test_a_terminal_set_that_is_out_of_reach_is_so_again(tmp_path):
    flown = fly(tmp_path, HELD, targets={3: lie.exp([0.0, 0.0, 1.5])})
    assert statuses_of(flown)[3:] == [Status.INFEASIBLE] * 7
    audit = audit_bag(flown)
    assert audit.passed, audit.first
    assert (audit.counts.solves_repeated, audit.counts.failures_confirmed) == (7, 7)
    assert line(audit, STANDSTILLS).verdict == "not applicable"


@pytest.mark.parametrize(
    ("scenario", "kinds"),
    [(HALF_TURN, {Status.ESCAPING}), (PARKED, {Status.ESCAPING, Status.STALLED})],
    ids=["half a turn", "parked"],
)
def test_real_standstills_are_found_again_and_no_others(tmp_path, scenario, kinds):
    flown = fly(tmp_path, scenario)
    statuses = statuses_of(flown)
    assert set(statuses) == kinds | {Status.CONVERGED}
    audit = audit_bag(flown)
    assert audit.passed, audit.first
    reported = sum(status in kinds for status in statuses)
    counts = audit.counts
    assert counts.standstills_looked_for == len(statuses)
    assert counts.standstills_found == counts.standstills_reported == reported


@pytest.mark.parametrize("method", ["slsqp", "fsolve", "neighboring_extremal"])
def test_failures_of_every_method_are_solved_again(tmp_path, method):
    """Said to fail at step 4, from which the audit has a warm start, and at step 5, cold."""
    direct = {"continuation": "none"} if method == "neighboring_extremal" else {}
    flown = fly(tmp_path, sections(nmpc_controller={"method": method} | direct), failing={4, 5})
    audit = audit_bag(flown)
    assert first_of(audit) == (FAILURES, 4, "solver_status.status")
    assert (audit.counts.solves_repeated, audit.counts.failures_confirmed) == (2, 0)
    assert "; certified: residual " in line(audit, FAILURES).note


# Forged ones.


def test_a_converged_solve_that_is_called_failed_is_caught(tmp_path):
    flown = fly(tmp_path, DIRECT, failing={0, 1, 2, 3, 4, 5, 6})  # feedback flies
    assert sources_of(flown) == {Source.FEEDBACK, Source.OPTIMAL}
    audit = audit_bag(flown)
    assert [check.name for check in audit.checks if check.first] == [FAILURES]
    assert first_of(audit) == (FAILURES, 0, "solver_status.status")
    found = line(audit, FAILURES)
    assert found.note.startswith("MAX_ITERATIONS claimed, but the solve converges after ")
    assert "; certified: residual " in found.note
    assert found.note.endswith("; 0 failed again, 7 did not")
    counts = audit.counts
    assert (counts.solves_repeated, counts.failures_confirmed) == (7, 0)
    assert (counts.fallbacks, counts.fallbacks_justified) == (7, 0)


def test_a_solve_that_is_said_not_to_have_been_made_is_caught(tmp_path):
    """No plan, no status: the ladder's torque flies as if the solver had refused the state."""
    flown = fly(tmp_path, DIRECT, failing={0})
    changed = [
        (topic, stamp, edited("SolverStatus", status=lambda _: 255, formulation=lambda _: "")(data)
         if topic == "/solver_status" and step_of(data) == 0 else data)
        for topic, stamp, data in messages_of(flown)
    ]  # fmt: skip
    audit = audit_bag(rewrite(flown, tmp_path / "none", changed))
    assert first_of(audit) == (FAILURES, 0, "solver_status.status")
    assert line(audit, FAILURES).note.startswith("NO_SOLVE claimed, but the solve converges")


def test_another_failure_than_the_solves_own_is_caught(tmp_path):
    flown = fly(tmp_path, sections(nmpc_controller={"max_iterations": 1, "continuation": "none"}))
    changed = [
        (topic, stamp, edited("SolverStatus", status=lambda _: int(Status.SINGULAR))(data)
         if topic == "/solver_status" and step_of(data) == 3 else data)
        for topic, stamp, data in messages_of(flown)
    ]  # fmt: skip
    other = rewrite(flown, tmp_path / "other", changed)
    audit = audit_bag(other)
    assert first_of(audit) == (FAILURES, 3, "solver_status.status")
    note = line(audit, FAILURES).note
    assert note.startswith("SINGULAR claimed, but the solve ends as MAX_ITERATIONS")
    assert audit_bag(other, tolerance=1e-12).passed  # between machines any failure will do


def test_a_terminal_set_within_reach_that_is_called_infeasible_is_caught(tmp_path):
    flown = fly(tmp_path, HELD, failing={4}, failure=Status.INFEASIBLE)
    assert statuses_of(flown).count(Status.INFEASIBLE) == 1
    audit = audit_bag(flown)
    assert [check.name for check in audit.checks if check.first] == [FAILURES]
    assert first_of(audit) == (FAILURES, 4, "solver_status.status")
    assert line(audit, FAILURES).note.startswith("INFEASIBLE claimed, but the solve converges")
    assert "; certified: residual " in line(audit, FAILURES).note


@pytest.mark.parametrize(
    ("scenario", "kind"), [(HALF_TURN, "ESCAPING"), (PARKED, "ESCAPING")],
    ids=["half a turn", "parked"],
)  # fmt: skip
def test_a_standstill_that_is_not_looked_for_is_caught(tmp_path, scenario, kind):
    flown = fly(tmp_path, scenario, blind=True)
    assert set(statuses_of(flown)) == {Status.CONVERGED}
    audit = audit_bag(flown)
    assert [check.name for check in audit.checks if check.first] == [STANDSTILLS]
    name, _, where = first_of(audit)
    assert (name, where) == (STANDSTILLS, "solver_status.status")
    expected = f"a standstill is not reported: {kind}, closed-loop radius 1"
    assert line(audit, STANDSTILLS).note.startswith(expected)
    assert audit.counts.standstills_found > audit.counts.standstills_reported == 0


def test_a_stall_that_is_hidden_in_the_message_is_caught(tmp_path):
    flown = fly(tmp_path, PARKED)
    (step, *_) = [i for i, s in enumerate(statuses_of(flown)) if s is Status.STALLED]
    hide = edited(
        "SolverStatus", status=lambda _: 0, closed_loop_radius=lambda _: math.nan,
        active_constraint=lambda _: "",
    )  # fmt: skip
    changed = [
        (topic, stamp, hide(data) if topic == "/solver_status" and step_of(data) == step else data)
        for topic, stamp, data in messages_of(flown)
    ]
    audit = audit_bag(rewrite(flown, tmp_path / "hidden", changed))
    assert first_of(audit) == (STANDSTILLS, step, "solver_status.status")
    assert "a standstill is not reported: STALLED" in line(audit, STANDSTILLS).note


def test_a_standstill_in_mid_flight_is_caught(tmp_path):
    flown = fly(tmp_path)
    claim = edited(
        "SolverStatus", status=lambda _: int(Status.STALLED), closed_loop_radius=lambda _: 0.99
    )
    changed = [
        (topic, stamp, claim(data) if topic == "/solver_status" and step_of(data) == 7 else data)
        for topic, stamp, data in messages_of(flown)
    ]
    audit = audit_bag(rewrite(flown, tmp_path / "claimed", changed))
    assert first_of(audit) == (STANDSTILLS, 7, "solver_status.status")
    note = line(audit, STANDSTILLS).note
    assert note == "a standstill is reported where there is none"


def test_a_plan_by_another_formulation_than_the_methods_is_caught(tmp_path):
    """What the audit asks of a plan depends on its formulation, which is no free choice."""
    flown = fly(tmp_path)
    for name in ("slsqp", "neighboring_extremal", "of my own"):
        claim = edited("SolverStatus", formulation=lambda _, name=name: name)
        changed = [
            (topic, stamp, claim(data) if topic == "/solver_status" else data)
            for topic, stamp, data in messages_of(flown)
        ]
        audit = audit_bag(rewrite(flown, tmp_path / name, changed))
        found = line(audit, "formulation of the method")
        assert found.first == (0, "solver_status.formulation")


@pytest.mark.parametrize("length", [1, 3])
def test_what_is_found_does_not_depend_on_the_blocks_that_are_read(tmp_path, monkeypatch, length):
    """The plan before a failure may stand in an earlier block of messages."""
    flown = fly(tmp_path, SPUN, failing={2})
    whole = audit_bag(flown)
    monkeypatch.setattr(columns, "_BLOCK", length)
    parts = audit_bag(flown)
    assert parts.counts == whole.counts
    assert parts.counts.failures_confirmed == parts.counts.solves_repeated - 1 > 0
    assert line(parts, FAILURES) == line(whole, FAILURES)


@pytest.mark.parametrize("failing", [(), {3}], ids=["real", "forged"])
def test_the_chord_is_repeated_along_the_whole_flight(tmp_path, failing):
    """It goes on with a factorization of earlier steps, so no step can be solved by itself."""
    chord = sections(
        plant=SPUN["plant"],
        nmpc_controller={"step_rule": "chord", "max_iterations": 3, "continuation": "none"},
    )
    flown = fly(tmp_path, chord, failing=failing)
    failed = sum(status is Status.MAX_ITERATIONS for status in statuses_of(flown))
    audit = audit_bag(flown)
    counts = audit.counts
    assert (audit.first is None) == (not failing)
    assert counts.solves_repeated == failed > 0
    assert counts.failures_confirmed == failed - len(failing)
    lost = [
        item for item in messages_of(flown)
        if not (item[0] == "/attitude_state" and step_of(item[2]) == 1)
    ]  # fmt: skip
    audit = audit_bag(rewrite(flown, tmp_path / "lost", lost))
    assert audit.counts.solves_repeated == 0
    assert f"{failed} not solved again: messages before them" in line(audit, FAILURES).note


# What cannot be done.


def test_without_the_plan_before_it_a_failure_is_solved_again_cold(tmp_path):
    flown = fly(tmp_path, NUDGED, targets=FAR)
    kept = [
        item for item in messages_of(flown)
        if not (item[0] == "/solver_status" and step_of(item[2]) == 5)
    ]  # fmt: skip
    audit = audit_bag(rewrite(flown, tmp_path / "lost", kept, lost={"/solver_status": 1}))
    assert first_of(audit)[0] == "steps of solver_status"
    found = line(audit, FAILURES)
    assert (found.verdict, found.steps) == ("pass", 10)
    assert "1 from a cold start only: the plan before is missing" in found.note


@pytest.mark.parametrize("scenario", [DIRECT, SPUN], ids=["forged", "real"])
def test_fallbacks_without_solver_messages_are_solved_again_cold(tmp_path, scenario):
    flown = fly(tmp_path, scenario, failing={0, 1} if scenario is DIRECT else ())
    kept = [item for item in messages_of(flown) if item[0] != "/solver_status"]
    audit = audit_bag(rewrite(flown, tmp_path / "silent", kept))
    found, counts = line(audit, FAILURES), audit.counts
    assert counts.solves_repeated == counts.fallbacks == found.steps > 0
    assert f"{found.steps} from a cold start only" in found.note
    if scenario is DIRECT:
        assert found.first == (0, "solver_status.status")
        assert found.note.startswith("a fallback claimed, but the solve converges after ")
    else:
        assert (found.verdict, counts.failures_confirmed) == ("pass", found.steps)


def test_a_law_without_solves_claims_no_failures(tmp_path):
    audit = audit_bag(fly(tmp_path, sections(nmpc_controller={"method": "feedback"})))
    assert audit.passed, audit.first
    assert audit.counts.solves_repeated == 0
    assert line(audit, FAILURES).note == "method feedback makes no solves"
