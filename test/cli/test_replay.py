"""``gnc replay`` without a graph, as a user meets it."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from recording.bags import flight_messages, record

from spacecraft_gnc.cli.main import main
from spacecraft_gnc.launcher import domain
from spacecraft_gnc.scenario import load

CASE1 = Path(__file__).parents[2] / "config" / "gupta2015_case1.yaml"
SHORT = {"plant.duration": 16.0, "launcher.cut_short": True}


@pytest.fixture(scope="module")
def flown():
    scenario = load(CASE1, SHORT)
    return scenario, scenario.build().run()


@pytest.fixture
def bag(flown, tmp_path):
    scenario, flight = flown
    return record(tmp_path / "bag", flight_messages(flight), scenario.to_yaml())


def run(*arguments):
    """Run ``gnc replay`` and return its exit code."""
    with pytest.raises(SystemExit) as ended:
        main(["replay", *map(str, arguments)])
    return ended.value.code or 0


def refusal(capsys, *arguments):
    """Return the one line that a refusal prints."""
    assert run(*arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1, captured.err
    return captured.err


def test_a_lockstep_flight_is_repeated_exactly(bag, capsys):
    assert run(bag) == 0
    out = capsys.readouterr().out
    assert "40 of 40 steps solved again by shooting, warm along the flight" in out
    assert "40 of 40 steps, bit for bit: the flight is repeated exactly" in out
    assert "torque difference   0 N m in every step" in out
    assert "cost difference     0 in every step" in out


def test_naming_the_method_that_flew_is_the_same_check(bag, capsys):
    assert run(bag, "--method", "shooting", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["check"] == "exact"
    assert answer["torque_difference_max"] == answer["cost_difference_max"] == 0.0


def test_a_torque_that_the_controller_did_not_command_is_found(flown, tmp_path, capsys):
    scenario, flight = flown
    torque = flight.torque.copy()
    torque[7, 1] = np.nextafter(torque[7, 1], 1.0)
    items = flight_messages(replace(flight, torque=torque))
    bag = record(tmp_path / "bag", items, scenario.to_yaml())
    assert run(bag) == 1
    captured = capsys.readouterr()
    assert "39 of 40 steps, bit for bit; the first other one at step 7" in captured.out
    assert captured.err.startswith(f"error: {bag}: step 7: shooting commands another torque")


def test_in_free_run_nothing_has_to_repeat(flown, tmp_path, capsys):
    _, flight = flown
    torque = flight.torque + 1e-6
    free = load(CASE1, SHORT | {"plant.mode": "free_run"})
    bag = record(tmp_path / "bag", flight_messages(replace(flight, torque=torque)), free.to_yaml())
    assert run(bag, "--json") == 0
    assert json.loads(capsys.readouterr().out)["check"] is None


def test_another_method_is_compared(bag, tmp_path, capsys):
    assert run(bag, "--method", "fsolve", "--out", tmp_path / "figures", "--steps", ":10") == 0
    out = capsys.readouterr().out
    assert "10 of 40 steps solved again by fsolve" in out
    assert "method              shooting" in out
    files = [Path(line) for line in out.splitlines() if line.startswith(str(tmp_path / "fig"))]
    assert [file.name for file in files] == ["replay.png", "replay.svg"]
    assert all(file.stat().st_size > 1000 for file in files)


def test_a_penalty_is_told_apart_from_the_cost(bag, capsys):
    assert run(bag, "--set", "nmpc_controller.max_torque=0.02") == 0
    rows = dict(
        re.split(r"  +", line.strip(), maxsplit=1)
        for line in capsys.readouterr().out.splitlines()[2:]
    )
    assert rows["cost difference"].startswith("-4.9")
    assert rows["cost difference"].endswith(" rms, without penalties")
    assert re.fullmatch(
        r"[\d.]+ at the most \(step 0, 0 s\): the plan replayed is 0.01 N m above the torque limit",
        rows["penalties"],
    )


def test_what_a_law_has_not_is_a_dash_and_no_zero(bag, capsys):
    assert run(bag, "--method", "feedback") == 0
    out = capsys.readouterr().out
    assert re.search(r"steps not solved +0 +-\n", out)
    assert re.search(r"torque from +OPTIMAL 40 +METHOD 40\n", out)


def test_changed_weights_are_compared(bag, capsys):
    assert run(bag, "--set", "nmpc_controller.weights.stage_torque=4.0", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["check"] is None
    assert answer["torque_difference_max"] > 1e-3
    assert answer["cost_difference_max"] > 0.0
    assert answer["identical_steps"] == 0


def test_a_cold_start_is_said(bag, capsys):
    assert run(bag, "--cold") == 0
    assert "each from a cold start" in capsys.readouterr().out


def test_quiet_prints_nothing(bag, capsys):
    assert run(bag, "--quiet") == 0
    assert capsys.readouterr() == ("", "")


def test_a_simulated_flight_needs_its_scenario(flown, tmp_path, capsys):
    file = flown[1].save(tmp_path / "flight.npz")
    assert "name it with --scenario" in refusal(capsys, file)
    assert run(file, "--scenario", CASE1) == 0
    assert "the flight is repeated exactly" in capsys.readouterr().out
    other = tmp_path / "other.yaml"
    heavier = load(CASE1, {"nmpc_controller.weights.stage_torque": 4.0})
    other.write_text(heavier.to_yaml())
    assert run(file, "--scenario", other) == 1
    assert "find out whether --scenario names what flew, and" in capsys.readouterr().err


def test_a_bag_without_a_scenario_is_refused(flown, tmp_path, capsys):
    bag = record(tmp_path / "bag", flight_messages(flown[1]))
    assert "received a flight without a scenario; required" in refusal(capsys, bag)


def test_what_the_method_does_not_read_is_named(flown, tmp_path, capsys):
    _, flight = flown
    estimated = load(CASE1, SHORT | {"nmpc_controller.variant": "estimated_du"})
    bag = record(tmp_path / "bag", flight_messages(flight), estimated.to_yaml())
    assert run(bag, "--method", "feedback") == 0
    assert "not read            variant" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--method", "bogus"], "--method: nmpc_controller.method: received 'bogus'"),
        (["--method", "terminal_set"], "infeasible from the start"),
        (["--set", "nmpc_controller.weight=1"], "nmpc_controller.weight: received an unknown"),
        (["--set", "nmpc_controller.horizon=0"], "nmpc_controller.horizon: received 0"),
        (["--set", "horizon=3"], "--set: horizon: received 3; required NODE.PARAMETER"),
        (["--steps", "5"], "--steps: received '5'; required A:B"),
        (["--steps", "30:90"], "--steps: received 30:90; required A:B with 0 <= A < B <= 40"),
        (["--rate", "2"], "--rate: received 2; required"),
        (["--loop"], "add --publish"),
        (["--publish", "--method", "slsqp"], "leave --method or --publish out"),
        (["--publish", "--rate", "-1"], "--rate: received '-1'; required a number >= 0"),
        (["--publish", "--rate", "nan"], "--rate: received 'nan'"),
        (["--publish", "--rate", "fast"], "--rate: received 'fast'"),
        (["--publish", "--start", "17"], "--start: received 17 s; required 0 to 16 s"),
        (["--publish", "--start", "-1"], "--start: received -1 s"),
        (["--publish", "--start", "nan"], "--start: received nan s"),
        (["--publish", "--patience", "-1"], "--patience: received -1"),
        (["--publish", "--topics", "bogus"], "--topics: received 'bogus'; required a topic of"),
        (["--publish", "--wait-for", "bogus"], "--wait-for: received 'bogus'"),
        (["--scenario", "missing.yaml"], "missing.yaml"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(bag, capsys, arguments, words):
    assert words in refusal(capsys, bag, *arguments)


def test_a_folder_that_is_a_file_is_refused_before_anything_is_solved(bag, tmp_path, capsys):
    file = tmp_path / "figures"
    file.write_text("mine")
    assert "a file; required a folder" in refusal(capsys, bag, "--out", file)
    told = refusal(capsys, bag, "--out", file / "deeper")
    assert f"in {file}, which is a file; required a folder" in told
    assert file.read_text() == "mine"


@pytest.mark.parametrize("options", [[], ["--publish"]])
def test_what_is_no_bag_is_refused(tmp_path, capsys, options):
    assert "no such file or folder" in refusal(capsys, tmp_path / "none", *options)
    assert "a folder without a bag" in refusal(capsys, tmp_path, *options)


def test_arrays_cannot_be_published(flown, tmp_path, capsys):
    file = flown[1].save(tmp_path / "flight.npz")
    assert "required a bag" in refusal(capsys, file, "--publish")


def test_a_domain_in_use_is_refused(bag, capsys):
    lock = domain.claim_free({"test": "replay"})
    try:
        arguments = (bag, "--publish", "--domain-id", lock.domain_id)
        assert "where another graph runs (pid" in refusal(capsys, *arguments)
    finally:
        lock.release()
