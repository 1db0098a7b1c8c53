"""What is decided before anything starts."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from spacecraft_gnc.launcher.environment import MiddlewareMissing
from spacecraft_gnc.launcher.plan import LaunchRefused, make_plan
from spacecraft_gnc.scenario import InvalidScenario, from_sections, load, read_sections
from spacecraft_gnc.vehicles.rigid_body.planner.file import save_plan
from spacecraft_gnc.vehicles.rigid_body.planner.transfer import first_plan

CASE1 = Path(__file__).resolve().parents[2] / "config" / "gupta2015_case1.yaml"


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_the_file_is_handed_on_unchanged() -> None:
    plan = make_plan(CASE1)
    assert plan.parameter_file == CASE1
    assert plan.out == Path("runs/gupta2015_case1-1")
    assert plan.records
    assert list(plan.out.iterdir()) == []
    assert make_plan(CASE1).out == Path("runs/gupta2015_case1-2")


def test_overrides_are_merged_into_a_file_of_the_run() -> None:
    plan = make_plan(CASE1, ["plant.duration=2"], out=Path("x"), record=False)
    assert plan.parameter_file == Path("x/scenario.yaml")
    merged = from_sections(read_sections(plan.parameter_file))  # as a node reads it
    assert merged.plant.duration == 2.0
    assert merged.plant.peers == ("nmpc_controller", "reference_governor")
    assert not plan.records


def test_a_file_that_a_scenario_names_is_found_from_the_file_of_the_run(tmp_path: Path) -> None:
    file = tmp_path / "given" / "s.yaml"
    file.parent.mkdir()
    text = "      duration: 19.0"
    given = (
        (CASE1.parent / "phogat_figure4.yaml")
        .read_text()
        .replace(text, f"      file: beside/plan.npz\n{text}")
    )
    file.write_text(given)
    plan = file.parent / "beside" / "plan.npz"
    plan.parent.mkdir()
    save_plan(plan, first_plan(load("phogat_figure4")))
    assert make_plan(file, out=Path("x")).parameter_file == file
    saved = make_plan(file, ["plant.duration=26.0"], out=Path("y"))
    assert saved.scenario.controller.plan.file == str(plan)
    assert saved.parameter_file.parent == Path("y")


def test_a_flight_cut_short_can_be_launched_again_from_its_file() -> None:
    short = "plant.duration=2.0"  # far too short for the target
    saved = make_plan(CASE1, [short], out=Path("x")).parameter_file
    assert make_plan(saved).scenario.plant.duration == 2.0
    whole = make_plan(CASE1, ["nmpc_controller.horizon=6"], out=Path("y")).scenario
    assert not whole.launcher.cut_short
    text = saved.read_text().replace("cut_short: true", "cut_short: false")
    saved.write_text(text)
    with pytest.raises(InvalidScenario, match=r"plant\.duration: received 2\.0 s"):
        make_plan(saved)


def test_refusals(tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario, match=r"plant\.durations"):
        make_plan(CASE1, ["plant.durations=2"], out=Path("y"))
    assert not Path("y").exists()
    with pytest.raises(LaunchRefused, match="the plant among them"):
        make_plan(CASE1, ["launcher.nodes=[recorder]"])
    Path("full").mkdir()
    Path("full/file").write_text("")
    with pytest.raises(LaunchRefused, match="which holds files"):
        make_plan(CASE1, out=Path("full"))
    with pytest.raises(LaunchRefused, match=r"Not a directory.*required"):
        make_plan(CASE1, out=Path("full/file/x"))


def test_a_name_that_ros_cannot_take_is_refused(tmp_path: Path) -> None:
    latin = os.fsdecode(b"caf\xe9")
    with pytest.raises(LaunchRefused, match=r"required UTF-8, which ROS 2 needs; rename it"):
        make_plan(tmp_path / f"{latin}.yaml")
    with pytest.raises(LaunchRefused, match="required UTF-8"):
        make_plan(CASE1, out=tmp_path / latin)
    assert not any(tmp_path.iterdir())


@pytest.fixture
def no_middleware(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name a middleware that is not installed; return how that is refused."""
    index = tmp_path / "share" / "ament_index" / "resource_index" / "rmw_typesupport"
    index.mkdir(parents=True)
    for name in ("rmw_fastrtps_cpp", "rmw_implementation"):
        (index / name).touch()
    monkeypatch.setattr(sys, "prefix", "/nowhere")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f":{tmp_path}")
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_none_cpp")
    return (
        "RMW_IMPLEMENTATION: received 'rmw_none_cpp'; required a middleware that is installed "
        "(rmw_fastrtps_cpp); unset it, or install rmw_none_cpp"
    )


def test_a_missing_middleware_is_told_before_a_folder_is_made(
    no_middleware: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(MiddlewareMissing, match=re.escape(no_middleware)):
        make_plan(CASE1, out=Path("run"))
    assert not Path("run").exists()
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    assert make_plan(CASE1, out=Path("run")).out.is_dir()


@pytest.mark.parametrize(
    "words",
    [("nodes.plant",), ("cli.main", "inspect", "nodes"), ("cli.main", "launch", str(CASE1))],
    ids=["node", "inspect", "launch"],
)
def test_a_process_without_its_middleware_ends_with_one_line(
    words: tuple[str, ...], no_middleware: str
) -> None:
    module, *arguments = words
    ended = subprocess.run(
        [sys.executable, "-m", f"spacecraft_gnc.{module}", *arguments],
        env=os.environ | {"PYTHONPATH": str(CASE1.parents[1])},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (ended.returncode, ended.stdout) == (2, "")
    (line,) = ended.stderr.splitlines()
    assert line.startswith("error: RMW_IMPLEMENTATION: received 'rmw_none_cpp'; required a midd")
    assert not Path("runs").exists()
