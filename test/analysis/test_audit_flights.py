"""An audit passes what every method flew, and works out again what is no first torque of a plan."""

from __future__ import annotations

import math

import pytest
from flown_bags import TERMINAL_SET, edited, first_of, flipped, fly, messages_of, rewrite, sections

from spacecraft_gnc import lie
from spacecraft_gnc.analysis.audit import audit_bag
from spacecraft_gnc.analysis.metrics import summarize
from spacecraft_gnc.analysis.reader import read_flight
from spacecraft_gnc.audit.counts import Counts
from spacecraft_gnc.audit.evidence import read_evidence
from spacecraft_gnc.audit.ledger import Ledger
from spacecraft_gnc.loop.protocols import Source
from spacecraft_gnc.recording.bag import open_bag
from spacecraft_gnc.recording.stamps import step_of
from spacecraft_gnc.scenario.recorded import parse_scenario, scenario_texts
from spacecraft_gnc.vehicles.rigid_body.audit.failures import FAILURES
from spacecraft_gnc.vehicles.rigid_body.audit.flight import AUDIT
from spacecraft_gnc.vehicles.rigid_body.audit.plans import Certifier
from spacecraft_gnc.vehicles.rigid_body.audit.solver import SolverAudit

APPLIED = "plant_invariants.applied_torque"
NS = 400_000_000  # control period [ns]
CODEC_NAMES = {"/torque_command": "TorqueCommand", "/plant_invariants": "PlantInvariants"}
FLIGHTS = {
    "single shooting": {"nmpc_controller": {"formulation": "single_shooting"}},
    "estimated": {"nmpc_controller": {"variant": "estimated_du"}},
    "on-line neighboring extremals": {"nmpc_controller": {"method": "neighboring_extremal"}},
    "a stored run": {
        "nmpc_controller": {
            "method": "neighboring_extremal",
            "nominal_rotation_vector": [0.3, 0.45, 0.5],
            "nominal_momentum": [0.0, 0.0, 0.0],
            "exact_every": 5,
        }
    },
    "a loose tolerance": {"nmpc_controller": {"residual_tolerance": 1e-6}},
    "a very loose tolerance and a soft limit": {
        "nmpc_controller": {"residual_tolerance": 1e-4, "torque_penalty": 1.0e4}
    },
    "the chord": {"nmpc_controller": {"step_rule": "chord", "residual_tolerance": 1e-7}},
    "loose single shooting": {
        "nmpc_controller": {"formulation": "single_shooting", "residual_tolerance": 1e-6}
    },
    "feedback": {"nmpc_controller": {"method": "feedback"}},
    "slsqp": {"nmpc_controller": {"method": "slsqp"}},
    "fsolve": {"nmpc_controller": {"method": "fsolve"}},
    "terminal set": {"nmpc_controller": {"method": "terminal_set", "terminal_set": "false"}},
    "the ladder": {"nmpc_controller": {"max_iterations": 1}},
    "several integrator steps": {
        "plant": {"time_step": 0.1},
        "nmpc_controller": {"time_step": 0.4},
    },
    "no limit": {"nmpc_controller": {"max_torque": 0.0}},
    "four actuators": {
        "nmpc_controller": {
            "actuators": [1.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.5]
        }
    },
    "a zone": {
        "nmpc_controller": {
            "zone_names": ["star"],
            "zones": {
                "star": {
                    "body_axis": [1.0, 0.0, 0.0],
                    "inertial_axis": [0.0, 0.0, 1.0],
                    "half_angle_deg": 30.0,
                }
            },
        }
    },
    "an active terminal set": TERMINAL_SET,
    "a governor": {
        "nmpc_controller": {"method": "feedback"},
        "reference_governor": {
            "governor": "attitude",
            "target_rotation_vector": [0.0, 0.0, 0.0],
            "max_momentum": 0.5,
        },
    },
}


@pytest.mark.parametrize("name", FLIGHTS)
def test_every_method_passes_and_one_changed_command_is_caught(tmp_path, name):
    flown = fly(tmp_path, sections(**FLIGHTS[name]))
    audit = audit_bag(flown)
    assert audit.passed, audit.first
    examined = {check.name for check in audit.checks if check.steps}
    assert examined & {"command = first torque of the plan", "command of the law"}
    changed = [
        (
            topic,
            stamp,
            flipped(data, 8 * 36) if topic == "/torque_command" and step_of(data) == 3 else data,
        )
        for topic, stamp, data in messages_of(flown)
    ]
    assert changed != messages_of(flown)
    found = audit_bag(rewrite(flown, tmp_path / "changed", changed))
    assert first_of(found)[1:] == (3, "torque_command.torque[0]")


def test_a_flight_of_before_the_source_of_the_method_passes_and_is_read_as_now(tmp_path):
    """Its law's commands were called FEEDBACK, in the command and in what the plant tells."""
    flown = fly(tmp_path, sections(**FLIGHTS["feedback"]))
    former = {"/torque_command": "source", "/plant_invariants": "applied_source"}

    def renamed(source):
        return Source.FEEDBACK if source == Source.METHOD else source

    changed = [
        (topic, stamp, edited(CODEC_NAMES[topic], **{former[topic]: renamed})(data)
         if topic in former else data)
        for topic, stamp, data in messages_of(flown)
    ]  # fmt: skip
    assert changed != messages_of(flown)
    old = rewrite(flown, tmp_path / "old", changed)
    audit = audit_bag(old)
    assert audit.passed, audit.first
    assert examined(audit)["command of the law"] == 12
    trajectory, info = read_flight(old)
    assert (trajectory.source == Source.METHOD).all()
    metrics = summarize(trajectory, info.scenario)
    assert (metrics["sources"], metrics["fallback_steps"]) == ({"METHOD": 12}, 0)


def examined(audit):
    return {check.name: check.steps for check in audit.checks}


def test_every_rung_of_the_ladder_is_worked_out_again(tmp_path):
    """Feedback without a plan, corrections of one, its torques toward another target, feedback.

    The failures are forged, which the audit finds too; what the ladder made of them is right.
    """
    failing = {0, 3, 4, 5, 8, 9, 10, 11}
    scenario = sections(nmpc_controller={"continuation": "none"})
    flown = fly(tmp_path, scenario, failing=failing, targets={9: lie.exp([0.0, 0.0, 0.2])})
    audit = audit_bag(flown)
    assert [check.name for check in audit.checks if check.first] == [FAILURES]
    assert examined(audit)["rung of the ladder"] == len(failing)
    assert examined(audit)["neighboring extremal of an earlier plan"] == 4
    sources = {data[60] for topic, _, data in messages_of(flown) if topic == "/torque_command"}
    assert sources == {Source.OPTIMAL, Source.NEIGHBORING_EXTREMAL, Source.SHIFTED_PLAN,
                       Source.FEEDBACK}  # fmt: skip
    for step in (0, 9, 10):
        changed = [
            (topic, stamp, flipped(data, 8 * 36)
             if topic == "/torque_command" and step_of(data) == step else data)
            for topic, stamp, data in messages_of(flown)
        ]  # fmt: skip
        found = audit_bag(rewrite(flown, tmp_path / str(step), changed))
        ladder = next(check for check in found.checks if check.name == "command of the ladder")
        assert ladder.first == (step, "torque_command.torque[0]")


def test_a_standstill_and_the_way_out_are_worked_out_again(tmp_path):
    """Half a turn from the target every horizon rests at a saddle of the closed loop."""
    start = {"initial_rotation_vector": [math.pi, 0.0, 0.0], "initial_momentum": [0.0, 0.0, 0.0]}
    flown = fly(tmp_path, sections(plant=start))
    audit = audit_bag(flown)
    assert audit.passed, audit.first
    assert examined(audit)["command that leaves a standstill"] >= 1
    name = "SolverStatus"
    changed = [
        (topic, stamp, edited(name, closed_loop_radius=1e-3)(data)
         if topic == "/solver_status" and step_of(data) == 0 else data)
        for topic, stamp, data in messages_of(flown)
    ]  # fmt: skip
    found = audit_bag(rewrite(flown, tmp_path / "changed", changed))
    assert first_of(found) == ("standstill", 0, "solver_status.closed_loop_radius")


def test_the_multiplier_of_an_active_terminal_set_is_found(tmp_path):
    flown = fly(tmp_path, sections(**FLIGHTS["an active terminal set"]))
    with open_bag(flown) as bag:
        text, defaults = scenario_texts(bag.attachments())
        scenario, _ = parse_scenario(text, bag.path, defaults=defaults)
        evidence = read_evidence(bag, AUDIT.topics, scenario, None, None)
        (block,) = evidence.solves()
        certifier = Certifier.from_scenario(evidence.scenario)
        auditor = SolverAudit(evidence, certifier, Ledger(), Counts())
        found = certifier.certify(auditor._plans(block.steps, block.fields))
    assert found.multiplier[0] > 1e-3
    assert found.residual.max() < 1e-9


def test_a_free_run_holds_the_last_torque_and_then_none_as_its_plant_counts(tmp_path):
    free = {"mode": "free_run", "max_held_steps": 2}
    late = {2, 5, 6, 7, 9}
    flown = fly(tmp_path, sections(plant=free), late=late)
    audit = audit_bag(flown)
    assert audit.passed, audit.first
    assert examined(audit)["torque where no command came in time"] == len(late)
    assert examined(audit)["applied torque = command"] == 12 - len(late)
    lost = [  # the answer to step 5 never came, and is not needed
        item for item in messages_of(flown)
        if item[1] != 5 * NS
        or item[0] not in {"/torque_command", "/solver_status", "/attitude_error"}
    ]  # fmt: skip
    audit = audit_bag(rewrite(flown, tmp_path / "lost", lost))
    assert audit.passed, audit.first
    for step in (2, 6, 7):  # held, held again, zero: none of them may be another torque
        changed = [
            (topic, stamp, flipped(data, 8 * 76)
             if topic == "/plant_invariants" and step_of(data) == step + 1 else data)
            for topic, stamp, data in messages_of(flown)
        ]  # fmt: skip
        found = audit_bag(rewrite(flown, tmp_path / str(step), changed))
        expected = ("torque where no command came in time", step, f"{APPLIED}[0]")
        assert first_of(found) == expected


def test_a_late_torque_that_the_plant_does_not_count_is_no_excuse(tmp_path):
    flown = fly(tmp_path, sections(plant={"mode": "free_run"}), late={4})
    changed = [
        (topic, stamp, edited("WallTiming", held_commands=lambda _: 0)(data)
         if topic == "/wall_timing" else data)
        for topic, stamp, data in messages_of(flown)
    ]  # fmt: skip
    found = audit_bag(rewrite(flown, tmp_path / "changed", changed))
    assert first_of(found) == ("applied torque = command", 4, f"{APPLIED}[0]")


def test_a_lockstep_time_out_is_excused_where_the_plant_counts_it(tmp_path):
    """Without a command in time the plant of a lockstep flight applies none, and counts it."""
    flown = fly(tmp_path, sections(plant={"max_held_steps": 0}), late={4})
    audit = audit_bag(flown)
    assert audit.passed, audit.first
    assert examined(audit)["torque where no command came in time"] == 1
