"""``gnc audit`` as a user meets it."""

from __future__ import annotations

import json

import pytest
from cli.test_bad_scenarios import run
from flown_bags import SECTIONS, fly, messages_of, rewrite, sections

from spacecraft_gnc.scenario import from_sections
from spacecraft_gnc.scenario.fingerprint import fingerprint
from spacecraft_gnc.scenario.scenario import sections_to_yaml


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return fly(tmp_path_factory.mktemp("flown"))


@pytest.fixture(scope="module")
def tampered(bag, tmp_path_factory):
    """Return the bag with the lowest bit of the commanded torque of step 5 changed."""
    changed = []
    for topic, stamp, data in messages_of(bag):
        other = bytearray(data)
        if (topic, stamp) == ("/torque_command", 5 * 400_000_000):
            other[36] ^= 1
        changed.append((topic, stamp, bytes(other)))
    return rewrite(bag, tmp_path_factory.mktemp("tampered") / "bag", changed)


def test_a_flight_that_is_what_it_says(bag, capsys):
    code, out, err = run(capsys, "audit", str(bag))
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].split() == ["check", "steps", "worst", "tolerance", "verdict"]
    verdict, counts, rests = lines[-3:]
    assert verdict == f"{bag}: 12 control steps, every check that applies passed"
    assert counts == (
        "  claimed failures solved again 0, failed again 0; fallbacks justified 0 of 0; "
        "standstills looked for at 12 steps, found 0, reported 0"
    )
    assert rests == (
        f"  by the scenario in the bag, sha256 {fingerprint(from_sections(SECTIONS))}; hold it "
        "against yours with --scenario FILE"
    )
    (skipped,) = [line for line in lines if line.strip().startswith("zone margins")]
    assert "not applicable  the scenario has no zones" in skipped
    assert not any(line.endswith(" ") for line in lines)


def test_a_flight_that_is_not(tampered, capsys):
    code, out, err = run(capsys, "audit", str(tampered))
    assert code == 1
    assert "FAIL" in out
    assert "first at step 5: torque_command.torque[0]" in out
    assert err == (
        f"error: {tampered}: the first difference is at step 5, torque_command.torque[0] (command "
        "= first torque of the plan); required bit for bit; 2 of 49 checks failed\n"
    )


def test_json_and_nothing_else(bag, tampered, capsys):
    code, out, err = run(capsys, "audit", str(bag), "--json")
    answer = json.loads(out)
    assert (code, err) == (0, "")
    assert answer["passed"]
    assert answer["first"] is None
    assert answer["scenario_hash"] == fingerprint(from_sections(SECTIONS))
    assert answer["limits_exceeded"] == []
    assert answer["counts"] == {
        "solves_repeated": 0, "failures_confirmed": 0, "fallbacks": 0, "fallbacks_justified": 0,
        "standstills_looked_for": 12, "standstills_found": 0, "standstills_reported": 0,
    }  # fmt: skip
    code, out, err = run(capsys, "audit", str(tampered), "--json")
    answer = json.loads(out)
    assert code == 1
    assert not answer["passed"]
    assert answer["first"] == {
        "check": "command = first torque of the plan",
        "step": 5,
        "field": "torque_command.torque[0]",
    }
    verdicts = {check["check"]: check["verdict"] for check in answer["checks"]}
    assert verdicts["applied torque = command"] == "FAIL"
    assert verdicts["integrator, from each state"] == "pass"


def test_quiet_says_errors_only(bag, tampered, capsys):
    assert run(capsys, "audit", str(bag), "--quiet") == (0, "", "")
    code, out, err = run(capsys, "audit", str(tampered), "-q")
    assert (code, out) == (1, "")
    assert len(err.splitlines()) == 1


@pytest.mark.parametrize("value", ["-1", "nan", "inf"])
def test_a_tolerance_that_is_none(bag, capsys, value):
    code, out, err = run(capsys, "audit", str(bag), f"--tolerance={value}")
    assert (code, out) == (2, "")
    assert err.startswith("error: --tolerance: received ")
    assert "; required a number >= 0; " in err


def test_a_bag_without_a_scenario(bag, capsys, tmp_path):
    from recording.bags import TOPICS, record

    plain = record(
        tmp_path / "bag", [(t[1:], s // 400_000_000, d) for t, s, d in messages_of(bag)
                           if t[1:] in TOPICS],
    )  # fmt: skip
    code, out, err = run(capsys, "audit", str(plain))
    assert (code, out) == (2, "")
    assert "received no scenario to audit by (none is attached); required" in err


def test_a_folder_of_a_run_is_audited_too(bag, capsys):
    assert run(capsys, "audit", str(bag.parent), "--quiet") == (0, "", "")


def test_a_forged_failure_is_told_with_what_was_found(capsys, tmp_path):
    direct = sections(nmpc_controller={"continuation": "none"})
    forged = fly(tmp_path, direct, failing={0, 1})
    code, out, err = run(capsys, "audit", str(forged))
    assert code == 1
    (line,) = [line for line in out.splitlines() if line.startswith("  claimed failures, ")]
    assert "FAIL" in line
    assert (
        "first at step 0: solver_status.status: MAX_ITERATIONS claimed, but the solve conv" in line
    )
    assert "  claimed failures solved again 2, failed again 0; fallbacks justified 0 of 2; " in out
    assert err.startswith(
        f"error: {forged}: the first difference is at step 0, solver_status.status (claimed "
        "failures, solved again; MAX_ITERATIONS claimed, but the solve converges after "
    )
    assert "; required the same failure; 1 of " in err


@pytest.fixture
def file(tmp_path):
    """Return a function that writes a scenario file with changes."""

    def write(**changes):
        flown = sections(**changes)
        path = tmp_path / "mine.yaml"
        path.write_text(sections_to_yaml(flown), encoding="utf-8")
        return path

    return write


def test_the_scenario_in_the_bag_is_held_against_a_file(bag, capsys, file):
    mine = file(recorder={"compression": "none"})
    code, out, err = run(capsys, "audit", str(bag), "--scenario", str(mine))
    assert (code, err) == (0, "")
    assert out.splitlines()[-1].endswith(f", equal to {mine}")
    other = file(plant={"duration": 4.4, "max_held_steps": 3})
    code, out, err = run(capsys, "audit", str(bag), "--scenario", str(other))
    assert code == 1
    assert out.splitlines()[-2:] == [
        "    plant.duration: 4.8 in the bag, 4.4 in the file",
        "    plant.max_held_steps: 5 in the bag, 3 in the file",
    ]
    assert err == (
        f"error: {bag}: holds another scenario than {other}: plant.duration is 4.8; required "
        "4.4; 2 values differ\n"
    )
    code, out, err = run(capsys, "audit", str(bag), "--scenario", str(other), "--json")
    answer = json.loads(out)
    assert (code, answer["passed"], answer["first"]) == (1, False, None)
    assert answer["scenario_differences"][0] == {
        "name": "plant.duration", "first": "4.8", "second": "4.4",
    }  # fmt: skip


def test_a_scenario_that_is_none_is_refused(bag, capsys, tmp_path):
    code, out, err = run(capsys, "audit", str(bag), "--scenario", str(tmp_path / "none.yaml"))
    assert (code, out) == (2, "")
    assert "none.yaml: received no such file; required " in err


def test_a_limit_that_is_exceeded_is_told_and_fails_if_asked(capsys, tmp_path):
    soft = sections(nmpc_controller={"torque_penalty": 1.0})  # next to nothing for the excess
    flown = fly(tmp_path, soft)
    code, out, err = run(capsys, "audit", str(flown))
    assert code == 0
    assert "every check that applies passed" in out
    assert err.startswith(f"warning: {flown}: limits exceeded: torque ")
    assert err.endswith(" N m, limit 0.01 N m)\n")
    code, _, err = run(capsys, "audit", str(flown), "--strict", "--quiet")
    assert code == 1
    assert err.startswith(f"error: {flown}: limits exceeded: torque ")
    assert err.endswith("; --strict requires every limit kept\n")
    code, out, _ = run(capsys, "audit", str(flown), "--strict", "--json")
    (exceeded,) = json.loads(out)["limits_exceeded"]
    assert (code, exceeded["limit"], exceeded["bound"]) == (1, "torque", 0.01)
    assert exceeded["factor"] == pytest.approx(exceeded["value"] / 0.01)
    assert exceeded["factor"] > 1.1


def test_a_flight_within_its_limits_is_strictly_so(bag, capsys):
    assert run(capsys, "audit", str(bag), "--strict", "--quiet") == (0, "", "")
