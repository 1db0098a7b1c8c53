"""``gnc plan`` as a user meets it, and what reads its file."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from spacecraft_gnc import lie
from spacecraft_gnc.cli.main import main
from spacecraft_gnc.dynamics import RigidBody
from spacecraft_gnc.scenario import load
from spacecraft_gnc.vehicles.rigid_body.planner.file import load_plan

FIGURE_4 = "phogat_figure4"
REFERENCE = 20965.95496
REFERENCE_SETS = {
    ("torque", "y", "upper", 0, 5),
    ("torque", "y", "lower", 179, 189),
    ("torque", "z", "upper", 0, 3),
    ("momentum", "z", "upper", 58, 79),
    ("momentum", "y", "upper", 70, 132),
}
PLAN = "nmpc_controller.plan"


def run(capsys: pytest.CaptureFixture[str], *argv: object) -> tuple[int, str, str]:
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in argv])
    captured = capsys.readouterr()
    return int(end.value.code or 0), captured.out, captured.err


def changed(*values: str) -> list[str]:
    return [word for value in values for word in ("--set", value)]


@pytest.fixture
def stored(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    file = tmp_path / "plan.npz"
    assert run(capsys, "plan", FIGURE_4, "-o", file, "--quiet") == (0, "", "")
    return file


def test_figure_4_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "plan", FIGURE_4)
    assert (code, err) == (0, "")
    first, *lines = out.splitlines()
    assert first.startswith("phogat_figure4: planned in ")
    assert max(map(len, out.splitlines())) <= 80
    rows = {line[2:20].strip(): line[20:] for line in lines}
    assert rows["transfer"] == "90 deg in 19 s, 190 control steps of 0.1 s"
    assert rows["torque bounds"] == "+-20 N m"
    assert rows["status"] == "converged"
    assert rows["cost"] == "20965.95496 N^2 m^2, sum of |u|^2 / 2 over the steps"
    assert "2096.595496 N^2 m^2 s, the integral: cost times 0.1 s" in out
    assert rows["largest torque"] == "x 16.6262, y 20, z 20 N m"
    assert rows["second order"] == "least eigenvalue of the reduced Hessian: 0.895 or more"
    assert "momentum y = 70 N m s, steps 70 to 132 (7 to 13.2 s)" in out
    assert "torque y = -20 N m, steps 179 to 189 (17.9 to 19 s)" in out
    assert "eigenaxis: converged, cost 20965.95496" in out
    assert rows["shortest time"].startswith("no torque within the bounds makes it in less than ")


def test_figure_4_in_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "plan", FIGURE_4, "--json")
    told = json.loads(out)
    assert (code, err) == (0, "")
    assert told["status"] == "converged"
    assert told["cost"] == pytest.approx(REFERENCE, abs=1e-5)
    assert told["residual"] < 1e-8
    assert told["cost_integral"] == pytest.approx(0.1 * REFERENCE, abs=1e-6)
    assert (told["steps"], told["period"], told["duration"]) == (190, 0.1, 19.0)
    assert told["iterations"] > 0
    found = {
        tuple(one[key] for key in ("bound", "axis", "side", "first", "last"))
        for one in told["active"]
    }
    assert found == REFERENCE_SETS
    assert {one["value"] for one in told["active"]} == {20.0, -20.0, 70.0}
    assert len(told["tried"]) >= 3
    assert {one["status"] for one in told["tried"]} == {"converged"}
    assert (told["problems"], told["warnings"], told["out"]) == ([], [], None)


def test_file_flies_from_the_start_to_the_target(stored: Path) -> None:
    with np.load(stored) as members:
        arrays = {name: members[name] for name in members.files}
    scenario = load(FIGURE_4)
    body = RigidBody(scenario.controller.inertia, 0.1)
    attitudes, momenta = body.simulate(
        lie.exp(scenario.plant.initial_rotation_vector),
        scenario.plant.initial_momentum,
        arrays["torque"],
    )
    target = lie.exp(scenario.governor.target_rotation_vector)
    assert lie.angle_between(attitudes[-1], target) < 1e-12
    assert np.allclose(momenta, arrays["momentum"], atol=1e-10)
    assert np.abs(arrays["torque"]).max() <= 20.0
    assert np.abs(arrays["momentum"]).max() <= 70.0 + 1e-10
    assert "phogat" not in str(arrays["scenario"])
    assert "torque_bounds: [20.0]" in str(arrays["scenario"])


def test_shortest_time_is_the_shortest(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(capsys, "plan", FIGURE_4, "--shortest", "--json")
    told = json.loads(out)
    assert code == 0
    assert told["is_shortest"]
    assert told["shortest_possible"] <= told["duration"] < 19.0
    shorter = round(told["duration"] - 0.1, 1)
    code, out, _ = run(capsys, "plan", FIGURE_4, "--json", *changed(f"{PLAN}.duration={shorter}"))
    refused = json.loads(out)
    assert code == 2
    assert refused["status"] != "converged"
    (problem,) = refused["problems"]
    assert problem["key"] == f"{PLAN}.duration"
    shortest = f"{told['duration']:g} s is the shortest found"
    assert problem["requirement"].startswith(f"more: {shortest} (no torque within the bounds")
    code, out, _ = run(capsys, "plan", FIGURE_4, "--shortest")
    assert f"this one: no plan was found in {shorter:g} s" in out


def test_plan_that_stays_where_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    still = changed("reference_governor.target_rotation_vector=[0.0, 0.0, 0.0]")
    still += changed("plant.initial_momentum=[0.0, 0.0, 0.0]")
    file = tmp_path / "still.npz"
    code, out, _ = run(capsys, "plan", FIGURE_4, "-o", file, *still)
    assert code == 0
    assert "0 deg in 19 s" in out
    assert run(capsys, "report", file, "-o", tmp_path / "still.html", "-q") == (0, "", "")
    assert run(capsys, "plot", file, "-o", tmp_path, "-f", "png", "-q") == (0, "", "")
    code, out, _ = run(capsys, "plan", FIGURE_4, "--shortest", *still)
    assert code == 0
    assert "this one: no plan has fewer steps" in out
    assert "makes it in less" not in out


def test_reserve_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    reserve = changed(f"{PLAN}.torque_reserve=0.05", f"{PLAN}.momentum_bounds=[]")
    code, out, _ = run(capsys, "plan", FIGURE_4, *reserve)
    assert code == 0
    rows = {line[2:20].strip(): line[20:] for line in out.splitlines()}
    assert rows["torque bounds"] == "+-19 N m"
    assert "(already less the reserve of 5 %)" in out
    assert rows["momentum bounds"] == "none"
    told = json.loads(run(capsys, "plan", FIGURE_4, "--json", *reserve)[1])
    assert told["reserves"] == [0.05, 0.0]
    assert told["momentum_bounds"] == [[None] * 3] * 2
    assert max(told["max_torque"]) <= 19.0


def test_bounds_may_be_one_sided(capsys: pytest.CaptureFixture[str]) -> None:
    bounds = changed(f"{PLAN}.torque_bounds=[-15.0, -.inf, -20.0, .inf, 18.0, 20.0]")
    code, out, _ = run(capsys, "plan", FIGURE_4, *bounds)
    assert code == 0
    assert "x at least -15, y at most 18, z +-20 N m" in out
    assert max(map(len, out.splitlines())) <= 80


def test_governor_that_plans(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "governed.yaml"
    text = Path(load(FIGURE_4).path).read_text(encoding="utf-8")
    head, _, rest = text.partition("    plan:\n")
    plan, _, rest = rest.partition("reference_governor:")
    text = f"{head}reference_governor:{rest}".replace("method: planned", "method: shooting")
    text = text.replace("governor: none", f"governor: planned\n    plan:\n{plan.rstrip()}")
    file.write_text(text, encoding="utf-8")
    code, out, _ = run(capsys, "plan", file, "--json")
    assert code == 0
    assert json.loads(out)["cost"] == pytest.approx(REFERENCE, abs=1e-5)
    code, _, err = run(capsys, "plan", file, *changed("reference_governor.plan.duration=12.05"))
    assert code == 2
    assert "reference_governor.plan.duration: received 12.05 s; required a whole number" in err


REFUSED = {
    "time too short": (
        [f"{PLAN}.duration=10.0"],
        f"{PLAN}.duration: received 10 s, in which no plan was found; required more: 17.6 s",
    ),
    "zero duration": ([f"{PLAN}.duration=0.0"], f"{PLAN}.duration: received 0.0; required a "),
    "no step": ([f"{PLAN}.duration=0.01"], f"{PLAN}.duration: received 0.01 s; required a whole"),
    "part of a step": ([f"{PLAN}.duration=19.04"], "give 19"),
    "too many steps": ([f"{PLAN}.duration=1.0e6"], "10000000 control periods; required at most"),
    "far too short": (
        [f"{PLAN}.torque_bounds=[1.0e-6]"],
        f"{PLAN}.duration: received 19 s; required more than 500 s: no torque within the bounds",
    ),
    "bound of zero": ([f"{PLAN}.torque_bounds=[0.0]"], f"{PLAN}.torque_bounds: received"),
    "bounds of the wrong side": (
        [f"{PLAN}.momentum_bounds=[1.0, -1.0, -1.0, 2.0, 2.0, 2.0]"],
        f"{PLAN}.momentum_bounds: received",
    ),
    "number of bounds": ([f"{PLAN}.momentum_bounds=[1.0, 2.0]"], f"{PLAN}.momentum_bounds: rec"),
    "initial momentum outside": (
        ["plant.initial_momentum=[0.0, 71.0, 0.0]"],
        "plant.initial_momentum: received [0.0, 71.0, 0.0]",
    ),
    "initial momentum in the reserve": (
        ["plant.initial_momentum=[0.0, 69.0, 0.0]", f"{PLAN}.momentum_reserve=0.05"],
        "plant.initial_momentum: received [0.0, 69.0, 0.0]",
    ),
    "plan file that is missing": (
        [f"{PLAN}.file=none.npz", "plant.duration=0.0"],
        "plant.duration: received 0.0",
    ),
    "nothing plans": (["nmpc_controller.method=shooting"], "neither plans a transfer"),
    "an attitude that is none": (
        ["reference_governor.target_rotation_vector=[.nan, 0.0, 0.0]"],
        "reference_governor.target_rotation_vector: received [nan, 0.0, 0.0]",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bad_input_is_one_line(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    values, expected = REFUSED[name]
    code, out, err = run(capsys, "plan", FIGURE_4, *changed(*values))
    assert (code, out) == (2, "")
    line = err.splitlines()[-1]
    assert [text for text in err.splitlines() if not text.startswith("warning: ")] == [line]
    assert line.startswith("error: ")
    assert expected in line
    assert "Traceback" not in err


def test_what_makes_a_scenario_plan_is_told_and_works(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, "plan", "gupta2015_case1")
    assert code == 2
    told = shlex.split(err.partition("; add ")[2].partition(", or other bounds")[0])
    assert told[::2] == ["--set"] * 4
    assert "nmpc_controller.plan.torque_bounds=[0.01]" in told
    code, out, _ = run(capsys, "plan", "gupta2015_case1", *told, "--json")
    planned = json.loads(out)
    assert (code, planned["status"], planned["duration"]) == (0, "converged", 150.0)
    assert planned["torque_bounds"] == [[-0.01] * 3, [0.01] * 3]
    assert run(capsys, "check", "gupta2015_case1", *told, "-q")[0] == 0


def test_scenario_with_zones_is_to_be_written_anew(capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = run(capsys, "plan", "gupta2015_case2")
    assert (code, len(err.splitlines())) == (2, 1)
    assert "write a file like that of phogat_figure4: method: planned, plan.duration, " in err


def test_vehicle_that_plans_nothing_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "plan", "afrl_two_wheel")
    assert (code, out) == (2, "")
    assert "plant.vehicle: received 'two_wheel', which plans no transfers; required" in err
    assert len(err.splitlines()) == 1


def test_one_of_several_spacecraft_is_to_be_named(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "plan", "two_spacecraft")
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert "--namespace" in err


def test_output_that_cannot_be_written_is_refused_first(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, _, err = run(capsys, "plan", FIGURE_4, "--out", tmp_path / "plan.txt")
    assert code == 2
    assert "received" in err
    assert "no .npz file" in err
    code, _, err = run(capsys, "plan", FIGURE_4, "--out", tmp_path / "none" / "plan.npz")
    assert code == 2
    assert "in a folder that does not exist" in err


def test_plan_that_is_not_found_is_not_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "plan.npz"
    code, _, _ = run(capsys, "plan", FIGURE_4, "-o", file, *changed(f"{PLAN}.duration=10.0"))
    assert code == 2
    assert list(tmp_path.iterdir()) == []


def test_report_is_a_page_of_the_plan(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "plan.html"
    code, out, _ = run(capsys, "report", stored, "-o", page, "--json")
    told = json.loads(out)
    assert code == 0
    (shown,) = told["runs"]
    assert shown["audit"]["passed"] is True
    assert shown["metrics"]["cost"] == pytest.approx(REFERENCE, abs=1e-5)
    assert shown["metrics"]["solve_time"] is None
    text = page.read_text(encoding="utf-8")
    for heading in (
        "Torque", "Angular momentum", "Co-momentum", "Co-state of the attitude",
        "Multipliers of the torque bounds", "Conditions of the optimum", "Scenario as planned",
    ):  # fmt: skip
        assert f">{heading}<" in text
    assert "stationarity of the torque" in text
    assert "momentum z = 70 N m s, steps 58 to 79" in text
    assert "Flown by" not in text


def test_plans_are_compared(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    longer, page = tmp_path / "longer.npz", tmp_path / "both.html"
    assert (
        run(capsys, "plan", FIGURE_4, "-o", longer, "-q", *changed(f"{PLAN}.duration=21.0"))[0] == 0
    )
    assert run(capsys, "report", stored, longer, "-o", page, "-q") == (0, "", "")
    text = page.read_text(encoding="utf-8")
    assert "+10.5 %" in text  # of the duration
    assert run(capsys, "plot", stored, longer, "-o", tmp_path / "drawn", "-f", "png", "-q")[0] == 0
    drawn = {file.name for file in (tmp_path / "drawn").iterdir()}
    assert {"overview.png", "torque.png", "co_momentum.png"} <= drawn


def test_plot_draws_control_momentum_and_co_states(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "drawn"
    code, out, _ = run(capsys, "plot", stored, "-o", folder, "-f", "svg", "--json")
    told = json.loads(out)
    assert code == 0
    assert told["metrics"]["steps"] == 190
    assert {Path(file).stem for file in told["files"]} == {
        "overview", "torque", "momentum", "co_momentum", "attitude_co_state",
        "torque_multipliers", "momentum_multipliers", "attitude",
    }  # fmt: skip
    assert all(Path(file).stat().st_size > 1000 for file in told["files"])


def test_picture_tells_its_lines(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The torque is -gamma within its bounds: gamma's lines are theirs with the other sign."""
    drawn: dict[str, Figure] = {}

    def keep(figures: Iterable[tuple[str, Figure]], *_: object) -> list[Path]:
        drawn.update(figures)
        return []

    monkeypatch.setattr("spacecraft_gnc.drawing.figures.save_figures", keep)
    bounds = changed(f"{PLAN}.torque_bounds=[-30.0, -19.0, -25.0, 30.0, 21.0, 25.0]")
    file = tmp_path / "plan.npz"
    assert run(capsys, "plan", FIGURE_4, "-o", file, "-q", *bounds)[0] == 0
    assert run(capsys, "plot", file, "-q")[0] == 0
    for name, told in {
        "overview": ["bound", "while it acts", "no bound: beyond it the torque, "],
        "co_momentum": ["no bound: beyond it the torque, "],
        "attitude_co_state": [],
    }.items():
        texts = [text.get_text() for one in drawn[name].legends for text in one.get_texts()]
        assert [text.partition("$")[0] for text in texts] == told
    _, y, _ = drawn["co_momentum"].axes
    (low, high) = (float(line.get_ydata()[0]) for line in y.lines[1:])
    assert (low, high) == (-21.0, 19.0)
    with np.load(file) as plan:
        torque, gamma = plan["torque"][:, 1], plan["co_momentum"][:, 1]
    assert np.allclose(torque, -np.clip(gamma, low, high), atol=1e-6)
    assert (gamma < low).any()
    assert (gamma > high).any()


@pytest.mark.parametrize(
    "words",
    [
        ("view",),
        ("audit",),
        ("replay",),
        ("replay", "--method", "shooting"),
        ("replay", "--publish"),
        ("export", "--format", "csv"),
    ],
    ids=" ".join,
)
def test_what_needs_a_flight_refuses_a_plan_in_one_line(
    words: tuple[str, ...], stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = run(capsys, words[0], stored, *words[1:])
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.startswith(f"error: {stored}: received a plan of gnc plan; required a flight, ")
    assert "gnc report shows the plan" in err


def test_plan_does_not_move(stored: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "plot", stored, "--animate", "x.gif")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "a plan; required a flight" in err


def test_plan_and_flight_do_not_share_a_page(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flight = tmp_path / "flight.npz"
    short = changed("plant.duration=4.0")
    assert run(capsys, "simulate", "gupta2015_case1", "-o", flight, "-q", *short)[0] == 0
    for command in ("report", "plot"):
        code, _, err = run(capsys, command, flight, stored, "-o", tmp_path / "x.html")
        assert (code, len(err.splitlines())) == (2, 1)
        assert f"{stored}: received a plan of gnc plan beside flights ({flight}); required" in err


def test_plan_beside_a_flight_is_refused_before_that_is_read(
    stored: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "flight").mkdir()  # holds nothing that could be read
    code, _, err = run(capsys, "report", stored, tmp_path / "flight", "-o", tmp_path / "x.html")
    assert code == 2
    assert f"beside flights ({tmp_path / 'flight'}); required plans alone or flights alone" in err


def test_damaged_file_is_refused_in_one_line(
    stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with np.load(stored) as members:
        arrays = {name: members[name] for name in members.files}
    np.savez(stored, **{**arrays, "torque": arrays["torque"] + 1e-3})
    code, _, err = run(capsys, "report", stored)
    assert code == 2
    assert "received a plan that violates its conditions by" in err
    assert len(err.splitlines()) == 1


def test_file_holds_the_scenario_with_what_was_laid_over_it(
    stored: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (
        run(capsys, "plan", FIGURE_4, "-o", stored, "-q", *changed(f"{PLAN}.duration=20.0"))[0] == 0
    )
    found = load_plan(stored)
    assert "duration: 20.0" in found.scenario
    assert math.isclose(found.solution.problem.duration, 20.0)


def test_plan_is_flown_from_the_current_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "runs").mkdir()
    monkeypatch.chdir(tmp_path)
    short = changed("plant.duration=1.0")
    assert run(capsys, "plan", FIGURE_4, "--out", "runs/plan.npz", "-q") == (0, "", "")
    flown = changed(f"{PLAN}.file=runs/plan.npz")
    assert run(capsys, "simulate", FIGURE_4, "-o", "flight.npz", "-q", *short, *flown)[0] == 0
    with np.load("runs/plan.npz") as plan, np.load("flight.npz") as flight:
        assert np.allclose(flight["torque"], plan["torque"][:10], atol=1e-9)
    # what comes of the flight needs the file no more
    assert run(capsys, "replay", "flight.npz", "-q") == (0, "", "")
    code, _, err = run(capsys, "simulate", FIGURE_4, *changed(f"{PLAN}.file=plan.npz"))
    assert code == 2
    assert f"{PLAN}.file: received '{tmp_path / 'plan.npz'}', a file that cannot be read" in err
    # a path in a file is relative to that
    beside = tmp_path / "runs" / "beside.yaml"
    text = Path(load(FIGURE_4).path).read_text(encoding="utf-8")
    beside.write_text(text.replace("    plan:\n", "    plan:\n      file: plan.npz\n"))
    assert run(capsys, "simulate", beside, "-o", "second.npz", "-q", *short)[0] == 0


def test_flight_in_place_of_a_plan_is_not_to_be_overwritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    flight = tmp_path / "flight.npz"
    short = changed("plant.duration=1.0")
    assert run(capsys, "simulate", FIGURE_4, "-o", flight, "-q", *short)[0] == 0
    code, _, err = run(capsys, "simulate", FIGURE_4, *changed(f"{PLAN}.file={flight}"))
    assert code == 2
    assert f"received '{flight}', a file that is no plan of gnc plan; required" in err
    assert err.count(str(flight)) == err.count("received") == 1
    assert err.rstrip().endswith("--out ANOTHER.npz")
