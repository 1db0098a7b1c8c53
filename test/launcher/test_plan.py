"""What is decided before anything starts."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from spacecraft_gnc.launcher.plan import LaunchRefused, make_plan
from spacecraft_gnc.scenario import InvalidScenario, from_sections, read_sections

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
